"""Verdicts of a diagnosis, each on the recording that calls for it, and what is promised of every answer."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.camera_offset import CameraOffset
from coast_cli.effects.library.sensor_lag import SensorLag
from coast_cli.effects.library.tendon_superelasticity import TendonSuperelasticity
from coast_cli.errors import BadInput
from coast_cli.spec.load import REFERENCE, load_config_text
from tests.modelled_joint import CONFIG, cycle, make_run, recording

NOISE = 0.1
PLAY = Backlash(width_mm=0.2)


def diagnose(runs, **options):
    return diagnose_joint(CONFIG, runs, **{"most_effects": 2, **options})


def ids(answer):
    return [effect.id for effect in answer.effects]


@pytest.fixture(scope="module")
def played():
    return diagnose(recording((PLAY,), noise=NOISE))


def test_a_recording_of_the_model_itself_agrees():
    answer = diagnose(recording(noise=NOISE))
    assert answer.verdict == "agrees"
    assert not answer.effects
    assert not answer.where
    assert not answer.model_effects
    assert answer.noise == pytest.approx(NOISE, rel=0.2)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_clean_recordings_raise_no_alarm_in_any_colour(memory, seed):
    answer = diagnose(recording(noise=NOISE, memory=memory, seed=seed), most_effects=1)
    assert answer.verdict in ("agrees", "parameters")


@pytest.mark.parametrize("height", [-12.0, 12.0])
def test_one_outlier_at_the_peak_is_no_effect(height):
    runs = recording(noise=NOISE)
    peak = int(np.argmax(runs[0].stroke))
    response = runs[0].response.copy()
    response[peak] += height * NOISE
    answer = diagnose([replace(runs[0], response=response), *runs[1:]])
    assert answer.verdict in ("agrees", "parameters")


def test_few_samples_of_a_wide_sweep_are_no_noise():
    runs = [
        replace(
            run, **{name: getattr(run, name)[::9] for name in ("line", "time", "stroke", "response", "bending_length")}
        )
        for run in recording(noise=NOISE, lengths=(0.035, 0.02, 0.03, 0.025))
    ]
    assert diagnose(runs).verdict in ("agrees", "parameters")


def test_wrong_parameters_are_no_missing_physics():
    answer = diagnose(recording(values={"youngs_modulus_gpa": 50.0}, noise=NOISE))
    assert answer.verdict == "parameters"
    assert not answer.effects
    assert answer.configured["youngs_modulus_gpa"] == pytest.approx(42.6)
    assert answer.parameters["youngs_modulus_gpa"].value == pytest.approx(50.0, rel=0.02)
    assert answer.model_parameters["youngs_modulus_gpa"] == pytest.approx(50.0, rel=0.02)
    assert answer.comparison.refitted.held_out < 0.2 * answer.comparison.configured.held_out


def test_physics_is_named_located_and_fitted(played):
    assert played.verdict == "physics"
    assert ids(played) == ["backlash"]
    assert played.effects[0].component == "actuator"
    assert played.effects[0].confidence > 0.8
    width = played.effects[0].parameters["width_mm"]
    assert width.value == pytest.approx(0.2, abs=max(4.0 * width.std, 1e-3))
    assert not width.at_bound
    assert "release" in [region.value for region in played.where]
    assert played.model_effects[0].width_mm == pytest.approx(width.value)


def test_held_out_runs_are_predicted_down_to_the_noise(played):
    comparison = played.comparison
    assert comparison.held_out_runs == ("run_2",)
    assert comparison.with_effects.held_out < 1.3 * NOISE
    assert comparison.with_effects.held_out < 0.2 * comparison.refitted.held_out
    assert comparison.tip_mm_with_effects < comparison.tip_mm_refitted
    assert comparison.refitted.train <= comparison.configured.train


def test_a_lagging_camera_is_a_sensor():
    answer = diagnose(recording((SensorLag(time_constant_s=1.5),), noise=NOISE))
    assert answer.verdict == "sensor"
    assert ids(answer)[0] == "sensor_lag"
    assert answer.effects[0].parameters["time_constant_s"].value == pytest.approx(1.5, rel=0.1)


def test_a_plateau_of_the_tendon_is_not_taken_for_faces_that_geometry_keeps_apart():
    effect = TendonSuperelasticity(knee_n=0.9, extra_compliance=1.0, knee_width=0.2)
    answer = diagnose(recording((effect,), lengths=(0.03,), noise=NOISE))
    told = {identifier for group in (tuple(ids(answer)), *answer.alternatives) for identifier in group}
    assert "tendon_superelasticity" in told
    assert "notch_closure" not in told
    assert answer.next_recording


def test_what_no_effect_explains_is_told_without_a_name():
    runs = recording(noise=NOISE)
    for run in runs:
        for sign, place in ((1.0, 2.2e-3), (-1.0, 3.2e-3)):
            run.response[:] += sign * 4.0 * np.exp(-0.5 * ((run.stroke[:, np.newaxis] - place) / 0.15e-3) ** 2)
    answer = diagnose(runs)
    assert answer.verdict == "unnamed"
    assert not answer.effects
    assert {effect.id for effect in answer.model_effects} <= {"unnamed_1", "unnamed_2"}
    assert "stroke" in answer.unnamed.variables
    assert (answer.unnamed.memory, answer.unnamed.rate) == (False, False)
    assert "noise widths" in answer.reason
    assert answer.comparison.with_effects.held_out < 0.5 * answer.comparison.refitted.held_out
    assert answer.next_recording


@pytest.mark.parametrize("case", ["few", "still"])
def test_a_recording_that_cannot_decide_is_insufficient_and_says_why(case):
    stroke = cycle()[:10] if case == "few" else np.full(60, 2e-3)
    response = np.random.default_rng(0).normal(size=stroke.size)
    answer = diagnose([make_run(stroke, response)])
    assert answer.verdict == "insufficient"
    assert ("10 samples" if case == "few" else "drive never moves") in answer.reason
    assert answer.next_recording
    assert answer.comparison is None
    assert not answer.effects


def test_a_silent_response_is_insufficient():
    answer = diagnose([make_run(cycle(), np.full(cycle().size, 3.0))])
    assert answer.verdict == "insufficient"


def test_named_runs_are_held_out_and_no_fit_sees_them():
    runs = recording((PLAY,), noise=NOISE)
    spoiled = [*runs[:2], replace(runs[2], response=runs[2].response * 0.97)]
    one, other = (diagnose(some, named_hold_out=("run_2",)) for some in (runs, spoiled))
    assert one.comparison.held_out_runs == other.comparison.held_out_runs == ("run_2",)
    assert ids(one) == ["backlash"]
    assert other.attempts == ("backlash",)
    assert other.verdict == "unexplained"
    assert "run_2" in other.reason
    assert other.comparison.with_effects.train == pytest.approx(one.comparison.with_effects.train, rel=1e-6)
    assert other.comparison.with_effects.held_out > 3.0 * one.comparison.with_effects.held_out
    with pytest.raises(BadInput, match="there is no such run"):
        diagnose(runs, named_hold_out=("run_7",))


def test_what_the_recording_lacks_is_said():
    stroke = np.linspace(0.0, 4e-3, 80)
    plain = recording(noise=0.0, lengths=(0.03,))[0]
    response = np.interp(stroke, plain.stroke[:50], plain.response[:50, 0])
    response = response + NOISE * np.random.default_rng(1).normal(size=80)
    answer = diagnose([make_run(stroke, response, clock=False)])
    told = " ".join(answer.notes)
    assert "no time_s" in told
    assert "no release" in told
    assert "weaker" in told


def test_a_correction_already_in_the_configuration_is_not_found_again():
    text = REFERENCE.read_text(encoding="utf-8") + "\n[corrections.camera_offset]\noffset = 2.0\n"
    runs = recording((CameraOffset(offset=2.0),), noise=NOISE)
    answer = diagnose_joint(load_config_text(text, "corrected.toml"), runs, most_effects=1)
    assert answer.verdict == "agrees"


def test_the_same_input_gives_the_same_answer(played):
    again = diagnose(recording((PLAY,), noise=NOISE))
    assert replace(again, model_spread=None, curves=()) == replace(played, model_spread=None, curves=())
    np.testing.assert_array_equal(again.model_spread.std, played.model_spread.std)
    for one, other in zip(again.curves, played.curves, strict=True):
        assert repr(one) == repr(other)
