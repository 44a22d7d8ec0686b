"""The part of recordings between two times: where a file holds more than what is asked of it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import BadInput, UsageError

if TYPE_CHECKING:
    from coast_cli.recordings.model import JointRun, Recordings

FEWEST_ROWS = 2


def between(recordings: Recordings, begin_s: float | None, end_s: float | None) -> Recordings:
    """Return the rows of every run from one time (s, as its clock says) to another, both included.

    Runs that have no row in it are left out; both are said in a note. None leaves that end open.

    Raises:
        UsageError: the times are in the wrong order, or there is no joint recording.
        BadInput: a run has no clock, or no run is left.
    """
    if begin_s is None and end_s is None:
        return recordings
    low, high = -np.inf if begin_s is None else begin_s, np.inf if end_s is None else end_s
    if not low < high:
        raise UsageError(f"no time lies from {low:g} to {high:g} s; allowed: a first time before the last, in seconds.")
    if recordings.joint is None or recordings.shape is not None:
        raise UsageError("rows are chosen by the clock of a joint's recording; shapes have none.")
    runs, all_rows = recordings.joint.runs, sum(len(run) for run in recordings.joint.runs)
    kept = tuple(part for run in runs if len(part := _part(run, low, high)) >= FEWEST_ROWS)
    if not kept:
        ends = [float(time) for run in runs if run.time is not None for time in (run.time.min(), run.time.max())]
        raise BadInput(
            "no run has rows between the times asked for",
            file=runs[0].source,
            found=f"{low:g} to {high:g} s",
            allowed=f"times from {min(ends):g} to {max(ends):g} s",
        )
    gone = [run.name for run in runs if run.name not in {one.name for one in kept}]
    rows = all_rows - sum(len(run) for run in kept)
    note = f"{rows} of {all_rows} rows lie outside the times asked for and are left out"
    note += f", and with them the runs {', '.join(gone)}." if gone else "."
    return replace(recordings, joint=replace(recordings.joint, runs=kept), notes=(*recordings.notes, note))


def _part(run: JointRun, low: float, high: float) -> JointRun:
    if run.time is None:
        raise BadInput(f"run {run.name!r} has no time_s, so no part of it can be chosen by time", file=run.source)
    return run.only((run.time >= low) & (run.time <= high))
