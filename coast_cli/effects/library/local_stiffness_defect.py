"""Local stiffness defect: one place is softer (a cracked strip) or stiffer (solder in a notch) than the rest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import TUBE, OnPieces, Photographed, Pieces
from coast_cli.units import MILLIMETRE

_PLACES = 24
_SHORT, _LONG = 1.0 / 150.0, 1.0 / 25.0  # of the tube


@dataclass(frozen=True)
class LocalStiffnessDefect(OnPieces):
    """Rigidity times a ratio over a short length round an arc length."""

    arc_length_mm: float = 0.0
    stiffness_ratio: float = 1.0
    length_mm: float = 0.6
    tube: float = 0.0

    id = "local_stiffness_defect"
    title = "one place softer or stiffer"
    component = "notch"
    equation = "1/EI(s) -> 1/EI(s) + (1/ratio - 1)/EI_series for |s - arc_length| < length/2"
    source = "a cracked or burnt strip, solder or glue in a few notches"
    parameters = (
        Parameter("arc_length_mm", 0.0, 0.0, 5000.0, (1.0,), "anywhere on the tube"),
        Parameter(
            "stiffness_ratio",
            1.0,
            0.01,
            50.0,
            (0.3, 8.0),
            "from a strip nearly through to a filled notch",
            logarithmic=True,
        ),
        Parameter("length_mm", 0.6, 0.05, 200.0, (1.0,), "one pitch to a few", logarithmic=True),
        TUBE,
    )
    is_local = True
    decided_by = "the same tube clamped further along, so that the place moves in the picture"

    @classmethod
    def starts(cls, seen: Photographed) -> list[Self]:
        """Return soft spots and stiff stretches at many places, on every tube."""
        length = seen.length / MILLIMETRE
        places = (np.arange(_PLACES) + 0.5) / _PLACES * length
        kinds = ((0.3, _SHORT * length), (8.0, _LONG * length))
        return [cls(float(p), ratio, width, tube) for tube in cls.each(seen) for ratio, width in kinds for p in places]

    @classmethod
    def widths(cls, seen: Photographed) -> np.ndarray:
        """Return the prior widths: the whole tube, and factors."""
        length = seen.length / MILLIMETRE
        return np.array([length, 1.5, 1.5])

    @classmethod
    def one_sided(cls) -> bool:
        """Return that soft and stiff places have starts of their own."""
        return True

    def scaled(self, amount: float) -> Self:
        """Return the place with its added compliance times the amount."""
        added = float(np.clip(amount, 0.02, 100.0)) * (1.0 / self.stiffness_ratio - 1.0)
        return replace(self, stiffness_ratio=float(np.clip(1.0 / max(1.0 + added, 1e-6), 0.012, 40.0)))

    def pieces(self, pieces: Pieces) -> Pieces:
        """Add compliance evenly where the tube is softer; take the same share off every piece where it is stiffer."""
        ends = np.cumsum(pieces.length)
        low = (self.arc_length_mm - self.length_mm / 2.0) * MILLIMETRE
        high = (self.arc_length_mm + self.length_mm / 2.0) * MILLIMETRE
        inside = np.clip(np.minimum(ends, high) - np.maximum(ends - pieces.length, low), 0.0, None) / pieces.length
        own = 1.0 / pieces.rigidity
        # Evenly, not piece by piece: else a fit of the place would find a minimum at every notch.
        base = float(own @ pieces.length) / float(pieces.length.sum()) if self.stiffness_ratio < 1.0 else own
        return replace(pieces, rigidity=1.0 / (own + inside * base * (1.0 / self.stiffness_ratio - 1.0)))
