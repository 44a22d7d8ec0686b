"""Change every tube of a joint alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.tube import NotchedTube


def map_tubes(joint: Joint, change: Callable[[NotchedTube], NotchedTube]) -> Joint:
    """Return the joint with ``change`` applied to its outer tube, where there is one, and its middle tube."""
    outer = None if joint.outer is None else change(joint.outer)
    return replace(joint, outer=outer, middle=change(joint.middle))
