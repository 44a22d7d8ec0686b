"""Notch end effect: stress spreads from strip to ring over a length, which acts as extra cut length."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Effect, Parameter
from coast_cli.effects.tubes import map_tubes
from coast_cli.mechanics.joint import Joint
from coast_cli.units import MICROMETRE


@dataclass(frozen=True)
class NotchEndEffect(Effect):
    """Extra cut length at every notch."""

    length_um: float = 0.0

    id = "notch_end_effect"
    title = "stress spreads from strip to ring"
    component = "tube"
    stage = "structure"
    equation = "pitch/EI = uncut/EI_1 + (cut + length)/EI_2"
    source = "physics.md, left out by P: 3-D solid finite elements of one cell; examples/solid"
    parameters = (Parameter("length_um", 0.0, 0.0, 2000.0, (100.0,), "78 to 175 on 0.5 mm tubes"),)
    needs = ("pairs",)
    decided_by = "the same sweep with a second pair of another notch depth or cut length"

    def joint(self, joint: Joint) -> Joint:
        """Lengthen the cuts of every tube."""
        if self.length_um == 0.0:
            return joint
        return map_tubes(joint, lambda tube: replace(tube, end_length=tube.end_length + self.length_um * MICROMETRE))
