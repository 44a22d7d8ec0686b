"""What benches get wrong: frames that repeat, views that end, and what only looks like it."""

import numpy as np
import pytest

from coast_cli.recordings.faults import clipped_rows, frozen_rows, quantum_of
from coast_cli.recordings.noise import estimate_noise


def sweep(count=400):
    return np.concatenate((np.linspace(0.0, 5.0, count // 2), np.linspace(5.0, 0.0, count - count // 2)))


def frozen(rng, values, share):
    """Return values with bursts of 2 to 9 frames that repeat, and which rows repeat."""
    held, at = np.zeros(len(values), bool), 1
    values = values.copy()
    while at < len(values):
        length = int(rng.integers(1, 9)) if rng.random() < share / 5.0 else 0
        values[at : at + length] = values[at - 1]
        held[at : at + length] = True
        at += max(length, 1) + 1
    return values, held


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("level", [0.02, 0.22, 1.0])
def test_frozen_frames_are_found_and_the_noise_is_not_theirs(seed, level):
    rng = np.random.default_rng(seed)
    drive = sweep()
    values, held = frozen(rng, 8.0 * drive + level * rng.normal(size=400), rng.uniform(0.05, 0.35))
    found = frozen_rows(values, drive)
    assert (found == held).mean() > 0.99
    assert estimate_noise(values, drive).level == pytest.approx(level, rel=0.35)


def test_frozen_frames_of_a_rounded_camera_jump():
    rng = np.random.default_rng(1)
    drive = sweep()
    values, held = frozen(rng, np.round(8.0 * drive + 0.01 * rng.normal(size=400), 1), 0.3)
    found = frozen_rows(values, drive)
    assert not (found & ~held & ~np.append(False, np.diff(values) == 0)).any()
    assert found.sum() > 0.5 * held.sum()


def test_what_rests_is_not_frozen():
    rng = np.random.default_rng(2)
    drive = sweep()
    state, played = 0.0, []
    for value in drive:
        state = min(max(state, value - 0.6), value)
        played.append(state)
    played = 8.0 * np.array(played)
    assert not frozen_rows(played, drive).any()
    assert not frozen_rows(np.round(played, 1), drive).any()
    assert not frozen_rows(np.round(played + 0.05 * rng.normal(size=400), 1), drive).any()
    held = np.concatenate((drive[:200], np.full(100, 5.0), drive[200:]))
    assert not frozen_rows(8.0 * held, held).any()
    assert not frozen_rows(8.0 * drive + rng.normal(size=400), drive).any()


def test_a_view_that_ends():
    rng = np.random.default_rng(3)
    drive = sweep()
    for noise in (0.0, 0.1, 1.0):
        values = np.minimum(8.0 * drive + noise * rng.normal(size=400), 30.0)
        found = clipped_rows(values, drive)
        assert found.sum() == (values == 30.0).sum()
    values = np.maximum(-8.0 * drive, -30.0)
    assert clipped_rows(values, drive).sum() == (values == -30.0).sum()


def test_what_ends_by_itself_is_not_clipped():
    rng = np.random.default_rng(4)
    drive = sweep()
    state, played = 0.0, []
    for value in drive:
        state = min(max(state, value - 0.6), value)
        played.append(state)
    smooth = 2.5 * (1.0 - np.cos(np.pi * drive / 5.0))
    for values in (8.0 * drive, 8.0 * np.array(played), np.round(8.0 * smooth, 1), 8.0 * drive + rng.normal(size=400)):
        assert not clipped_rows(values, drive).any()
    held = np.concatenate((drive[:200], np.full(100, 5.0), drive[200:]))
    assert not clipped_rows(np.round(8.0 * held, 2), held).any()


def test_steps_of_rounding():
    assert quantum_of(np.round(np.random.default_rng(5).normal(size=300), 2)) == pytest.approx(0.01)
    assert quantum_of(np.random.default_rng(5).normal(size=300)) == 0.0
    assert quantum_of(np.zeros(5)) == 0.0
