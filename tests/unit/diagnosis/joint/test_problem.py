"""A recording made ready to be fitted: which parameters are free, which samples count, and what is predicted."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.problem import with_base
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.camera_offset import CameraOffset
from coast_cli.errors import BadInput
from coast_cli.mechanics.joint import curvature_from_stroke
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config_text
from tests.modelled_joint import CONFIG, problem_of, recording

TEXT = REFERENCE.read_text(encoding="utf-8")


def names(problem):
    return [parameter.name for parameter in problem.base]


def test_free_parameters_are_those_that_the_recording_can_tell():
    assert names(problem_of(recording(lengths=(0.03,)))) == ["youngs_modulus_gpa", "deadband_mm"]
    assert "notch_friction" in names(problem_of(recording()))
    assert "tendon_youngs_modulus_gpa" in names(problem_of(recording(witness=True)))
    tension_driven = [replace(run, stroke=None) for run in recording(witness=True)]
    assert names(problem_of(tension_driven)) == ["youngs_modulus_gpa", "notch_friction"]


def test_bounds_given_in_the_configuration_hold():
    text = TEXT.replace("youngs_modulus_gpa = 42.6 ", "youngs_modulus_gpa = { value = 42.6, min = 40.0, max = 45.0 } ")
    problem = build_joint_problem(load_config_text(text, "t.toml"), recording())
    modulus = problem.base[0]
    assert (modulus.value, modulus.low, modulus.high) == (42.6, 40.0, 45.0)
    low, high = problem.bounds()
    assert np.exp([low[0], high[0]]) == pytest.approx([40.0, 45.0])


def test_configured_coordinates_are_the_configured_values():
    problem = problem_of(recording())
    values = problem.values(problem.configured())
    assert values == pytest.approx({"youngs_modulus_gpa": 42.6, "notch_friction": 1.0063, "deadband_mm": 1.2})


def test_the_base_prediction_is_the_closed_form_on_loading():
    runs = recording(noise=0.0)
    problem = problem_of(runs)
    for run, prediction in zip(runs, problem.predict(problem.configured(), ()), strict=True):
        exact = curvature_from_stroke(build_joint(CONFIG, "OT4", "MT1"), run.stroke, run.bending_length)
        assert prediction.response[:, 0] == pytest.approx(exact.curvature, abs=2e-3)
        assert prediction.tension == pytest.approx(exact.tension, abs=2e-3)


def test_replaced_base_parameters_reach_the_joint():
    joint = build_joint(CONFIG, "OT4", "MT1")
    moved = with_base(joint, {"youngs_modulus_gpa": 50.0, "deadband_mm": 0.7, "tendon_youngs_modulus_gpa": 60.0})
    assert moved.youngs_modulus == pytest.approx(50e9)
    assert moved.deadband == pytest.approx(0.7e-3)
    assert moved.tendon.youngs_modulus == pytest.approx(60e9)
    assert with_base(joint, {}) == joint


def test_dropped_frames_and_lone_outliers_do_not_count():
    runs = recording(noise=0.1)
    runs[0].response[10] = np.nan
    runs[1].response[20] += 15.0
    problem = problem_of(runs)
    assert not problem.usable[0][10, 0]
    assert not problem.usable[1][20, 0]
    assert sum(int((~use).sum()) for use in problem.usable) == 2
    assert problem.observed.size == sum(len(run) for run in runs) - 2


@pytest.mark.parametrize("level", [0.02, 0.1, 0.5])
def test_rough_noise_is_about_the_noise(level):
    assert problem_of(recording(noise=level)).noise == pytest.approx(level, rel=0.3)
    assert problem_of(recording(noise=level)).floor == pytest.approx(level, rel=0.4)


def test_held_out_rows_are_not_fitted_but_simulated():
    runs = recording(noise=0.0)
    held = [np.zeros(len(run), bool) for run in runs]
    held[0][30:60] = True
    problem = problem_of(runs, held)
    assert problem.observed.size == sum(len(run) for run in runs) - 30
    assert len(problem.predict(problem.configured(), ())[0].response) == len(runs[0])
    response, _ = problem.fitted(problem.predict(problem.configured(), ()))
    assert response == pytest.approx(problem.observed, abs=1e-6)
    assert problem.only([~rows for rows in held]).observed.size == problem.observed.size


def test_effects_change_the_prediction_and_corrections_are_always_there():
    runs = recording(noise=0.0)
    problem = problem_of(runs)
    plain = problem.fitted(problem.predict(problem.configured(), ()))[0]
    shifted = problem.fitted(problem.predict(problem.configured(), (CameraOffset(offset=2.0),)))[0]
    assert shifted == pytest.approx(plain + 2.0)
    text = TEXT + "\n[corrections.camera_offset]\noffset = 2.0\n"
    corrected = build_joint_problem(load_config_text(text, "t.toml"), runs)
    assert corrected.fitted(corrected.predict(corrected.configured(), ()))[0] == pytest.approx(plain + 2.0)


def test_scales_are_what_the_recording_reaches():
    runs = recording(effects=(Backlash(width_mm=0.2),), noise=0.0, witness=True)
    scales = problem_of(runs).scales()
    assert scales["curvature"] == pytest.approx(max(np.max(run.response) for run in runs))
    assert scales["tension"] == pytest.approx(max(np.max(run.tension) for run in runs))
    assert scales["stroke"] == pytest.approx(4.0, rel=1e-3)
    assert scales["duration"] == pytest.approx(max(np.ptp(run.time) for run in runs))
    assert all(np.isfinite(scale) and scale > 0.0 for scale in scales.values())


def test_a_stroke_without_a_tendon_is_refused():
    text = TEXT
    before, after = text.split("[tendon]")
    config = load_config_text(before + "[joint]" + after.split("[joint]")[1], "t.toml")
    with pytest.raises(BadInput, match="a stroke needs a tendon"):
        build_joint_problem(config, recording())
