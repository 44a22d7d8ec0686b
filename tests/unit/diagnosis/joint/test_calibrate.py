"""Calibration: what is returned, what cannot be told and is held, bounds, outliers, conflicts, held-out runs."""

import re
from dataclasses import replace

import numpy as np
import pytest

from coast_cli.diagnosis.joint.calibratable import calibratable, ranged_elsewhere
from coast_cli.diagnosis.joint.calibrate import fit_parameters, pose
from coast_cli.diagnosis.joint.calibration import calibrate
from coast_cli.diagnosis.joint.problem import with_base
from coast_cli.errors import BadInput
from coast_cli.mechanics.joint import curvature_from_stroke, tension
from coast_cli.recordings.model import JointRun, Recording, Recordings
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config, load_config_text

TRUTH = {"youngs_modulus_gpa": 47.0, "notch_friction": 1.008, "deadband_mm": 1.0}
ALL = ["youngs_modulus_gpa", "notch_friction", "deadband_mm"]


@pytest.fixture(scope="module")
def config():
    return load_config(REFERENCE)


def sweep(config, name, length, *, noise=0.1, truth=TRUTH, seed=0, release=False, witness=False):
    """Return a run of the true joint, from the closed form."""
    rng = np.random.default_rng([seed, round(1e4 * length)])
    stroke = np.linspace(1.6e-3, 4.2e-3, 80)
    stroke = np.concatenate((stroke, stroke[-2::-1])) if release else stroke
    joint = with_base(build_joint(config, "OT4", "MT1"), truth)
    curvature = curvature_from_stroke(joint, stroke, length).curvature
    pull = tension(joint, curvature, length) + 0.003 * rng.normal(size=stroke.size)
    return JointRun(
        name,
        f"{name}.csv",
        np.arange(stroke.size),
        None,
        "OT4",
        "MT1",
        np.full(stroke.size, length),
        stroke,
        pull if witness else None,
        (curvature + noise * rng.normal(size=stroke.size))[:, None],
        "curvature",
    )


def recordings(*runs):
    return Recordings(joint=Recording("joint", runs))


def near(estimate, true):
    """Whether an estimate lies within 3.3 of its standard deviations, which fails once in a thousand."""
    return abs(estimate.value - true) < 3.3 * estimate.std


def of(calibration):
    return {estimate.parameter.name: estimate for estimate in calibration.whole.estimates}


def test_true_parameters_come_back(config):
    runs = [sweep(config, f"r{length}", length * 1e-3) for length in (20, 30, 40)]
    found = of(calibrate(config, recordings(*runs), ALL))
    assert list(found) == ALL
    for name, true in TRUTH.items():
        assert near(found[name], true)
        assert found[name].value == pytest.approx(true, rel=0.02)
        assert not found[name].at_bound
    assert found["youngs_modulus_gpa"].std == pytest.approx(
        (found["youngs_modulus_gpa"].high - found["youngs_modulus_gpa"].low) / 2 / 1.65, rel=0.1
    )


def test_a_fit_says_whether_it_is_good(config):
    runs = [sweep(config, f"r{length}", length * 1e-3, release=True) for length in (20, 40)]
    (good,) = calibrate(config, recordings(*runs), ALL).quality
    assert good.reduced_chi_square == pytest.approx(1.0, abs=0.35)
    assert str(good).startswith("the fit is good: ")
    assert (good.unit, good.parameters) == ("curvature_per_m", 3)
    played = [replace(run, stroke=run.stroke + 2e-4 * (run.direction < 0)) for run in runs]
    calibration = calibrate(config, recordings(*played), ALL)
    (poor,) = calibration.quality
    assert poor.reduced_chi_square > 2.0
    assert poor.aic > good.aic
    assert "the fit is not good" in " ".join(calibration.notes)


def test_modulus_and_pulley_friction_from_strokes_alone_are_one_product(config):
    runs = [sweep(config, "a", 0.02), sweep(config, "b", 0.04)]
    calibration = calibrate(config, recordings(*runs), [*ALL, "pulley_friction"])
    (held, reason), *others = calibration.whole.held
    assert (held.name, others) == ("pulley_friction", [])
    assert "product with youngs_modulus_gpa" in reason
    row = next(row for row in calibration.rows() if row["parameter"] == "pulley_friction")
    assert (row["status"], row["value"], row["low_90"]) == ("held", 0.2965, None)
    assert any("pulley_friction is held at its configured 0.2965" in note for note in calibration.notes)


def test_one_bending_length_cannot_tell_notch_friction(config):
    calibration = calibrate(config, recordings(sweep(config, "a", 0.03)), ALL)
    assert [parameter.name for parameter, _ in calibration.whole.held] == ["notch_friction"]


def test_tension_tells_the_tendon_from_the_tubes(config):
    runs = [sweep(config, "a", 0.02, witness=True), sweep(config, "b", 0.04, witness=True)]
    names = ["youngs_modulus_gpa", "tendon_youngs_modulus_gpa", "deadband_mm"]
    truth = {"notch_friction": 1.008}
    moved = load_config_text(REFERENCE.read_text().replace("notch_friction = 1.0063", "notch_friction = 1.008"))
    found = of(calibrate(moved, recordings(*runs), names))
    assert truth["notch_friction"] == 1.008
    assert found["tendon_youngs_modulus_gpa"].value == pytest.approx(53.965, rel=0.03)
    assert found["youngs_modulus_gpa"].value == pytest.approx(47.0, rel=0.03)


def test_without_tension_the_tendon_is_held(config):
    runs = [sweep(config, "a", 0.02), sweep(config, "b", 0.04)]
    whole = fit_parameters(
        pose(config, runs, calibratable(config, ["youngs_modulus_gpa", "tendon_youngs_modulus_gpa"]))
    )
    assert [parameter.name for parameter, _ in whole.held] == ["tendon_youngs_modulus_gpa"]


def test_a_tension_driven_run_does_not_see_the_deadband(config):
    run = sweep(config, "a", 0.03, witness=True)
    calibration = calibrate(config, recordings(replace(run, stroke=None)), ["youngs_modulus_gpa", "deadband_mm"])
    ((held, reason),) = calibration.whole.held
    assert (held.name, reason) == ("deadband_mm", "these recordings do not depend on it")
    found = of(calibration)["youngs_modulus_gpa"].value
    assert found == pytest.approx(47.0 * (1.008 / 1.0063) ** 50, rel=0.02)


def test_a_bound_of_the_configuration_is_kept_and_named(config):
    text = REFERENCE.read_text(encoding="utf-8").replace(
        "youngs_modulus_gpa = 42.6 ", "youngs_modulus_gpa = { value = 42.6, min = 41.0, max = 44.0 } "
    )
    bounded = load_config_text(text)
    assert [parameter.name for parameter in calibratable(bounded)] == ["youngs_modulus_gpa"]
    calibration = calibrate(bounded, recordings(sweep(config, "a", 0.03)))
    estimate = of(calibration)["youngs_modulus_gpa"]
    assert estimate.value == pytest.approx(44.0)
    assert estimate.at_bound
    assert estimate.high == pytest.approx(44.0)
    assert "ended on its bound 44" in " ".join(calibration.notes)


def test_outliers_do_not_move_the_fit(config):
    runs = [sweep(config, "a", 0.02), sweep(config, "b", 0.04)]
    clean = of(calibrate(config, recordings(*runs), ALL))
    for run in runs:
        run.response[::11] += 15.0
    spoiled = of(calibrate(config, recordings(*runs), ALL))
    for name, estimate in clean.items():
        assert abs(spoiled[name].value - estimate.value) < 2.0 * estimate.std


def test_dropped_frames_are_left_out(config):
    runs = [sweep(config, "a", 0.02), sweep(config, "b", 0.04)]
    for run in runs:
        run.response[5:30] = np.nan
    found = of(calibrate(config, recordings(*runs), ALL))
    assert all(near(found[name], true) for name, true in TRUTH.items())


def test_coloured_residuals_widen_the_intervals(config):
    def disturbed(memory, seed):
        rng = np.random.default_rng(seed)
        run = sweep(config, f"r{seed}", 0.03, noise=0.0)
        noise = rng.normal(size=len(run))
        for index in range(1, len(run)):
            noise[index] = memory * noise[index - 1] + np.sqrt(1.0 - memory**2) * noise[index]
        return replace(run, response=run.response + 0.2 * noise[:, None])

    def width(memory):
        runs = [disturbed(memory, seed) for seed in range(5)]
        return of(calibrate(config, recordings(*runs), ["youngs_modulus_gpa", "deadband_mm"]))["youngs_modulus_gpa"].std

    assert width(0.85) > 1.8 * width(0.0)


def test_a_run_that_wants_other_values_is_named(config):
    odd = sweep(config, "odd", 0.03, truth={**TRUTH, "youngs_modulus_gpa": 55.0})
    runs = [sweep(config, "a", 0.03, seed=1), sweep(config, "b", 0.03, seed=2), odd]
    calibration = calibrate(config, recordings(*runs), ["youngs_modulus_gpa", "deadband_mm"])
    assert "run odd wants youngs_modulus_gpa +" in " ".join(calibration.notes)
    agreed = calibrate(config, recordings(*runs[:2]), ["youngs_modulus_gpa", "deadband_mm"])
    assert "wants" not in " ".join(agreed.notes)


def test_branches_that_want_other_values_are_named(config):
    run = sweep(config, "a", 0.03, release=True)
    run.response[run.direction < 0] += 2.0
    calibration = calibrate(config, recordings(run), ["youngs_modulus_gpa", "deadband_mm"])
    assert {part.name for part in calibration.parts} == {"load", "release"}
    assert "release wants deadband_mm" in " ".join(calibration.notes)


def test_held_out_runs_are_predicted_and_not_fitted(config):
    odd = sweep(config, "odd", 0.03, truth={**TRUTH, "youngs_modulus_gpa": 55.0})
    runs = [sweep(config, "a", 0.02), sweep(config, "b", 0.04), odd]
    calibration = calibrate(config, recordings(*runs), ALL, ["odd"])
    assert calibration.held_out_runs == ("odd",)
    assert of(calibration)["youngs_modulus_gpa"].value == pytest.approx(47.0, rel=0.02)
    assert calibration.held_out.calibrated["curvature_per_m"] > 5 * calibration.train.calibrated["curvature_per_m"]
    assert calibration.train.configured["curvature_per_m"] > calibration.train.calibrated["curvature_per_m"]


def test_each_run_held_out_in_turn(config):
    runs = [sweep(config, "a", 0.02), sweep(config, "b", 0.03), sweep(config, "c", 0.04)]
    calibration = calibrate(config, recordings(*runs), ALL, ["each"])
    assert calibration.held_out.calibrated["curvature_per_m"] == pytest.approx(0.1, rel=0.3)
    assert calibration.held_out_runs == ("a", "b", "c")


def test_recordings_of_two_kinds_are_fitted_together(config):
    bend = sweep(config, "b", 0.04)
    bend = replace(bend, kind="bend", response=0.04 * bend.response)
    found = of(calibrate(config, recordings(sweep(config, "a", 0.02), bend), ALL))
    assert all(near(found[name], true) for name, true in TRUTH.items())


def test_every_row_has_the_same_names(config):
    calibration = calibrate(config, recordings(sweep(config, "a", 0.02), sweep(config, "b", 0.04)), ALL)
    rows = calibration.rows()
    assert all(list(row) == list(rows[0]) for row in rows)
    assert [row["subset"] for row in rows[:3]] == ["all"] * 3
    assert rows[0]["correlation_youngs_modulus_gpa"] == pytest.approx(1.0)
    assert abs(rows[0]["correlation_notch_friction"]) <= 1.0


@pytest.mark.parametrize(
    ("names", "hold_out", "words"),
    [
        (["youngs_modulus"], [], "Did you mean youngs_modulus_gpa"),
        (ALL, ["x"], "there is no such run"),
        (ALL, ["a", "b"], "every run is held out"),
    ],
)
def test_what_is_asked_wrongly(names, hold_out, words, config):
    runs = recordings(sweep(config, "a", 0.02), sweep(config, "b", 0.04))
    with pytest.raises(BadInput, match=words):
        calibrate(config, runs, names, hold_out)


def test_shapes_alone_are_refused(config):
    with pytest.raises(BadInput, match="no joint recording"):
        calibrate(config, Recordings(), ALL)


def test_where_nothing_can_be_told_everything_is_held(config):
    slack = replace(sweep(config, "a", 0.03), stroke=np.linspace(0.0, 1e-4, 80), response=np.zeros((80, 1)))
    calibration = calibrate(config, recordings(slack), ["youngs_modulus_gpa", "notch_friction"])
    assert [parameter.name for parameter, _ in calibration.whole.held] == ["notch_friction", "youngs_modulus_gpa"]
    assert {row["status"] for row in calibration.rows()} == {"held"}


@pytest.mark.parametrize("scale", [0.0, -5.0, 1e5])
def test_responses_that_no_joint_gives_still_get_an_answer(config, scale):
    run = sweep(config, "a", 0.03, release=True)
    calibration = calibrate(config, recordings(replace(run, response=scale * run.response)), ALL)
    assert all(np.isfinite(estimate.value) for estimate in calibration.whole.estimates)


def test_every_number_with_a_range_is_fitted_or_named(config):
    """A range on the wrap angle and the tendon's length is honoured; one on a material is said to be left alone."""
    text = REFERENCE.read_text(encoding="utf-8")
    wrap, length = config.joint.wrap_angle_rad, config.tendon.length_mm
    ranged = load_config_text(
        re.sub(
            r"(?m)^(wrap_angle_rad|length_mm|youngs_modulus_gpa) = ([\d.]+)",
            lambda found: (
                f"{found[1]} = {{ value = {found[2]}, min = {float(found[2]) / 2}, max = {float(found[2]) * 2} }}"
            ),
            text,
        )
    )
    chosen = {parameter.name: parameter for parameter in calibratable(ranged)}
    assert set(chosen) == {"youngs_modulus_gpa", "tendon_youngs_modulus_gpa", "wrap_angle_rad", "tendon_length_mm"}
    assert (chosen["wrap_angle_rad"].low, chosen["wrap_angle_rad"].high) == (wrap / 2, wrap * 2)
    assert chosen["tendon_length_mm"].value == length
    assert all(parameter.given for parameter in chosen.values())
    assert ranged_elsewhere(ranged) == ("materials.nitinol.youngs_modulus_gpa", "inner.youngs_modulus_gpa")


def test_a_tendon_length_is_found(config):
    truth = {**TRUTH, "tendon_length_mm": 300.0}
    runs = recordings(*(sweep(config, str(mm), 1e-3 * mm, truth=truth, noise=0.01) for mm in (20, 40)))
    found = calibrate(config, runs, ["tendon_length_mm"], fixed=TRUTH)
    assert near(of(found)["tendon_length_mm"], 300.0)


def test_bounds_that_are_assumed_and_values_that_are_fixed_are_said(config):
    runs = recordings(*(sweep(config, str(mm), 1e-3 * mm) for mm in (20, 40)))
    found = calibrate(config, runs, ["deadband_mm"], fixed={"youngs_modulus_gpa": 47.0, "notch_friction": 1.008})
    said = " ".join(found.notes)
    assert "deadband_mm is fitted between 0 and 21.2: bounds assumed, as joint.deadband_mm has no min and max." in said
    assert "youngs_modulus_gpa is fixed at the given 47." in said
    assert near(of(found)["deadband_mm"], 1.0)
    free = calibrate(config, runs, ["deadband_mm"])
    assert abs(of(free)["deadband_mm"].value - 1.0) > abs(of(found)["deadband_mm"].value - 1.0)


def test_a_heavy_run_draws_the_values_to_itself(config):
    """Two runs that disagree on the deadband: the value moves from one's to the other's with the weight."""
    one, other = sweep(config, "one", 0.02, truth={**TRUTH, "deadband_mm": 0.8}), sweep(config, "other", 0.04)
    fixed = {"youngs_modulus_gpa": 47.0, "notch_friction": 1.008}

    def value(**weights):
        found = calibrate(config, recordings(one, other), ["deadband_mm"], fixed=fixed, weights=weights)
        return of(found)["deadband_mm"].value

    even, first, second = value(), value(one=1e4), value(other=1e4)
    assert first == pytest.approx(0.8, abs=0.02)
    assert second == pytest.approx(1.0, abs=0.02)
    assert first < even < second
    assert value(one=1.0, other=1.0) == pytest.approx(even, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"fixed": {"notch_frction": 1.0}}, "Did you mean notch_friction"),
        (
            {"fixed": {"notch_friction": 0.5}},
            "notch_friction cannot be fixed there; found 0.5; allowed: a number from 1",
        ),
        ({"fixed": {"notch_friction": np.nan}}, "cannot be fixed there"),
        ({"fit": ["deadband_mm"], "fixed": {"deadband_mm": 1.0}}, "to be fitted and fixed at once"),
        ({"fixed": TRUTH}, "none is left to fit"),
        ({"weights": {"b": 2.0}}, "there is no such run to weigh; found 'b'; allowed: a"),
        ({"weights": {"a": 0.0}}, "the weight of run 'a' is none; found 0.0; allowed: above 0"),
        ({"weights": {"a": np.inf}}, "the weight of run 'a' is none"),
    ],
)
def test_a_fixed_value_or_weight_that_cannot_be_is_one_sentence(config, given, said):
    with pytest.raises(BadInput) as caught:
        calibrate(config, recordings(sweep(config, "a", 0.02)), **given)
    assert said in str(caught.value)
