"""The waiting state and the exact relaxation, against a plain loop and the analytic answer."""

from __future__ import annotations

import numpy as np

from coast_cli.effects.memory import follow, relax


def test_the_state_waits_between_its_bounds():
    drive = np.array([0.0, 1.0, 2.0, 1.5, 1.0, 0.5, 2.5])
    np.testing.assert_allclose(follow(drive - 1.0, drive), [-1.0, 0.0, 1.0, 1.0, 1.0, 0.5, 1.5])


def test_it_starts_at_rest_where_the_bounds_allow():
    drive = np.array([0.0, 0.5, 2.0])
    np.testing.assert_allclose(follow(drive - 1.0, drive + 1.0, np.float64(0.0)), [0.0, 0.0, 1.0])


def test_columns_are_separate():
    drive = np.linspace(0.0, 1.0, 5)
    both = follow(np.stack([drive, 2 * drive], axis=1), np.stack([drive, 2 * drive], axis=1) + 0.1)
    np.testing.assert_allclose(both, np.stack([drive, 2 * drive], axis=1))


def test_relaxation_is_exact_for_a_ramp():
    time = np.array([0.0, 0.3, 0.35, 1.0, 4.0])
    answer = relax(2.0 * time, time, 0.7, 0.0)
    np.testing.assert_allclose(answer, 2.0 * (time - 0.7 * (1.0 - np.exp(-time / 0.7))), atol=1e-12)


def test_no_time_constant_is_no_lag():
    values = np.array([1.0, 3.0])
    assert relax(values, np.array([0.0, 1.0]), 0.0, 0.0) is values
