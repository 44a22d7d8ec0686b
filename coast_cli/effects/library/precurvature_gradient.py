"""Pre-curvature gradient: the natural curvature changes along the tube."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import TUBE, OnPieces, Pieces
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class PrecurvatureGradient(OnPieces):
    """Natural curvature that grows from the clamp to the tip, its mean unchanged."""

    per_m_per_mm: float = 0.0
    tube: float = 0.0

    id = "precurvature_gradient"
    title = "natural curvature changes along the tube"
    component = "tube"
    equation = "k0(s) = k0 + gradient (s - L/2)"
    source = "laser heat builds up along a cut; first order in s"
    parameters = (
        Parameter("per_m_per_mm", 0.0, -20.0, 20.0, (2.0,), "a few 1/m over the tube's length", "gradient"),
        TUBE,
    )
    decided_by = "the same tube turned over: natural curvature changes its side, a load does not"

    def pieces(self, pieces: Pieces) -> Pieces:
        """Add the part that grows."""
        gradient = self.per_m_per_mm / MILLIMETRE
        return replace(pieces, natural=pieces.natural + gradient * (pieces.middle - pieces.length.sum() / 2.0))
