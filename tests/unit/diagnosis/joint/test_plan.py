"""Plans: what cannot show does not, look-alikes are said to look alike, and expected gains are what refits give."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.plan import _posed, around, next_recording, outlook
from coast_cli.diagnosis.joint.protocols import Bench, planned, standard
from coast_cli.effects.catalogue import CATALOGUE, effects_of

NOISE = 0.25
LOAD_AND_RELEASE = (0.9e-3, 2.8e-3)


@pytest.fixture(scope="module")
def config():
    from pathlib import Path

    from coast_cli.spec.load import load_config

    return load_config(Path(__file__).parents[4] / "configs" / "tubes.toml")


def problem_of(config, lengths=(0.02,), *, tension_noise=None, bench=None, hold=0.0):
    bench = bench or Bench("MT1", "OT4", with_tension=tension_noise is not None)
    runs = standard(bench, *LOAD_AND_RELEASE, lengths, 1e-4, hold).runs
    return planned(config, runs, NOISE, tension_noise)


@pytest.fixture(scope="module")
def looks(config):
    return {one.id: one for one in outlook(problem_of(config))}


def test_every_effect_is_answered_for(looks):
    assert list(looks) == list(effects_of("joint"))


def test_effects_have_the_size_that_is_stated(looks):
    sized = [one for one in looks.values() if one.effect is not None]
    assert len(sized) > 12
    assert all(one.change == pytest.approx(5.0, rel=0.02) or one.change < 5.0 for one in sized)
    assert sum(one.change == pytest.approx(5.0, rel=0.02) for one in sized) > 12
    assert all(one.apart <= one.visible * (1.0 + 1e-9) and one.visible <= one.change * (1.0 + 1e-9) for one in sized)


def test_a_scale_hides_behind_the_modulus_at_one_length(looks):
    assert not looks["camera_scale"].is_visible


def test_what_bends_at_rest_looks_like_a_camera_offset(looks):
    assert looks["precurvature"].is_visible
    assert not looks["precurvature"].is_told_apart
    assert looks["precurvature"].closest == "camera_offset"


def test_a_release_shows_play_and_none_does_not(config, looks):
    runs = [Bench("MT1", "OT4").run("load", LOAD_AND_RELEASE, 1e-4, 0.02)]
    without = {one.id: one for one in outlook(planned(config, runs, NOISE, None))}
    assert looks["backlash"].is_told_apart
    assert without["backlash"].effect is None
    assert without["backlash"].reason == "needs a release"


def test_without_time_nothing_about_time(config):
    runs = [replace(run, time=None) for run in problem_of(config).runs]
    found = {one.id: one for one in outlook(planned(config, runs, NOISE, None))}
    assert found["sensor_lag"].reason == found["tendon_creep"].reason == "needs time"


def test_tension_tells_more_apart(config):
    def apart(tension_noise):
        return {one.id: one.apart for one in outlook(problem_of(config, tension_noise=tension_noise))}

    without, recorded = apart(None), apart(0.02)
    assert recorded["backlash"] > without["backlash"]
    assert recorded["tube_superelasticity"] > without["tube_superelasticity"]


@pytest.fixture(scope="module")
def rivals(config):
    """Fits of two look-alikes to a noisy record of play."""
    problem = problem_of(config)
    clean = problem.predict(problem.configured(), (CATALOGUE["backlash"](width_mm=0.06),))
    noise = np.random.default_rng(1).normal(size=clean[0].response.shape)
    recorded = build_joint_problem(config, [replace(problem.runs[0], response=clean[0].response + NOISE * noise)])
    starts = (CATALOGUE["backlash"](width_mm=0.05), CATALOGUE["capstan_hysteresis"](pulley_friction=0.02))
    return recorded, [fit(recorded, (start,)) for start in starts]


def test_recordings_are_offered_best_first_in_bench_words(rivals):
    found = next_recording(*rivals)
    assert [one.gain for one in found] == sorted((one.gain for one in found), reverse=True)
    assert found[0].gain > 3.0
    assert any("X2 = 20 mm" in one.words and "at 0.1 mm/s" in one.words for one in found)
    assert {"release", "two", "three", "hold", "tension"} <= {one.words.split()[0] for one in found}


def test_one_explanation_needs_no_recording(rivals):
    assert next_recording(rivals[0], rivals[1][:1]) == ()


def test_the_gain_is_what_refits_of_both_recordings_together_give(rivals):
    """The independent route: the nonlinear refit of each rival to what the other predicts, old and new together."""
    problem, fits = rivals
    level = min(one.evidence.level for one in fits)
    memory = float(np.median([one.evidence.memory for one in fits]))
    past = replace(problem, noise=level)
    for protocol in around(problem)[:2]:
        future = _posed(problem, protocol, level)
        gain = next_recording(problem, fits, [protocol])[0].gain
        refitted = min(_misfit([past, future], *pair) - _misfit([past], *pair) for pair in (fits, fits[::-1]))
        assert 0.5 * refitted * (1.0 - memory) / (1.0 + memory) == pytest.approx(gain, rel=0.25)


def _misfit(problems, true, other):
    def predicted(coordinates, effects):
        parts = []
        for problem in problems:
            response, tension = problem.fitted(problem.predict(coordinates, effects))
            parts += [response / problem.noise, tension / (problem.tension_noise or 1.0)]
        return np.concatenate(parts)

    target = predicted(true.coordinates, true.effects)
    size, effect = other.coordinates.size, other.effects[0]
    start = np.concatenate([other.coordinates, effect.values()])
    low = np.concatenate([np.full(size, -np.inf), [p.low for p in effect.parameters]])
    high = np.concatenate([np.full(size, np.inf), [p.high for p in effect.parameters]])

    def residual(vector):
        return predicted(vector[:size], (effect.with_values(vector[size:]),)) - target

    found = least_squares(residual, np.clip(start, low, high), bounds=(low, high), x_scale=[0.01] * start.size)
    return 2.0 * found.cost
