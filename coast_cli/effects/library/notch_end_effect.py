"""Notch end effect: stress spreads from strip to ring over a length, which acts as extra cut length."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Effect, Parameter
from coast_cli.effects.tubes import map_tubes
from coast_cli.mechanics.end_effect import end_length
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.tube import NotchedTube


@dataclass(frozen=True)
class NotchEndEffect(Effect):
    """Extra cut length at every notch, in shares of what solid finite elements give for that tube."""

    table_share: float = 0.0

    id = "notch_end_effect"
    title = "stress spreads from strip to ring"
    component = "tube"
    stage = "structure"
    equation = (
        "pitch/EI = uncut/EI_1 + (cut + table_share delta)/EI_2, delta(d, uncut, ri/ro) from solid finite elements"
    )
    source = "physics.md, left out by P: 3-D solid finite elements of one cell; examples/solid"
    parameters = (
        Parameter("table_share", 0.0, 0.0, 4.0, (1.0,), "1 is the table's own length, within a few per cent"),
    )
    needs = ("pairs",)
    decided_by = "the same sweep with a second pair of another notch depth or cut length"

    def joint(self, joint: Joint) -> Joint:
        """Lengthen the cuts of every tube."""
        return joint if self.table_share == 0.0 else map_tubes(joint, self._longer)

    def _longer(self, tube: NotchedTube) -> NotchedTube:
        delta, _ = end_length(tube.outer_radius, tube.inner_radius, tube.depth, tube.cut, tube.uncut, tube.section)
        return replace(tube, end_length=tube.end_length + self.table_share * delta)
