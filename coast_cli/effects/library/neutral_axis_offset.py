"""Neutral axis offset: a notch bends about the strip's own axis, so the line along the tube's axis changes its length.

The strip lies opposite to the notch, the side to which natural curvature points: bent towards the notch the tube's axis is
on the inside of the bend and shortens by ybar times the bend of every cut, bent away from it it lengthens.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import Loads, OnBench


@dataclass(frozen=True)
class NeutralAxisOffset(OnBench):
    """The offset as a share of the section's ybar; 1 is what beam theory says."""

    share: float = 0.0

    id = "neutral_axis_offset"
    title = "the strip bends about its own axis"
    component = "tube"
    equation = "ds' = (1 - share ybar kappa) ds on cuts, kappa towards the notch"
    source = "section.py: neutral_axis, P (1); kinematics of plane sections"
    parameters = (Parameter("share", 0.0, 0.0, 2.0, (1.0,), "1: as the section has it", expected=(1.0, 0.2)),)
    unlikely = -2.0
    decided_by = "the same tube turned over: one way it lengthens, the other way it shortens"

    def loads(self, loads: Loads) -> Loads:
        """Let the line change its length."""
        return replace(loads, axis_share=loads.axis_share + self.share)
