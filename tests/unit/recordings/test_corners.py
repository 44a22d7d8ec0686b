"""Turning points that no sample shows, against a drive whose corners are known."""

from __future__ import annotations

import numpy as np
import pytest

from coast_cli.recordings.branches import find_branches
from coast_cli.recordings.corners import missed_corners


def _sampled(corners: list[tuple[float, float]], every: float, begin: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    knots, values = (np.array(column) for column in zip(*corners, strict=True))
    clock = np.arange(begin, knots[-1], every)
    return clock, np.interp(clock, knots, values)


@pytest.mark.parametrize("begin", np.linspace(0.0, 0.93, 8))
def test_a_triangle_between_frames_gets_its_peak_back(begin: float) -> None:
    clock, drive = _sampled([(0.0, 0.0), (7.3, 3.65), (16.0, 0.17)], 1.0, begin)
    found = missed_corners(drive, clock, find_branches(drive, clock))
    assert found.time == pytest.approx([7.3])
    assert found.drive == pytest.approx([3.65])
    assert clock[found.before[0] - 1] < 7.3 < clock[found.before[0]]


def test_partial_reversals_each_get_theirs() -> None:
    corners = [(0.0, 0.0), (6.4, 3.2), (11.7, 1.1), (19.6, 4.5), (29.0, 0.0)]
    clock, drive = _sampled(corners, 1.0)
    found = missed_corners(drive, clock, find_branches(drive, clock))
    assert found.time == pytest.approx([6.4, 11.7, 19.6])
    assert found.drive == pytest.approx([3.2, 1.1, 4.5])


def test_a_peak_that_was_sampled_is_left_alone() -> None:
    clock, drive = _sampled([(0.0, 0.0), (8.0, 4.0), (16.0, 0.0)], 1.0)
    assert missed_corners(drive, clock, find_branches(drive, clock)).before.size == 0


def test_holds_curves_and_noise_tell_nothing() -> None:
    clock, held = _sampled([(0.0, 0.0), (7.3, 3.65), (12.0, 3.65), (19.0, 0.0)], 1.0)
    assert missed_corners(held, clock, find_branches(held, clock)).before.size == 0
    time = np.linspace(0.0, 3.0, 60)
    noisy = np.sin(time) + 0.02 * np.random.default_rng(1).standard_normal(60)
    assert missed_corners(noisy, time, find_branches(noisy, time)).before.size == 0
