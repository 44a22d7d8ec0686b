"""Distributed notch friction: tension decays along the segment with each notch's own bend."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Parameter
from coast_cli.effects.stages import OnTransmission


@dataclass(frozen=True)
class DistributedNotchFriction(OnTransmission):
    """Capstan friction at each notch edge, by the angle that the notch has bent."""

    coefficient: float = 0.0
    own_share: float = 0.5

    id = "distributed_notch_friction"
    title = "friction at the notches grows with their bend"
    component = "notches"
    equation = "F_i = F exp(-+ coefficient (sum_(j<i) theta_j + own_share theta_i)), minus on load, plus on release"
    source = "physics.md, sizes worth knowing: a constant eta is right at one curvature only; mu 0.1 to 0.4"
    parameters = (
        Parameter("coefficient", 0.0, 0.0, 1.5, (0.05, 0.2, 0.5), "tendon in notched nitinol 0.1 to 0.4"),
        Parameter(
            "own_share",
            0.5,
            0.0,
            1.0,
            (0.5,),
            "of a notch's own bend: all of it, none, or one edge of two",
            role="shape",
        ),
    )
    reverses = True
    varies_along = True
    decided_by = "bend notch by notch (or photographs) along the segment while loading and releasing"

    @property
    def lumps(self) -> int:
        """Parts of the segment along which the tension decays."""
        return 12 if self.coefficient > 0.0 else 1

    def notch_friction(self) -> tuple[float, float]:
        """Return the friction coefficient at the notch edges and the share of a notch's own bend."""
        return self.coefficient, self.own_share
