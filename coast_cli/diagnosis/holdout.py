"""Kinds of rows: those that are fitted, and those kept back from every fit so that a verdict can rest on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from coast_cli.diagnosis.space import Booleans
from coast_cli.errors import BadInput, nearest


class NamedRun(Protocol):
    """A run by its name and number of rows."""

    @property
    def name(self) -> str:
        """As in its file."""

    def __len__(self) -> int:
        """Return the number of rows."""


@dataclass(frozen=True, slots=True)
class HoldOut:
    """Rows of every run by kind.

    Attributes:
        rows: kept back, run by run. runs: names of the runs that they make up. rule: how they were chosen, in words.
        chosen: by that rule; False where the user named them.
    """

    rows: tuple[Booleans, ...]
    runs: tuple[str, ...]
    rule: str
    chosen: bool

    @property
    def fitted(self) -> tuple[Booleans, ...]:
        """Rows that are fitted, run by run."""
        return tuple(~rows for rows in self.rows)

    @property
    def any(self) -> bool:
        """Whether anything is kept back."""
        return any(bool(rows.any()) for rows in self.rows)


def check_named(names: Sequence[str], named: Sequence[str]) -> None:
    """Refuse runs to hold out that do not exist, and all of them at once.

    Raises:
        BadInput: says which.
    """
    for name in named:
        if name not in names:
            raise BadInput(
                "there is no such run to hold out",
                found=name,
                allowed=", ".join(names),
                hint=nearest(name, names),
            )
    if named and len(set(named)) == len(names):
        raise BadInput("every run is held out, so none is left to fit", allowed="some of the runs")


def whole_runs(runs: Sequence[NamedRun], names: Sequence[str], rule: str, *, chosen: bool) -> HoldOut:
    """Return whole runs as kept back, by name."""
    rows = tuple(np.full(len(run), run.name in names) for run in runs)
    return HoldOut(rows, tuple(run.name for run in runs if run.name in names), rule, chosen)
