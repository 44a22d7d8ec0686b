"""Base tilt: the tube leaves the clamp at an angle."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import Loads, OnBench
from coast_cli.units import DEGREE


@dataclass(frozen=True)
class BaseTilt(OnBench):
    """Angle of the clamped tangent, positive upward."""

    angle_deg: float = 0.0

    id = "base_tilt"
    title = "the clamp holds the tube at an angle"
    component = "clamp"
    scope = "bench"
    equation = "theta(0) = angle"
    source = "boundary condition of P (3)-(7)"
    parameters = (Parameter("angle_deg", 0.0, -30.0, 30.0, (1.0,), "a clamp set by eye is good to a degree or two"),)
    decided_by = "the same tube turned over in the same clamp: a tilt keeps its side, natural curvature changes it"

    def loads(self, loads: Loads) -> Loads:
        """Turn the clamp."""
        return replace(loads, base_angle=loads.base_angle + self.angle_deg * DEGREE)
