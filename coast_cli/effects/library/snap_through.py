"""Snap-through: the outer tube lets go, so that one moment has two stable curvatures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import Parameter, Segment
from coast_cli.effects.stages import OnStructure
from coast_cli.mechanics.section import FloatArray

_NO_JUMP = 1e-9  # 1/m


@dataclass(frozen=True)
class SnapThrough(OnStructure):
    """A drop of the moment around a curvature; the forward model jumps across what it cannot hold."""

    curvature_per_m: float = 20.0
    drop: float = 0.0
    sharpness: float = 0.5
    back: float = 0.8

    id = "snap_through"
    title = "outer tube snaps through"
    component = "tube pair"
    equation = (
        "M = EI (kappa - jump (1 + tanh((kappa - at)/width))/2), jump = drop kappa_s, width = sharpness jump/2, "
        "at = kappa_s on load, back kappa_s + jump on release"
    )
    source = "P, section on pair choice: snapping seen where the outer tube leads; two stable curvatures for one moment"
    parameters = (
        Parameter(
            "curvature_per_m",
            20.0,
            0.5,
            200.0,
            (0.2, 0.35, 0.5, 0.65, 0.8),
            "where it was seen",
            "curvature",
            role="shape",
        ),
        Parameter("drop", 0.0, 0.0, 1.2, (0.15, 0.4), "share of the moment that is let go"),
        Parameter(
            "sharpness",
            0.5,
            0.05,
            0.9,
            (0.4,),
            "under 1 the moment falls while it lets go, as two stable states need",
            role="shape",
        ),
        Parameter(
            "back",
            0.8,
            0.1,
            1.0,
            (0.9, 0.6),
            "moment at which it comes back over that at which it lets go",
            role="shape",
        ),
    )
    needs = ("outer",)
    reverses = True
    decided_by = "slow loading and release through the jump, in steps of at most 0.02 mm"

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off the moment that is let go."""
        jump = self.drop * self.curvature_per_m
        if jump < _NO_JUMP:
            return moment
        at = self.curvature_per_m if direction > 0 else self.back * self.curvature_per_m + jump
        gone = 0.5 * (1.0 + np.tanh((curvature - at) / (0.5 * self.sharpness * jump)))
        return moment - segment.rigidity * jump * gone
