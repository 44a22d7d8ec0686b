"""Tip load: a weight at the tip, such as a drop of glue."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_effect import Loads, Scene, ShapeEffect
from coast_cli.units import MILLINEWTON


@dataclass(frozen=True)
class TipLoad(ShapeEffect):
    """A force at the tip across the clamped tube; positive towards positive curvature, as for joints: up, against gravity."""

    force_mn: float = 0.0

    id = "tip_load"
    title = "a force at the tip"
    component = "environment"
    stage = "structure"
    scope = "bench"
    equation = "V(s) = integral_s^L w - force"
    source = "statics of the beam, P (3)-(7)"
    parameters = (
        Parameter("force_mn", 0.0, -500.0, 500.0, (-0.1,), "a weight is negative: parts of the tube's own, and more"),
    )
    decided_by = "the same tube turned over: a load keeps its side; and the tube weighed"

    @classmethod
    def reach(cls, parameter: Parameter, scene: Scene) -> float:
        """Return the weight of the tube, mN."""
        return scene.weight / MILLINEWTON

    def loads(self, loads: Loads) -> Loads:
        """Pull at the tip."""
        return replace(loads, upward_force=loads.upward_force + self.force_mn * MILLINEWTON)
