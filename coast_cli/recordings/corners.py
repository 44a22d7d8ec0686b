"""Where the drive turned between two samples: legs extrapolated to their intersection.

A camera that takes few frames a leg misses the turning point itself, by up to the travel of a frame, and friction, play
and set all remember that point. Legs are straight in time (a drive at constant speed), so two samples of each give it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.branches import Branches

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]

# Drives noisier than this, in the travel of one sample, do not tell.
_QUIET = 0.05
# A turning sample must lie this close to one of the two legs, and be missed by at least so much, in the same measure.
_ON_A_LEG = 0.1
_WORTH_IT = 0.02


@dataclass(frozen=True, slots=True)
class Corners:
    """Turning points that no sample shows: row before which each belongs, its time (clock's unit) and drive, each (c,)."""

    before: Integers
    time: Floats
    drive: Floats


def missed_corners(drive: Floats, clock: Floats, branches: Branches) -> Corners:
    """Return the turning points between samples of a run's drive [n], ``clock`` [n] in any unit that runs evenly."""
    found = [
        corner
        for first, second in pairwise(branches.parts)
        if first.direction * second.direction < 0
        and (corner := _corner(drive, clock, second.start, branches)) is not None
    ]
    rows = np.array([row for row, _, _ in found], dtype=np.int64)
    return Corners(rows, np.array([time for _, time, _ in found]), np.array([value for _, _, value in found]))


def _corner(drive: Floats, clock: Floats, after: int, branches: Branches) -> tuple[int, float, float] | None:
    """Return the corner next to the last sample of a leg, ``after`` being the first of the next; None where none shows."""
    turn = after - 1
    if turn < 2 or after + 1 >= len(drive) or not np.all(np.diff(clock[turn - 2 : after + 2]) > 0.0):
        return None
    up = (drive[turn - 1] - drive[turn - 2]) / (clock[turn - 1] - clock[turn - 2])
    down = (drive[after + 1] - drive[after]) / (clock[after + 1] - clock[after])
    step = max(abs(drive[turn - 1] - drive[turn - 2]), abs(drive[after + 1] - drive[after]))
    if up * down >= 0.0 or branches.drive_noise > _QUIET * step:
        return None
    time = (drive[after] - drive[turn - 1] + up * clock[turn - 1] - down * clock[after]) / (up - down)
    value = drive[turn - 1] + up * (time - clock[turn - 1])
    here = clock[turn]
    leg = (
        drive[turn - 1] + up * (here - clock[turn - 1]) if here <= time else drive[after] + down * (here - clock[after])
    )
    missed = (value - drive[turn]) * np.sign(up)
    if (
        not clock[turn - 1] < time < clock[after]
        or abs(leg - drive[turn]) > _ON_A_LEG * step
        or missed < _WORTH_IT * step
    ):
        return None
    return (turn if time < here else after), float(time), float(value)
