"""The front of a growing number of designs: those that no other matches in every objective and beats in one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.rank import pareto
from coast_cli.mechanics.section import FloatArray

_SCOUTS = 64  # members of the front that newcomers meet first; they turn most away


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


@dataclass
class Front:
    """The undominated designs so far: costs, shape (n, k), and columns of what is known of them, in order of arrival."""

    costs: FloatArray | None = None
    columns: dict[str, NDArray[np.generic]] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of designs on the front."""
        return 0 if self.costs is None else len(self.costs)

    def add(self, costs: FloatArray, columns: Mapping[str, NDArray[np.generic]]) -> None:
        """Take in designs, and let go of those that are now dominated."""
        rows = np.arange(len(costs))
        if self.costs is not None and self.size:
            scouts = self.costs[np.linspace(0, self.size - 1, min(self.size, _SCOUTS)).astype(int)]
            beaten = np.zeros(len(costs), dtype=bool)
            for scout in scouts:
                beaten |= np.all(scout <= costs, axis=1) & np.any(scout < costs, axis=1)
            rows = rows[~beaten]
        if rows.size == 0:
            return
        together = costs[rows] if self.costs is None else np.concatenate((self.costs, costs[rows]))
        keep = undominated(together)
        self.costs = together[keep]
        self.columns = {
            name: (np.concatenate((self.columns[name], values[rows])) if self.columns else values[rows])[keep]
            for name, values in columns.items()
        }
