"""Pre-curvature gradient: the natural curvature changes along the tube."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import OF_CURVATURE, TUBE, OnPieces, Photographed, Pieces
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class PrecurvatureGradient(OnPieces):
    """Natural curvature that grows from the clamp to the tip, its mean unchanged.

    ``of_per_m`` 0: by the same gradient on every tube that it sits on; else that of a tube of this natural curvature, and
    of every other in proportion to its own.
    """

    per_m_per_mm: float = 0.0
    tube: float = 0.0
    of_per_m: float = 0.0

    id = "precurvature_gradient"
    title = "natural curvature changes along the tube"
    component = "tube"
    equation = "k0(s) = k0 + gradient (s - L/2)"
    source = "laser heat builds up along a cut; first order in s"
    parameters = (
        Parameter("per_m_per_mm", 0.0, -20.0, 20.0, (2.0,), "a few 1/m over the tube's length", "gradient"),
        TUBE,
        OF_CURVATURE,
    )
    decided_by = "the same tube turned over: natural curvature changes its side, a load does not"

    @property
    def variant(self) -> tuple[str, float]:
        """Its id, and the tube it sits on; -1 where every tube has it in proportion to its own curvature."""
        return self.id, -1.0 if self.of_per_m else self.tube

    @classmethod
    def starts(cls, seen: Photographed) -> list[Self]:
        """Return the same gradient on all tubes or on each, and one in proportion to each tube's own curvature."""
        size = cls.parameters[0].starts[0] * seen.scales["gradient"]
        found = [cls(size, tube) for tube in cls.places(seen)]
        several = len(seen.alone) > 1 and seen.natural > 0.0
        return [*found, cls(size, 0.0, seen.natural)] if several else found

    def pieces(self, pieces: Pieces) -> Pieces:
        """Add the part that grows."""
        added = self.per_m_per_mm / MILLIMETRE * (pieces.middle - pieces.length.sum() / 2.0)
        if self.of_per_m:
            return replace(pieces, own=pieces.own * (1.0 + added / self.of_per_m))
        return replace(pieces, natural=pieces.natural + added)
