"""Which photographs are kept back: those named, else chosen by a rule that is stated with the answer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from coast_cli.diagnosis.holdout import HoldOut, check_named, whole_runs
from coast_cli.diagnosis.shapes.photograph import Photograph
from coast_cli.diagnosis.thresholds import BLOCKS, SHORTEST_SHAPE_FOR_BLOCKS


def hold_out_photographs(photographs: Sequence[Photograph], named: Sequence[str] = ()) -> HoldOut:
    """Return what to keep back.

    Raises:
        BadInput: a named run does not exist, or every run is named.
    """
    runs = [photograph.run for photograph in photographs]
    check_named([run.name for run in runs], named)
    if named:
        return whole_runs(runs, named, "the runs named", chosen=False)
    spared = _expendable(photographs) if len(photographs) >= 3 else set()
    if spared:
        rule = "photographs taken twice, a quarter at most, else the last whose tube and side up others also show"
        return whole_runs(runs, sorted(spared), rule, chosen=True)
    rows = []
    for photograph in photographs:
        count = len(photograph.run)
        block = np.arange(count) * int(BLOCKS) // max(count, 1)
        rows.append(np.isin(block, (2, 5)) if count >= SHORTEST_SHAPE_FOR_BLOCKS else np.zeros(count, bool))
    rule = "stretches of every shape, as no whole one can be spared; this is weaker than a shape that was not seen"
    return HoldOut(tuple(rows), (), rule, chosen=True)


def _expendable(photographs: Sequence[Photograph]) -> set[str]:
    """Return photographs that were taken twice, a quarter at most; else one whose tube and side up others still show."""
    wanted = max(1, len(photographs) // 4)
    shown = [_view(photograph) for photograph in photographs]
    found = [p.run.name for place, p in enumerate(photographs) if shown[place] in shown[:place]]
    if found:
        return set(found[-wanted:])
    for place in reversed(range(len(photographs))):
        others = shown[:place] + shown[place + 1 :]
        tubes, upward = shown[place]
        if tubes in {other for other, _ in others} and upward in {side for _, side in others}:
            return {photographs[place].run.name}
    return set()


def _view(photograph: Photograph) -> tuple[tuple[int, ...], float]:
    return tuple(number for number, _ in photograph.tubes), photograph.upward
