"""What a diagnosis is asked for, besides its recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypedDict


class Options(TypedDict):
    """Arguments of a diagnosis of joints or of shapes."""

    named_hold_out: Sequence[str]
    most_effects: int
    without: Sequence[str]
    noise: float | None


@dataclass(frozen=True, slots=True)
class Asked:
    """Runs to hold out by name, the largest set of effects, effects to leave out by id, and the noise where known, SI."""

    hold_out: tuple[str, ...] = ()
    most_effects: int = 5
    without: tuple[str, ...] = ()
    noise: float | None = None

    @property
    def options(self) -> Options:
        """The same as arguments."""
        return Options(
            named_hold_out=self.hold_out, most_effects=self.most_effects, without=self.without, noise=self.noise
        )

    def of_runs(self, names: Sequence[str]) -> Asked:
        """Return the same for some of the runs; a noise is that of all of them."""
        return replace(self, hold_out=tuple(name for name in self.hold_out if name in set(names)))
