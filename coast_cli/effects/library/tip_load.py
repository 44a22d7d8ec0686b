"""Tip load: a force at the tip, across the straight segment and in the plane of bending, such as a drop of glue."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import HOMED, Parameter, Segment
from coast_cli.effects.external_moment import tip_force_arm
from coast_cli.effects.shape_stages import Loads, OnBench
from coast_cli.effects.stages import OnStructure
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLINEWTON


@dataclass(frozen=True)
class TipLoad(OnStructure, OnBench):
    """A force of fixed direction at the tip; positive bends the way the tendon does, and a clamped tube up."""

    force_mn: float = 0.0
    homed: float = 0.0

    id = "tip_load"
    title = "a force at the tip"
    component = "environment"
    scope = "bench"
    equation = "M = M_elastic - force arm(kappa, X2), arm = x_tip - x(s)"
    source = "statics of an arc: each notch feels its own arm, a joint of one station the mean"
    parameters = (
        Parameter("force_mn", 0.0, -500.0, 500.0, (1.0, -1.0), "a few times what bends the free segment"),
        HOMED,
    )
    unlikely = 4.0  # a bench test has none unless somebody hangs it there
    varies_along = True
    decided_by = "the same sweep at two bending lengths: a force's moment grows with X2, pre-curvature does not"
    on_shapes = {
        "equation": "V(s) = integral_s^L w - force",
        "source": "statics of the beam, P (3)-(7)",
        "parameters": (
            Parameter(
                "force_mn",
                0.0,
                -500.0,
                500.0,
                (-0.1,),
                "a weight is negative: parts of the tube's own, and more",
                "weight",
            ),
        ),
        "unlikely": 0.0,
        "decided_by": "the same tube turned over: a load keeps its side; and the tube weighed",
    }

    def homing(self) -> float:
        """Return the share of the rest shape that the zero of the stroke counts."""
        return self.homed

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off what the force already bends."""
        if self.force_mn == 0.0:
            return moment
        return moment - self.force_mn * MILLINEWTON * tip_force_arm(curvature, segment)

    def loads(self, loads: Loads) -> Loads:
        """Pull at the tip of a photographed tube."""
        return replace(loads, upward_force=loads.upward_force + self.force_mn * MILLINEWTON)
