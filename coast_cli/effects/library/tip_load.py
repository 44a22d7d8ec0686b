"""Tip load: a force at the tip, across the straight segment and in the plane of bending."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import HOMED, Effect, Parameter, Segment
from coast_cli.effects.external_moment import tip_force_arm
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class TipLoad(Effect):
    """A force of fixed direction at the tip; positive bends the way the tendon does."""

    force_mn: float = 0.0
    homed: float = 0.0

    id = "tip_load"
    title = "a force at the tip"
    component = "environment"
    stage = "structure"
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

    def homing(self) -> float:
        """Return the share of the rest shape that the zero of the stroke counts."""
        return self.homed

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off what the force already bends."""
        if self.force_mn == 0.0:
            return moment
        return moment - self.force_mn * 1e-3 * tip_force_arm(curvature, segment)
