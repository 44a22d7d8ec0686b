"""Which runs of a joint are kept back: those named, else chosen by a rule that is stated with the answer."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from coast_cli.diagnosis.holdout import HoldOut, check_named, whole_runs
from coast_cli.diagnosis.thresholds import (
    BLOCKS,
    FEWEST_IN_BRANCH,
    FEWEST_RUNS_TO_SPARE,
    LEAST_KEPT_BACK,
    MOST_KEPT_BACK,
    SHORTEST_FOR_BLOCKS,
)
from coast_cli.recordings.model import JointRun

ONE_RUN = "a quarter of the one run that differs, in blocks"


def hold_out(runs: Sequence[JointRun], named: Sequence[str] = ()) -> HoldOut:
    """Return what to keep back.

    Raises:
        BadInput: a named run does not exist, or every run is named.
    """
    names = [run.name for run in runs]
    check_named(names, named)
    if named:
        return whole_runs(runs, tuple(name for name in names if name in set(named)), "the runs named", chosen=False)
    if len(runs) >= 3:
        found = _expendable(runs)
        if found:
            rule = "the last runs whose bending length, pair and directions other runs also hold, a quarter at most"
            return whole_runs(runs, found, rule, chosen=True)
    return _after_first_cycle(runs) or _blocks(runs)


def _expendable(runs: Sequence[JointRun]) -> tuple[str, ...]:
    """Return runs whose conditions are all met by runs that stay."""
    wanted = max(1, len(runs) // 4)
    kept = list(runs)
    found: list[str] = []
    for run in reversed(runs):
        others = [other for other in kept if other is not run]
        if len(found) < wanted and len(others) >= 2 and _conditions(run) <= set().union(*map(_conditions, others)):
            kept = others
            found.append(run.name)
    return tuple(run.name for run in runs if run.name in found)


def _conditions(run: JointRun) -> set[tuple[str, object]]:
    length = round(float(np.nan_to_num(np.median(run.bending_length))) * 1e4)  # a device has none
    directions = {("direction", int(way)) for way in np.unique(run.direction) if int(np.sum(run.direction == way)) >= 3}
    return {("length", length), ("pair", run.pair), *directions}


def _after_first_cycle(runs: Sequence[JointRun]) -> HoldOut | None:
    """Keep back what follows the first full cycle of a run, where that is a good part of it."""
    rows, found = [], False
    for run in runs:
        held = np.zeros(len(run), bool)
        ways = [
            part for part in run.branches.parts if part.direction != 0 and part.stop - part.start >= FEWEST_IN_BRANCH
        ]
        turns = [part.start for before, part in pairwise(ways) if part.direction != before.direction]
        after = turns[1] if len(turns) >= 2 else len(run)
        if (1.0 - MOST_KEPT_BACK) * len(run) <= after <= (1.0 - LEAST_KEPT_BACK) * len(run):
            held[after:] = True
            found = True
        rows.append(held)
    rule = (
        "what follows the first full cycle, as no whole run can be spared; this is weaker than a run that was not seen"
    )
    return HoldOut(tuple(rows), (), rule, chosen=True) if found else None


def _blocks(runs: Sequence[JointRun]) -> HoldOut:
    """Keep back two blocks in eight of every long run; the history between them is still simulated."""
    rows = []
    for run in runs:
        block = np.arange(len(run)) * int(BLOCKS) // max(len(run), 1)
        held = np.isin(block, (2, 5)) if len(run) >= SHORTEST_FOR_BLOCKS else np.zeros(len(run), bool)
        rows.append(held)
    rule = "blocks of every run, as no whole run can be spared; this is weaker than a run that was not seen"
    return HoldOut(tuple(rows), (), rule, chosen=True)


def hold_out_others(runs: Sequence[JointRun], before: HoldOut) -> HoldOut | None:
    """Return a whole run to keep back instead of those kept back before, or None where none can be spared."""
    if not before.runs:
        return None
    again = [*(run for run in runs if run.name in before.runs), *(run for run in runs if run.name not in before.runs)]
    found = [name for name in _expendable(again) if name not in before.runs][:1]
    rule = "a run whose bending length, pair and directions other runs also hold, after another one disagreed"
    return whole_runs(runs, found, rule, chosen=True) if found else None


def rows_that_choose(runs: Sequence[JointRun], certifying: HoldOut) -> HoldOut:
    """Return a whole run of what is left that chooses among hypotheses; none where no run can be spared.

    Args:
        certifying: rows that are kept from every fit and every choice.
    """
    left = [run for run, rows in zip(runs, certifying.rows, strict=True) if not rows.any()]
    found = _expendable(left)[-1:] if len(left) >= FEWEST_RUNS_TO_SPARE else ()
    rule = "a run whose conditions other runs also hold" if found else "none, as no run can be spared"
    return whole_runs(runs, found, rule, chosen=True)


def rows_of_one_run(runs: Sequence[JointRun], number: int) -> HoldOut:
    """Return blocks of one run, a quarter of it, as kept back."""
    block = np.arange(len(runs[number])) * int(BLOCKS) // max(len(runs[number]), 1)
    rows = tuple(
        np.isin(block, (2, 5)) if index == number else np.zeros(len(run), bool) for index, run in enumerate(runs)
    )
    return HoldOut(rows, (), ONE_RUN, chosen=True)
