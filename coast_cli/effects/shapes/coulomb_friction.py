"""Coulomb friction between assembled tubes: a pair stays a little where it came from, whichever way up it lies."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_effect import Loads, ShapeEffect


@dataclass(frozen=True)
class CoulombFriction(ShapeEffect):
    """The curvature that friction holds, in the frame of the bench; positive bends upward."""

    held_per_m: float = 0.0

    id = "coulomb_friction"
    title = "constant friction between the tubes"
    component = "tubes"
    stage = "structure"
    equation = "k(s) = k_pair(s) + held, the same for both ways up"
    source = "Coulomb's law; friction of nested tubes: Lock and Dupont, ICRA 2011"
    parameters = (Parameter("held_per_m", 0.0, -30.0, 30.0, (0.3,), "a part of the tubes' natural curvature"),)
    on_pairs = True
    rarity = 2.0
    decided_by = "the pair turned over, brought to rest from above and from below"

    def loads(self, loads: Loads) -> Loads:
        """Hold the curvature."""
        return replace(loads, held_curvature=loads.held_curvature + self.held_per_m)
