"""Branches of a run, found from its drive: where it loads, releases and holds, and which cycle a sample belongs to.

A turning point is an extremum that the drive leaves by more than its own noise explains (the reversal rule of rainflow
counting, ASTM E1049, with the noise as its gate). A hold is a stretch in which the drive stays where it is, told from
the stairs of a coarse drive that moves slowly.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]

REVERSAL_IN_SIGMAS = 6.0
REVERSAL_IN_TRAVEL = 1e-3
SHORTEST_HOLD = 3
STAIR_IN_TRAVEL = 0.01
FLICKER = 0.1


@dataclass(frozen=True)
class Branch:
    """Samples ``start`` to ``stop`` (exclusive) that were all reached in one direction, in one cycle from 0."""

    start: int
    stop: int
    direction: int
    cycle: int


@dataclass(frozen=True, eq=False)
class Branches:
    """The history of a drive.

    Attributes:
        direction: how the drive moved to reach each sample, [n]: +1 load, -1 release, 0 hold.
        cycle: [n], counts from 0; a new cycle begins with each load after the first.
        parts: the stretches of one direction, in order.
        drive_noise: standard deviation of the noise on the drive, in its unit (0 for a commanded drive).
    """

    direction: Integers
    cycle: Integers
    parts: tuple[Branch, ...]
    drive_noise: float

    @property
    def holds(self) -> tuple[Branch, ...]:
        """The stretches in which the drive stays."""
        return tuple(part for part in self.parts if part.direction == 0)

    @property
    def moves(self) -> tuple[Branch, ...]:
        """The stretches in which it moves."""
        return tuple(part for part in self.parts if part.direction != 0)

    def every(self, step: int) -> Branches:
        """Return the branches of every so-manieth sample."""
        return _branches(self.direction[::step], self.drive_noise)

    @property
    def cycles(self) -> int:
        """How many cycles there are."""
        return int(self.cycle[-1]) + 1


def find_branches(drive: Floats, time: Floats | None = None) -> Branches:
    """Find branches, holds and cycles in a drive of [n] samples, n >= 1; ``time`` in s weights the sampling if given.

    The first sample counts with the branch that leaves it.
    """
    drive = np.asarray(drive, dtype=np.float64)
    noise = _drive_noise(drive)
    travel = float(np.ptp(drive))
    if travel <= _range_of_noise(len(drive)) * noise or travel == 0.0:
        direction = np.zeros(len(drive), dtype=np.int64)
    else:
        exact = noise < 1e-3 * STAIR_IN_TRAVEL * travel
        gate = 0.0 if exact else max(REVERSAL_IN_SIGMAS * noise, REVERSAL_IN_TRAVEL * travel)
        points = _turning_points(drive, max(gate, 1e-9 * travel))
        if exact and len(points) > max(4, FLICKER * len(drive)):
            steps = np.abs(np.diff(drive))
            points = _turning_points(drive, 1.5 * float(steps[steps > 1e-9 * travel].min()))
        direction = _directions(drive, points)
        held = _exact_holds(drive, travel) if exact else _noisy_holds(drive, noise, time)
        direction[held] = 0
        if len(direction) > 1:
            direction[0] = direction[1]
    return _branches(direction, noise)


def _drive_noise(drive: Floats) -> float:
    """Return the noise on a drive: the least that differences of any order see, as a step or a stair spoils some."""
    if len(drive) < 8:
        return 0.0
    levels = []
    for order, gain in ((1, 2.0), (2, 6.0), (3, 20.0)):
        difference = np.diff(drive, order)
        levels.append(float(np.median(np.abs(difference - np.median(difference)))) / np.sqrt(gain))
    return float(min(levels) / 0.6744897501960817)


def _range_of_noise(count: int) -> float:
    """Return what the range of so many samples of white noise hardly exceeds, in what is taken for its deviation."""
    return 3.0 * float(np.sqrt(2.0 * np.log(max(count, 2))))


def difference_noise(values: Floats) -> float:
    """Return the white-noise level seen by third differences of a smooth series; robust to its kinks and jumps."""
    if len(values) < 8:
        return 0.0
    third = np.diff(values, 3)
    return float(np.median(np.abs(third)) / (0.6744897501960817 * np.sqrt(20.0)))


def _turning_points(drive: Floats, gate: float) -> list[int]:
    """Return the first sample, every extremum that is left by more than ``gate`` both ways, and the last sample."""
    step = np.sign(np.diff(drive))
    moving = np.flatnonzero(step)
    turns = moving[1:][step[moving[1:]] != step[moving[:-1]]]
    candidates = [0, *turns.tolist(), len(drive) - 1]
    values = drive[candidates].tolist()
    points = [0]
    low = high = 0
    towards = 0
    for number, value in enumerate(values):
        if value > values[high]:
            high = number
        if value < values[low]:
            low = number
        if towards >= 0 and values[high] - value > gate:
            if towards or values[high] - values[0] > gate:
                points.append(candidates[high])
            towards, low, high = -1, number, number
        elif towards <= 0 and value - values[low] > gate:
            if towards or values[0] - values[low] > gate:
                points.append(candidates[low])
            towards, low, high = 1, number, number
    if points[-1] != len(drive) - 1:
        points.append(len(drive) - 1)
    return points


def _directions(drive: Floats, points: list[int]) -> Integers:
    """Return the direction of each sample between turning points; a turning point belongs to the branch it ends."""
    direction = np.zeros(len(drive), dtype=np.int64)
    for start, stop in itertools.pairwise(points):
        direction[start + 1 : stop + 1] = int(np.sign(drive[stop] - drive[start]))
    return direction


def _exact_holds(drive: Floats, travel: float) -> NDArray[np.bool_]:
    """Return which samples repeat the one before in a plateau that is long, or that ends in a true step."""
    still = np.abs(np.diff(drive)) <= 1e-9 * travel
    held = np.zeros(len(drive), dtype=bool)
    if not still.any():
        return held
    edges = np.flatnonzero(np.diff(np.concatenate(([0], still.astype(np.int8), [0]))))
    starts, stops = edges[::2], edges[1::2]
    moves = int((~still).sum())
    usual = len(drive) / (moves + 1)
    after = np.abs(drive[np.minimum(stops + 1, len(drive) - 1)] - drive[stops])
    before = np.abs(drive[starts] - drive[np.maximum(starts - 1, 0)])
    stepped = np.maximum(before, after) > STAIR_IN_TRAVEL * travel
    length = stops - starts
    keep = ((length >= SHORTEST_HOLD) & stepped) | (length >= max(SHORTEST_HOLD, 4.0 * usual))
    for start, stop in zip(starts[keep].tolist(), stops[keep].tolist(), strict=True):
        held[start + 1 : stop + 1] = True
    return held


def _noisy_holds(drive: Floats, noise: float, time: Floats | None) -> NDArray[np.bool_]:
    """Return where the local slope is nothing beside the usual one, in a window wide enough for the noise."""
    held = np.zeros(len(drive), dtype=bool)
    clock = np.arange(len(drive), dtype=np.float64) if time is None else time
    if clock[-1] <= clock[0]:
        clock = np.arange(len(drive), dtype=np.float64)
    usual = float(np.abs(np.diff(_block_means(drive, 8))).mean()) / 8.0 if len(drive) >= 24 else 0.0
    if usual == 0.0:
        return held
    half = max(3, int(np.ceil((1.5 * (10.0 * noise / usual) ** 2) ** (1.0 / 3.0))))
    if 2 * half + 1 > len(drive) // 3:
        return held
    slope = _local_slope(drive, half)
    quiet = np.abs(slope) < 0.3 * usual
    edges = np.flatnonzero(np.diff(np.concatenate(([0], quiet.astype(np.int8), [0]))))
    for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if stop - start >= 2 * half + 1 and np.ptp(drive[start:stop]) < 8.0 * noise + 0.3 * usual * (stop - start):
            held[start:stop] = True
    return held


def _block_means(values: Floats, size: int) -> Floats:
    count = len(values) // size
    means: Floats = values[: count * size].reshape(count, size).mean(axis=1)
    return means


def _local_slope(values: Floats, half: int) -> Floats:
    """Return the least-squares slope a sample in a window of ``2 half + 1`` samples, one-sided copies at the ends."""
    window = np.arange(-half, half + 1, dtype=np.float64)
    inner = np.convolve(values, -window / (window @ window), mode="valid")
    return np.concatenate((np.full(half, inner[0]), inner, np.full(half, inner[-1])))


def _branches(direction: Integers, noise: float) -> Branches:
    edges = [0, *(1 + np.flatnonzero(np.diff(direction))).tolist(), len(direction)]
    cycle = np.zeros(len(direction), dtype=np.int64)
    parts: list[Branch] = []
    current, loaded, last = 0, False, 0
    for start, stop in itertools.pairwise(edges):
        towards = int(direction[start])
        if towards > 0 and last <= 0:
            current, loaded = current + int(loaded), True
        last = towards or last
        parts.append(Branch(start, stop, towards, current))
        cycle[start:stop] = current
    return Branches(direction, cycle, tuple(parts), noise)
