"""Clipped weight: something heavy sits on the tube between clamp and tip, such as a clip or a drop of glue."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import TUBE, OnPieces, Photographed, Pieces, hump, spots
from coast_cli.units import MILLIMETRE

_MILLIGRAM = 1e-6
_SHARE = 0.5  # of the tube's own weight, from which fits start


@dataclass(frozen=True)
class ClippedWeight(OnPieces):
    """A mass at an arc length, spread over a few millimetres."""

    arc_length_mm: float = 0.0
    mass_mg: float = 0.0
    tube: float = 0.0

    id = "clipped_weight"
    title = "a weight on the tube"
    component = "environment"
    scope = "bench"
    equation = "w(s) -> w(s) + m g delta(s - arc_length)"
    source = "statics of the beam, P (3)-(7), with a lumped weight"
    parameters = (
        Parameter("mass_mg", 0.0, 0.0, 50_000.0, (_SHARE,), "parts of the tube's own mass, and more"),
        Parameter("arc_length_mm", 0.0, 0.0, 5000.0, (1.0,), "anywhere on the tube"),
        TUBE,
    )
    unlikely = 2.0
    decided_by = "the same tube turned over and clamped further along: a weight keeps its side and moves in the picture"

    @classmethod
    def starts(cls, seen: Photographed) -> list[Self]:
        """Return a weight at many places of every tube."""
        mass = _SHARE * seen.mass / _MILLIGRAM
        return [cls(place, mass, tube) for tube in cls.each(seen) for place in spots(seen)]

    @classmethod
    def widths(cls, seen: Photographed) -> np.ndarray:
        """Return the prior widths: a few times the tube's mass, and the whole tube."""
        return np.array([4.0 * _SHARE * seen.mass / _MILLIGRAM, seen.length / MILLIMETRE])

    def pieces(self, pieces: Pieces) -> Pieces:
        """Add the mass."""
        return replace(pieces, weight=pieces.weight + self.mass_mg * _MILLIGRAM * hump(pieces, self.arc_length_mm))
