"""Snap-through: the outer tube lets go, so that one moment has two stable curvatures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import Effect, Parameter, Segment
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class SnapThrough(Effect):
    """A drop of the moment around a curvature; the forward model jumps across what it cannot hold."""

    curvature_per_m: float = 1000.0
    drop: float = 0.0
    width: float = 0.08

    id = "snap_through"
    title = "outer tube snaps through"
    component = "tube pair"
    stage = "structure"
    equation = "M = EI (kappa - drop kappa_s (1 + tanh((kappa - kappa_s)/(width kappa_s)))/2)"
    source = "P, section on pair choice: snapping seen where the outer tube leads; two stable curvatures for one moment"
    parameters = (
        Parameter("curvature_per_m", 1000.0, 0.5, 200.0, (0.2, 0.35, 0.5, 0.65, 0.8), "where it was seen", "curvature"),
        Parameter("drop", 0.0, 0.0, 1.2, (0.15, 0.4), "share of the moment that is let go"),
        Parameter("width", 0.08, 0.005, 0.5, (0.05,), "sharpness relative to the curvature"),
    )
    reverses = True
    decided_by = "slow loading and release through the jump, in steps of at most 0.02 mm"

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off the moment that is let go."""
        if self.drop == 0.0:
            return moment
        at = self.curvature_per_m
        gone = 0.5 * (1.0 + np.tanh((curvature - at) / (self.width * at)))
        return moment - self.drop * segment.rigidity * at * gone
