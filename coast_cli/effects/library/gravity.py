"""Gravity: the weight of a segment whose plane of bending is not horizontal, or of a tube whose picture is not vertical."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import HOMED, Parameter, Segment
from coast_cli.effects.external_moment import weight_arm
from coast_cli.effects.shape_stages import Loads, OnBench
from coast_cli.effects.stages import OnStructure
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray

STANDARD_GRAVITY = 9.81


@dataclass(frozen=True)
class Gravity(OnStructure, OnBench):
    """The in-plane share of gravity: of a joint across the straight segment, positive bends the way the tendon does."""

    share: float = 0.0
    homed: float = 0.0
    in_plane_share: float = 1.0

    id = "gravity"
    title = "weight of the segment"
    component = "environment"
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
    on_shapes = {
        "title": "weight out of the plane",
        "equation": "w -> in_plane_share w",
        "source": "P (3)-(7): the equations hold w/E alone, so with one material and no other load it is a modulus",
        "parameters": (Parameter("in_plane_share", 1.0, 0.0, 2.0, (0.9,), "cosine of the plane's tilt"),),
        "unlikely": 0.0,
        "decided_by": "the same tube with a known weight at its tip: a force that does not scale with the tube's own weight",
    }

    def homing(self) -> float:
        """Return the share of the rest shape that the zero of the stroke counts."""
        return self.homed

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off what the weight already bends."""
        if self.share == 0.0:
            return moment
        load = self.share * STANDARD_GRAVITY * _mass_per_length(segment.joint)
        return moment - load * weight_arm(curvature, segment)

    def loads(self, loads: Loads) -> Loads:
        """Take the share of a photographed tube's weight."""
        return replace(loads, gravity=loads.gravity * self.in_plane_share)


def _mass_per_length(joint: Joint) -> float:
    tubes = (joint.middle,) if joint.outer is None else (joint.outer, joint.middle)
    return float(sum(np.dot(tube.segments.weight, tube.segments.length) / tube.length for tube in tubes))
