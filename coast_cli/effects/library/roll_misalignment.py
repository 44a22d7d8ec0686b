"""Roll misalignment: outer and middle tube are not assembled 180 degrees apart.

The middle tube's natural curvature vector turns by the roll: cos(roll) of it stays in the plane, sin(roll) leaves it. Both
components settle on the pair's rigidity-weighted mean (P (8), for each plane; the composite's rigidity about its
softest plane is taken for both). With beta the turn out of the plane, the picture shows ds cos(beta) of every ds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import Loads, OnPair
from coast_cli.units import DEGREE


@dataclass(frozen=True)
class RollMisalignment(OnPair):
    """Angle by which the middle tube misses its place opposite the outer one; its sign does not show in one picture."""

    angle_deg: float = 0.0

    id = "roll_misalignment"
    title = "outer and middle not 180 degrees apart"
    component = "pair"
    equation = "k_in = (EI_o k_o - EI_m k_m cos roll)/EI, k_out = EI_m k_m sin roll/EI, seen: ds cos(integral k_out)"
    source = "P (8) as a vector; projection of a curve in space"
    parameters = (Parameter("angle_deg", 0.0, 0.0, 180.0, (10.0, 25.0), "set by eye to a few degrees"),)
    order = 2
    decided_by = "the pair turned by 90 degrees, where what left the plane lies in it; and each tube alone"

    def loads(self, loads: Loads) -> Loads:
        """Roll the middle tube."""
        return replace(loads, roll=loads.roll + self.angle_deg * DEGREE)
