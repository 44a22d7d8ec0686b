"""Notch end effect: stress spreads from strip to ring over a length, which acts as extra cut length."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import BY_TUBE
from coast_cli.effects.stages import OnTubes
from coast_cli.mechanics.end_effect import end_length
from coast_cli.mechanics.tube import NotchedTube


@dataclass(frozen=True)
class NotchEndEffect(OnTubes):
    """Extra cut length at every notch, in shares of what solid finite elements give for that tube."""

    table_share: float = 0.0
    by_tube: float = 0.0

    id = "notch_end_effect"
    title = "stress spreads from strip to ring"
    component = "tube"
    equation = (
        "pitch/EI = uncut/EI_1 + (cut + table_share delta)/EI_2, delta(d, uncut, ri/ro) from solid finite elements"
    )
    source = "physics.md, left out by P: 3-D solid finite elements of one cell; examples/solid"
    parameters = (
        Parameter("table_share", 0.0, 0.0, 4.0, (1.0,), "1 is the table's own length, within a few per cent"),
    )
    needs = ("pairs",)
    of_stock = True
    decided_by = "the same sweep with a second pair of another notch depth or cut length"
    on_shapes = {
        "parameters": (
            Parameter("table_share", 0.0, 0.0, 4.0, (1.0,), "1: as the solid cells have it", expected=(1.0, 0.3)),
            BY_TUBE,
        ),
        "needs": (),
        "unlikely": -2.0,
        "decided_by": "tubes of another notch depth, cut or uncut length: one tube alone cannot tell it from its modulus",
    }

    def differing(self, share: float) -> Self:
        """Return the effect of one tube, that much longer than the table has it."""
        return replace(self, table_share=self.table_share * (1.0 + share)) if self.by_tube and share else self

    def geometry(self, tube: NotchedTube) -> NotchedTube:
        """Lengthen the cuts."""
        if self.table_share == 0.0:
            return tube
        delta, _ = end_length(tube.outer_radius, tube.inner_radius, tube.depth, tube.cut, tube.uncut, tube.section)
        return replace(tube, end_length=tube.end_length + self.table_share * delta)
