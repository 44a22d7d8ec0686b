"""Errors as figures: of known differences, in table units, with outliers and dropped frames left out."""

import numpy as np
import pytest

from coast_cli.diagnosis.joint.errors import errors_of, pooled_errors, tip_of, to_unit
from coast_cli.effects.forward import Prediction
from coast_cli.mechanics.joint import tip
from tests.modelled_joint import make_run, problem_of, recording


def everywhere(problem):
    return [np.ones(len(run), bool) for run in problem.runs]


def test_the_model_on_its_own_recording_errs_by_the_noise():
    problem = problem_of(recording(noise=0.2))
    found = errors_of(problem, problem.configured(), (), everywhere(problem))
    assert found.response == pytest.approx(0.2, rel=0.1)
    assert found.count == sum(len(run) for run in problem.runs)
    assert 0.0 < found.tip_mm < 0.2


def test_a_shift_is_the_error_and_the_rows_chosen_are_those_counted():
    problem = problem_of(recording(noise=0.0))
    predictions = [
        Prediction(run.response + (1.5 if index == 1 else 0.0), np.zeros(len(run)))
        for index, run in enumerate(problem.runs)
    ]
    second = [np.full(len(run), index == 1) for index, run in enumerate(problem.runs)]
    found = pooled_errors(problem, predictions, second)
    assert found.response == pytest.approx(1.5)
    run = problem.runs[1]
    x, y = tip(run.response[:, 0], run.bending_length)
    other_x, other_y = tip(run.response[:, 0] + 1.5, run.bending_length)
    expected = np.sqrt(np.mean((x - other_x) ** 2 + (y - other_y) ** 2)) * 1e3
    assert found.tip_mm == pytest.approx(expected, rel=1e-6)
    first = [np.full(len(run), index == 0) for index, run in enumerate(problem.runs)]
    assert pooled_errors(problem, predictions, first).response == pytest.approx(0.0, abs=1e-12)


def test_dropped_frames_do_not_count():
    runs = recording(noise=0.1)
    runs[0].response[10:20] = np.nan
    problem = problem_of(runs)
    found = errors_of(problem, problem.configured(), (), everywhere(problem))
    assert found.count == sum(len(run) for run in runs) - 10
    assert np.isfinite(found.tip_mm)


def test_no_rows_have_no_error():
    problem = problem_of(recording())
    found = errors_of(problem, problem.configured(), (), [np.zeros(len(run), bool) for run in problem.runs])
    assert (found.count, found.response, found.tip_mm) == (0, 0.0, 0.0)


def test_angles_are_told_in_degrees_and_curvatures_as_they_are():
    assert to_unit("curvature", 2.0) == 2.0
    assert to_unit("bend", np.pi) == pytest.approx(180.0)
    assert to_unit("notch", np.pi / 2) == pytest.approx(90.0)


def test_a_chain_of_equal_notches_ends_near_the_arc():
    count, pitch = 60, 0.5e-3
    run = make_run(np.linspace(0.0, 1.0, 5), np.full((5, count), 0.02), kind="notch", length=count * pitch)
    x, y = tip_of(run, run.response, run.bending_length, pitch)
    arc_x, arc_y = tip(0.02 / pitch, count * pitch)
    assert x == pytest.approx(np.full(5, arc_x), rel=1e-3)
    assert y == pytest.approx(np.full(5, arc_y), rel=2e-2)
