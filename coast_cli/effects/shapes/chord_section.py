"""Chord section: a straight laser cut leaves a circular segment, not the sector that P assumes."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_effect import ShapeEffect
from coast_cli.mechanics.tube import NotchedTube


@dataclass(frozen=True)
class ChordSection(ShapeEffect):
    """The share of the change from sector to chord compliance; 1 is the whole of it."""

    share: float = 0.0

    id = "chord_section"
    title = "straight cut: chord section"
    component = "tube"
    stage = "structure"
    equation = "1/EI = (1 - share)/EI_sector + share/EI_chord"
    source = "physics.md, section, second trap; exact circular segments"
    parameters = (Parameter("share", 0.0, 0.0, 1.5, (1.0,), "0 for radial walls, 1 for a flat cut"),)
    expected = {"share": (1.0, 0.1)}
    rarity = -2.0
    decided_by = "tubes of two or more notch depths, each both ways up; or a section under a microscope"

    def geometry(self, tube: NotchedTube) -> NotchedTube:
        """Take the chord section, its compliance brought to the share by the length that bends."""
        if self.share == 0.0 or tube.section == "chord":
            return tube
        chord = replace(tube, section="chord")
        ratio = chord.notch.second_moment / tube.notch.second_moment
        wanted = (1.0 - self.share) * ratio + self.share
        return replace(chord, end_length=wanted * (tube.cut + tube.end_length) - tube.cut)
