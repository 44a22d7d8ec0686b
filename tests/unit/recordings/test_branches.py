"""Branches from the drive: load, release, hold and cycles, commanded or noisy, fast or slow."""

import itertools

import numpy as np
import pytest

from coast_cli.recordings.branches import find_branches


def spans(branches):
    return [(part.start, part.stop, part.direction, part.cycle) for part in branches.parts]


def ramp(*levels, samples=50):
    """Return a drive through the levels, each leg of so many samples, its first sample the first level."""
    legs = [np.linspace(a, b, samples + 1)[1:] for a, b in itertools.pairwise(levels)]
    return np.concatenate(([levels[0]], *legs))


def test_load_and_release_of_a_commanded_drive():
    branches = find_branches(ramp(0.0, 5.0, 1.0, 5.0))
    assert spans(branches) == [(0, 51, 1, 0), (51, 101, -1, 0), (101, 151, 1, 1)]
    assert branches.drive_noise == pytest.approx(0.0, abs=1e-12)
    assert branches.cycles == 2
    assert branches.holds == ()


def test_a_release_first_then_cycles():
    branches = find_branches(ramp(2.0, 0.0, 3.0, 0.0, 3.0))
    assert [(part.direction, part.cycle) for part in branches.parts] == [(-1, 0), (1, 0), (-1, 0), (1, 1)]


def test_a_hold_inside_a_load_begins_no_cycle():
    drive = np.concatenate((ramp(0.0, 3.0), np.full(40, 3.0), ramp(3.0, 5.0)[1:]))
    assert [(part.direction, part.cycle) for part in find_branches(drive).parts] == [(1, 0), (0, 0), (1, 0)]


def test_a_small_reversal_of_a_commanded_drive_counts():
    drive = ramp(0.0, 5.0, 4.995, 6.0)
    assert [part.direction for part in find_branches(drive).parts] == [1, -1, 1]


def test_holds_of_a_commanded_drive():
    drive = np.concatenate((ramp(0.0, 5.0), np.full(40, 5.0), ramp(5.0, 0.0)[1:]))
    assert spans(find_branches(drive)) == [(0, 51, 1, 0), (51, 91, 0, 0), (91, 141, -1, 0)]


def test_steps_with_short_stays_are_holds_and_stairs_of_a_coarse_drive_are_not():
    steps = np.repeat(np.arange(6.0), 4)
    directions = find_branches(steps).direction
    assert (directions == 0).sum() >= 15
    stairs = np.floor(np.linspace(0.0, 300.0, 1200)) * 0.01
    assert spans(find_branches(stairs)) == [(0, 1200, 1, 0)]


def test_a_drive_that_never_moves_is_one_hold():
    assert spans(find_branches(np.full(20, 3.0))) == [(0, 20, 0, 0)]
    noisy = 3.0 + 1e-3 * np.random.default_rng(0).normal(size=200)
    assert spans(find_branches(noisy)) == [(0, 200, 0, 0)]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_very_short_runs(count):
    assert find_branches(np.arange(float(count))).direction.shape == (count,)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("noise", [0.002, 0.01, 0.03])
def test_noise_on_the_drive_makes_no_reversals(noise, seed):
    clean = ramp(0.0, 5.0, 0.5, 5.0, samples=200)
    drive = clean + noise * np.random.default_rng(seed).normal(size=clean.size)
    branches = find_branches(drive)
    moves = [part for part in branches.parts if part.direction]
    assert [part.direction for part in moves] == [1, -1, 1]
    away = np.abs(branches.direction - find_branches(clean).direction) > 0
    assert away.mean() < 0.02 + 4.0 * noise / 5.0
    assert branches.drive_noise == pytest.approx(noise, rel=0.35)


@pytest.mark.parametrize("seed", range(5))
def test_holds_are_found_under_noise(seed):
    clean = np.concatenate((ramp(0.0, 5.0, samples=200), np.full(150, 5.0), ramp(5.0, 0.0, samples=200)[1:]))
    branches = find_branches(clean + 0.01 * np.random.default_rng(seed).normal(size=clean.size))
    held = branches.direction == 0
    assert held[220:330].mean() > 0.9
    assert held[:180].mean() + held[380:].mean() < 0.05


def test_a_sine_has_no_holds_at_its_turns():
    drive = 2.5 - 2.5 * np.cos(np.linspace(0.0, 4.0 * np.pi, 400))
    branches = find_branches(drive)
    assert [part.direction for part in branches.parts] == [1, -1, 1, -1]
    assert branches.cycle[0] == 0
    assert branches.cycle[-1] == 1


def test_every_sample_belongs_to_one_part():
    rng = np.random.default_rng(3)
    for _ in range(50):
        drive = np.cumsum(rng.normal(size=rng.integers(2, 200)))
        branches = find_branches(drive)
        covered = np.concatenate([np.arange(part.start, part.stop) for part in branches.parts])
        assert covered.tolist() == list(range(len(drive)))
        assert all(set(branches.direction[p.start : p.stop]) == {p.direction} for p in branches.parts)
