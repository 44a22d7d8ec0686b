"""How wide the loop of load and release is, low and high up: a signature that is read before anything is fitted.

Lost stroke (play) is as wide everywhere; the wait of friction along the tendon grows with tension, so that its loop
closes towards slack (Euler-Eytelwein). Widths are taken between a leg and the release that follows it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from coast_cli.mechanics.section import FloatArray
    from coast_cli.recordings.model import JointRun

_LOW, _HIGH = (0.15, 0.2, 0.25, 0.3), (0.7, 0.75, 0.8, 0.85)
_FEWEST = 8
# Widths low and high up that differ by less than this count as equal, and by more than the other as growing.
_EQUAL, _GROWS = 0.25, 0.5


@dataclass(frozen=True, slots=True)
class Loop:
    """Width of a loop in drive (SI) at about a fifth and four fifths of the response's range."""

    low: float
    high: float

    @property
    def meaning(self) -> str:
        """Return what the two widths say."""
        ratio = self.low / self.high
        if abs(ratio - 1.0) < _EQUAL:
            return "it is as wide everywhere, as lost stroke is and friction along the tendon is not"
        if ratio < _GROWS:
            return "it widens with tension, as friction along the tendon does and lost stroke does not"
        return "it neither keeps its width nor grows in proportion to tension"


def widest_loop(runs: Sequence[JointRun]) -> Loop | None:
    """Return the loop of the run with the largest travel that goes up and comes back far enough; None without one."""
    found = [
        (float(np.ptp(run.drive[up.start : up.stop])), loop)
        for run in runs
        if run.response.shape[1] == 1
        for up, down in pairwise(run.branches.moves)
        if up.direction > 0 > down.direction
        and min(up.stop - up.start, down.stop - down.start) >= _FEWEST
        and (loop := _loop(run, slice(up.start, up.stop), slice(down.start, down.stop))) is not None
    ]
    return max(found, key=lambda one: one[0])[1] if found else None


def _loop(run: JointRun, up: slice, down: slice) -> Loop | None:
    response = run.response[:, 0]
    rising, falling = response[up], response[down]
    if not (np.all(np.isfinite(rising)) and np.all(np.isfinite(falling))):
        return None
    low, top = float(np.nanmin(response)), float(rising.max())
    if max(rising.min(), falling.min()) > low + _LOW[0] * (top - low):
        return None
    widths = [
        _crossing(run.drive[up], rising, level) - _crossing(run.drive[down][::-1], falling[::-1], level)
        for level in (low + share * (top - low) for share in (*_LOW, *_HIGH))
    ]
    near, far = float(np.mean(widths[: len(_LOW)])), float(np.mean(widths[len(_LOW) :]))
    return Loop(near, far) if far > 0.0 else None


def _crossing(drive: FloatArray, response: FloatArray, level: float) -> float:
    """Return the drive at which a response that rises first passes a level."""
    place = int(np.argmax(response >= level))
    if place == 0:
        return float(drive[0])
    part = (level - response[place - 1]) / (response[place] - response[place - 1])
    return float(drive[place - 1] + part * (drive[place] - drive[place - 1]))
