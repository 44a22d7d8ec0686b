"""Gravity: the plane of the picture is not vertical, so that only a share of the weight bends the tube in it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_effect import Loads, ShapeEffect


@dataclass(frozen=True)
class Gravity(ShapeEffect):
    """Share of gravity in the plane of the picture."""

    in_plane_share: float = 1.0

    id = "gravity"
    title = "weight out of the plane"
    component = "environment"
    stage = "structure"
    scope = "bench"
    equation = "w -> in_plane_share w"
    source = "P (3)-(7): the equations hold w/E alone, so with one material and no other load it is a modulus"
    parameters = (Parameter("in_plane_share", 1.0, 0.0, 2.0, (0.9,), "cosine of the plane's tilt"),)
    decided_by = "the same tube with a known weight at its tip: a force that does not scale with the tube's own weight"

    def loads(self, loads: Loads) -> Loads:
        """Take the share."""
        return replace(loads, gravity=loads.gravity * self.in_plane_share)
