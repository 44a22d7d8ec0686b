"""What the drive did in a run, as the forward model takes it: with turning points that samples miss, and with its load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.effects.effect import History
from coast_cli.recordings.model import JointRun


@dataclass(frozen=True, slots=True)
class Recorded:
    """What the drive did in a run, with the turning points that its samples miss, and at which rows (n,) it was seen."""

    run: int
    history: History
    rows: NDArray[np.int64]


def recorded_history(run: JointRun, index: int, first_time: float, *, has_tubes: bool = True) -> Recorded:
    """Return the history of a run; without a clock its samples are taken as one second apart.

    Of notched tubes the load is a force at the tip. A device without tubes starts where its first response says.
    """
    from coast_cli.recordings.corners import missed_corners

    load, force = (None, run.load) if has_tubes else (run.carried, None)
    clock = np.arange(len(run), dtype=np.float64) if run.time is None else run.time - first_time
    corners = missed_corners(run.drive, clock, run.branches)
    drive = np.insert(run.drive, corners.before, corners.drive)
    history = History(
        np.insert(clock, corners.before, corners.time),
        None if run.stroke is None else drive,
        drive if run.stroke is None else None,
        np.insert(run.bending_length, corners.before, run.bending_length[corners.before]),
        run=index,
        load=None if load is None else np.insert(load, corners.before, load[corners.before]),
        tip_force=None if force is None else np.insert(force, corners.before, force[corners.before]),
        first_response=None if has_tubes else float(run.response[np.argmax(run.valid), 0]),
    )
    rows = np.arange(len(run)) + np.searchsorted(corners.before, np.arange(len(run)), side="right")
    return Recorded(index, history, rows)
