"""Outliers are found, and corners, stairs and jumps are not taken for them; the noise level comes back."""

import numpy as np
import pytest

from coast_cli.diagnosis.joint.outliers import screened

NOISE = 0.1


def seen(drive: np.ndarray, response: np.ndarray, outliers: dict[int, float]) -> tuple[np.ndarray, float]:
    values = response + NOISE * np.random.default_rng(3).standard_normal(drive.size)
    for row, height in outliers.items():
        values[row] += height
    usable, level = screened([values[:, np.newaxis]], [drive], [True])
    return np.flatnonzero(~usable[0][:, 0]), level


def test_outliers_on_a_steep_ramp_are_found():
    drive = np.concatenate([np.linspace(0.0, 1.0, 30), np.linspace(1.0, 0.0, 30)[1:]])
    found, level = seen(drive, 30.0 * drive, {12: 4.0, 45: -3.0})
    assert found.tolist() == [12, 45]
    assert level == pytest.approx(NOISE, rel=0.3)


def test_stairs_of_few_samples_are_no_noise():
    drive = np.repeat(np.linspace(0.0, 1.0, 12), 3)
    found, level = seen(drive, 20.0 * drive, {})
    assert not set(found) & set(range(1, 35))  # of the ends half as much is known
    assert level == pytest.approx(NOISE, rel=0.4)


def test_a_jump_is_no_outlier():
    drive = np.linspace(0.0, 1.0, 80)
    found, _ = seen(drive, 5.0 * drive + 8.0 * (drive > 0.6), {})
    assert found.size == 0


def test_turns_are_no_outliers():
    drive = np.abs(((np.arange(60) * 0.13) % 2.0) - 1.0)
    found, _ = seen(drive, 25.0 * drive, {})
    assert found.size == 0
