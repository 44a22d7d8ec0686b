"""Gravity: the weight of the segment, where the plane of bending is not horizontal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import HOMED, Effect, Parameter, Segment
from coast_cli.effects.external_moment import weight_arm
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray

STANDARD_GRAVITY = 9.81


@dataclass(frozen=True)
class Gravity(Effect):
    """The in-plane share of gravity across the straight segment; positive bends the way the tendon does."""

    share: float = 0.0
    homed: float = 0.0

    id = "gravity"
    title = "weight of the segment"
    component = "environment"
    stage = "structure"
    scope = "bench"
    equation = "M = M_elastic - share g w weight_arm(kappa, X2)"
    source = "P (3)-(7) for the weight; each notch of an arc feels its own moment, a joint of one station the mean"
    parameters = (
        Parameter("share", 0.0, -1.5, 1.5, (0.5, -0.5), "sine of the plane's tilt, -1 to 1"),
        HOMED,
    )
    unlikely = 2.0  # planes of bending are levelled before a recording
    varies_along = True
    decided_by = "the same sweep with the plane of bending turned over, and at two bending lengths"

    def homing(self) -> float:
        """Return the share of the rest shape that the zero of the stroke counts."""
        return self.homed

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off what the weight already bends."""
        if self.share == 0.0:
            return moment
        load = self.share * STANDARD_GRAVITY * _mass_per_length(segment.joint)
        return moment - load * weight_arm(curvature, segment)


def _mass_per_length(joint: Joint) -> float:
    tubes = (joint.middle,) if joint.outer is None else (joint.outer, joint.middle)
    return float(sum(np.dot(tube.segments.weight, tube.segments.length) / tube.length for tube in tubes))
