"""Which photographs are kept back: those named, else chosen by a rule that is stated with the answer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from coast_cli.diagnosis.holdout import HoldOut
from coast_cli.diagnosis.shapes.photograph import Photograph
from coast_cli.errors import BadInput, nearest

_BLOCKS = 8
_SHORTEST_FOR_BLOCKS = 32


def hold_out_photographs(photographs: Sequence[Photograph], named: Sequence[str] = ()) -> HoldOut:
    """Return what to keep back.

    Raises:
        BadInput: a named run does not exist, or every run is named.
    """
    names = [photograph.run.name for photograph in photographs]
    for name in named:
        if name not in names:
            raise BadInput("there is no such run", key="--hold-out", found=name, allowed=", ".join(names),
                           hint=nearest(name, names))  # fmt: skip
    if named:
        if len(set(named)) == len(names):
            raise BadInput("every run is held out, so none is left to fit", key="--hold-out", allowed="some of the runs")
        return _whole(photographs, set(named), "the runs named", chosen=False)
    spared = _expendable(photographs) if len(photographs) >= 3 else set()
    if spared:
        rule = "the last photographs whose tube and side up others also show, a quarter at most"
        return _whole(photographs, spared, rule, chosen=True)
    rows = []
    for photograph in photographs:
        count = len(photograph.run)
        block = np.arange(count) * _BLOCKS // max(count, 1)
        rows.append(np.isin(block, (2, 5)) if count >= _SHORTEST_FOR_BLOCKS else np.zeros(count, bool))
    rule = "stretches of every shape, as no whole one can be spared; this is weaker than a shape that was not seen"
    return HoldOut(tuple(rows), (), rule, chosen=True)


def _whole(photographs: Sequence[Photograph], names: set[str], rule: str, *, chosen: bool) -> HoldOut:
    rows = tuple(np.full(len(photograph.run), photograph.run.name in names) for photograph in photographs)
    return HoldOut(rows, tuple(p.run.name for p in photographs if p.run.name in names), rule, chosen)


def _expendable(photographs: Sequence[Photograph]) -> set[str]:
    """Return photographs of tubes that stay in another, with both sides up still shown."""
    wanted = max(1, len(photographs) // 4)
    kept, found = list(photographs), set[str]()
    for photograph in reversed(photographs):
        others = [other for other in kept if other is not photograph]
        conditions = set().union(*map(_conditions, others)) if others else set()
        if len(found) < wanted and len(others) >= 2 and _conditions(photograph) <= conditions:
            kept = others
            found.add(photograph.run.name)
    return found


def _conditions(photograph: Photograph) -> set[tuple[str, object]]:
    return {("tubes", tuple(number for number, _ in photograph.tubes)), ("up", photograph.upward)}
