"""Coulomb friction: a constant friction moment between the tubes resists every change of bend."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Effect, Parameter, Segment
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """Constant friction moment, given as the curvature that it can hold."""

    holds_per_m: float = 0.0

    id = "coulomb_friction"
    title = "constant friction between the tubes"
    component = "tubes"
    stage = "structure"
    equation = "load: M = M_elastic + Mc; release: M = M_elastic - Mc, Mc = EI holds_per_m"
    source = "Coulomb's law; friction of nested tubes: Lock and Dupont, ICRA 2011"
    parameters = (
        Parameter("holds_per_m", 0.0, 0.0, 30.0, (0.01, 0.04, 0.12), "a part of the curvature reached", "curvature"),
    )
    needs = ("release",)
    reverses = True
    decided_by = "release sweeps from two strokes, small and large, with tension recorded: this loop keeps its width"

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Add the friction moment against the motion."""
        return moment + direction * self.holds_per_m * segment.rigidity
