"""Kink: the tube was bent past yield in one place and stays bent there, whatever hangs on it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import TUBE, OnPieces, Photographed, Pieces, hump, spots
from coast_cli.units import DEGREE, MILLIMETRE

_ANGLE_DEG = 2.0


@dataclass(frozen=True)
class Kink(OnPieces):
    """An angle at an arc length; positive on the side to which the tube's natural curvature points."""

    angle_deg: float = 0.0
    arc_length_mm: float = 0.0
    tube: float = 0.0

    id = "kink"
    title = "the tube is kinked in one place"
    component = "tube"
    equation = "k0(s) -> k0(s) + angle delta(s - arc_length)"
    source = "plastic bend of one strip: a turn that is there without load"
    parameters = (
        Parameter("angle_deg", 0.0, -60.0, 60.0, (_ANGLE_DEG,), "what the eye just sees, to a strip bent through"),
        Parameter("arc_length_mm", 0.0, 0.0, 5000.0, (1.0,), "anywhere on the tube"),
        TUBE,
    )
    unlikely = 2.0
    decided_by = "the same tube turned over: a kink changes its side with the tube, a soft place does not"

    @classmethod
    def starts(cls, seen: Photographed) -> list[Self]:
        """Return a kink at many places of every tube."""
        return [cls(_ANGLE_DEG, place, tube) for tube in cls.each(seen) for place in spots(seen)]

    @classmethod
    def widths(cls, seen: Photographed) -> np.ndarray:
        """Return the prior widths: a few degrees, and the whole tube."""
        return np.array([2.0 * _ANGLE_DEG, seen.length / MILLIMETRE])

    def pieces(self, pieces: Pieces) -> Pieces:
        """Add the turn."""
        return replace(pieces, natural=pieces.natural + self.angle_deg * DEGREE * hump(pieces, self.arc_length_mm))
