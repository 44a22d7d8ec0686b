"""What joint recordings can decide: the one answer for what is said of them, tried on them and planned after them.

Every threshold stands once (``recordings.thresholds``), so that a note, a candidate and a plan cannot contradict each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.thresholds import (
    FEWEST_HELD,
    FEWEST_RELEASED,
    RATE_SAMPLES,
    RATE_TRAVEL,
    RATES_DIFFER,
    SAME_DRIVE,
    SAME_LENGTH,
    STILL,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Evidence:
    """What some runs hold.

    Attributes:
        runs: how many there are.
        released: how many of them were let go.
        cycles: the most that one run holds.
        holds: whether the drive stays anywhere.
        untimed: how many runs have no clock.
        rates: slowest and fastest of the branches, of the drive per second; None where none has a rate.
        lengths: shortest and longest bending length, m; None for devices that have none.
        strokes: how many runs have a stroke. tensions: how many a tension beside it.
        loads: how many runs say what load they carried.
        repeats: how many runs repeat one another, 1 where none does.
    """

    runs: int
    released: int
    cycles: int
    holds: bool
    untimed: int
    rates: tuple[float, float] | None
    lengths: tuple[float, float] | None
    strokes: int
    tensions: int
    loads: int
    repeats: int

    @property
    def has_release(self) -> bool:
        """Whether anything that shows on release (friction, play, set) can show."""
        return self.released > 0

    @property
    def has_clock(self) -> bool:
        """Whether every run has one, so that anything about time can be concluded."""
        return self.untimed == 0

    @property
    def rate_ratio(self) -> float:
        """Fastest over slowest branch, 1 where rates are not known."""
        return 1.0 if self.rates is None else self.rates[1] / self.rates[0]

    @property
    def has_rates(self) -> bool:
        """Whether what depends on rate can be told from what does not: rates that differ, or a hold, and a clock."""
        return self.has_clock and (self.holds or self.rate_ratio > RATES_DIFFER)

    @property
    def has_lengths(self) -> bool:
        """Whether what grows with the bending length can be told from the modulus."""
        return self.lengths is not None and self.lengths[1] - self.lengths[0] > SAME_LENGTH * self.lengths[1]

    @property
    def has_witness(self) -> bool:
        """Whether each run has stroke and tension, so that the tendon's stretch shows by itself."""
        return self.runs > 0 and self.strokes == self.tensions == self.runs


def evidence_of(runs: Sequence[JointRun]) -> Evidence:
    """Return what runs hold; no runs hold nothing."""
    lengths = np.concatenate([run.bending_length for run in runs]) if runs else np.zeros(0)
    lengths = lengths[np.isfinite(lengths)]
    widest = max((float(np.ptp(run.drive)) for run in runs), default=0.0)
    moved = [run for run in runs if float(np.ptp(run.drive)) > STILL * widest]
    rates = [rate for run in moved for rate in branch_rates(run)]
    return Evidence(
        runs=len(runs),
        released=sum(int((run.direction < 0).sum()) >= FEWEST_RELEASED for run in runs),
        cycles=max((run.branches.cycles for run in runs), default=0),
        holds=any(part.stop - part.start >= FEWEST_HELD for run in runs for part in run.branches.holds),
        untimed=sum(run.time is None for run in runs),
        rates=(min(rates), max(rates)) if rates else None,
        lengths=(float(lengths.min()), float(lengths.max())) if len(lengths) else None,
        strokes=sum(run.stroke is not None for run in runs),
        tensions=sum(run.stroke is not None and run.tension is not None for run in runs),
        loads=sum(run.load is not None or run.load_moment is not None for run in runs),
        repeats=_repeats(runs),
    )


def branch_rates(run: JointRun) -> list[float]:
    """Return how fast the drive (SI) moved in each branch that is long enough to have a rate; none without a clock."""
    rates = []
    least = RATE_TRAVEL * float(np.ptp(run.drive))
    for part in run.branches.moves:
        if run.time is None or part.stop - part.start < RATE_SAMPLES:
            continue
        seconds = float(run.time[part.stop - 1] - run.time[part.start])
        travel = abs(float(run.drive[part.stop - 1] - run.drive[part.start]))
        if seconds > 0.0 and travel > least:
            rates.append(travel / seconds)
    return rates


def drive_speed(run: JointRun) -> Floats:
    """Return how fast the drive (SI) moved at each sample, [n] per s: 0 in a hold, and never of a clock that stands.

    Samples with one time stamp share the speed between the stamps around them; without a clock all is 0.
    """
    nothing = np.zeros(len(run))
    if run.time is None:
        return nothing
    first = np.append(True, np.diff(run.time) > 0.0)
    if first.sum() < 2:
        return nothing
    speed = np.abs(np.gradient(run.drive[first], run.time[first]))
    return np.where(run.direction == 0, 0.0, np.interp(run.time, run.time[first], speed))


def _repeats(runs: Sequence[JointRun]) -> int:
    """Return the size of the largest group of runs of one pair and length that reach alike."""
    groups: dict[tuple[str, float], list[float]] = {}
    for run in runs:
        length = float(np.median(run.bending_length))
        key = (run.pair, round(length, 4) if np.isfinite(length) else 0.0)
        groups.setdefault(key, []).append(float(run.drive.max()))
    return max(
        (
            sum(abs(one - other) <= SAME_DRIVE * abs(one) for other in group)
            for group in groups.values()
            for one in group
        ),
        default=0,
    )
