"""Pre-curvature: the assembled segment is bent before the tendon pulls."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import HOMED, Parameter, Segment
from coast_cli.effects.stages import OnStructure
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class Precurvature(OnStructure):
    """Bend at zero tension."""

    curvature_per_m: float = 0.0
    homed: float = 0.0

    id = "precurvature"
    title = "bent at zero tension"
    component = "tube pair"
    equation = "M = EI (kappa - curvature)"
    source = "P (8): the pair's own curvature, which (9)-(12) take as zero"
    parameters = (
        Parameter("curvature_per_m", 0.0, -60.0, 60.0, (1.0, -1.0), "natural curvatures of cut tubes, 0 to 15 per m"),
        HOMED,
    )
    decided_by = "the slack segment at two bending lengths, before the tendon pulls"

    def homing(self) -> float:
        """Return the share of the rest shape that the zero of the stroke counts."""
        return self.homed

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Measure the elastic moment from the bent rest shape."""
        return moment - self.curvature_per_m * segment.rigidity
