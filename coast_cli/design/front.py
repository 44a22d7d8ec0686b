"""The front of a growing number of designs: those that no other matches in every objective and beats in one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.rank import pareto
from coast_cli.mechanics.section import FloatArray

_SCOUTS = 64  # members of the front that newcomers meet first; they turn most away
_FEW = 256  # newcomers, from which on the best of them go first
MOST = 20_000  # members, which bounds memory; past it near neighbours are thinned out


def undominated(costs: FloatArray) -> NDArray[np.bool_]:
    """Return which rows of costs, shape (n, k), no other matches in every column and beats in one."""
    count, objectives = costs.shape
    if objectives <= 3:
        return pareto(np.pad(costs, ((0, 0), (0, 3 - objectives))))
    best = np.zeros(count, dtype=bool)
    places = np.stack([np.unique(column, return_inverse=True)[1] for column in costs.T], axis=1)
    left = np.argsort(places.sum(axis=1), kind="stable")
    while left.size:
        first = costs[left[0]]  # who has the least sum of places is beaten by nobody that is left
        best[left[0]] = True
        same = np.all(costs[left] == first, axis=1)
        best[left[same]] = True
        left = left[~np.all(costs[left] >= first, axis=1)]
    return best


def thinned(costs: FloatArray) -> NDArray[np.int64]:
    """Return at most half of ``MOST`` rows, in order: the first of each box of an even grid over the costs.

    So a front is known to within one box (Laumanns et al., Evolutionary Computation 10, 2002).
    """
    low, size = costs.min(axis=0), np.ptp(costs, axis=0)
    share = (costs - low) / np.where(size > 0.0, size, 1.0)
    digits = np.uint64(4099) ** np.arange(costs.shape[1], dtype=np.uint64)  # a box's number; that of few coincide
    boxes = 4096
    while True:
        _, first = np.unique(np.floor(share * boxes).astype(np.uint64) @ digits, return_index=True)
        if first.size <= MOST // 2:
            return np.sort(first)
        boxes //= 2


def _unbeaten(costs: FloatArray, scouts: FloatArray) -> NDArray[np.bool_]:
    """Return which rows no scout dominates."""
    columns, kept = np.ascontiguousarray(costs.T), np.ones(len(costs), dtype=bool)
    for scout in scouts.tolist():
        no_better = np.logical_and.reduce([value <= column for value, column in zip(scout, columns, strict=True)])
        same = np.logical_and.reduce([value == column for value, column in zip(scout, columns, strict=True)])
        kept &= ~no_better | same
    return kept


def _best_by_weights(costs: FloatArray) -> NDArray[np.int64]:
    """Return the rows with the least of some weighted sums of costs, which are undominated and beat most others."""
    scaled = (costs - costs.min(axis=0)) / np.maximum(np.ptp(costs, axis=0), np.finfo(float).tiny)
    weights = np.random.default_rng(0).dirichlet(np.ones(costs.shape[1]), _SCOUTS // 2)
    return np.unique(np.argmin(scaled @ weights.T, axis=0))


@dataclass
class Front:
    """The undominated designs so far, in order of arrival.

    Attributes:
        costs: shape (n, k). columns: what is known of each. thinned: whether near neighbours were left out.
    """

    costs: FloatArray | None = None
    columns: dict[str, NDArray[np.generic]] = field(default_factory=dict)
    thinned: bool = False

    @property
    def size(self) -> int:
        """Number of designs on the front."""
        return 0 if self.costs is None else len(self.costs)

    def add(self, costs: FloatArray, columns: Mapping[str, NDArray[np.generic]]) -> None:
        """Take in designs, and let go of those that are now dominated."""
        rows = np.arange(len(costs))
        if rows.size and self.costs is not None and self.size:
            rows = rows[
                _unbeaten(costs, self.costs[np.linspace(0, self.size - 1, min(self.size, _SCOUTS)).astype(int)])
            ]
        if rows.size > _FEW:
            rows = rows[_unbeaten(costs[rows], costs[rows][_best_by_weights(costs[rows])])]
        if rows.size == 0:
            return
        together = costs[rows] if self.costs is None else np.concatenate((self.costs, costs[rows]))
        keep = np.flatnonzero(undominated(together))
        if keep.size > MOST:
            keep, self.thinned = keep[thinned(together[keep])], True
        self.costs = together[keep]
        self.columns = {
            name: (np.concatenate((self.columns[name], values[rows])) if self.columns else values[rows])[keep]
            for name, values in columns.items()
        }
