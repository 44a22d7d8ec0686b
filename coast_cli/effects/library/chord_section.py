"""Chord section: a straight laser cut leaves a circular segment, not the sector that P assumes."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Effect, Parameter
from coast_cli.effects.tubes import map_tubes
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.tube import NotchedTube


@dataclass(frozen=True)
class ChordSection(Effect):
    """The share of the change from sector to chord compliance; 1 is the whole of it."""

    share: float = 0.0

    id = "chord_section"
    title = "straight cut: chord section"
    component = "tube"
    stage = "structure"
    equation = "1/EI = (1 - share)/EI_sector + share/EI_chord"
    source = "physics.md, section, second trap; exact circular segments"
    parameters = (Parameter("share", 0.0, 0.0, 1.5, (1.0,), "0 for radial walls, 1 for a flat cut"),)
    needs = ("pairs",)
    decided_by = "the same sweep with a second pair of another notch depth"

    def joint(self, joint: Joint) -> Joint:
        """Soften each tube towards its chord section, by an equivalent end length of its cuts."""
        if self.share == 0.0:
            return joint

        def soften(tube: NotchedTube) -> NotchedTube:
            chord = replace(tube, section="chord").notch.second_moment
            softer = self.share * (tube.notch.second_moment / chord - 1.0)
            return replace(tube, end_length=tube.end_length + softer * (tube.cut + tube.end_length))

        return map_tubes(joint, soften)
