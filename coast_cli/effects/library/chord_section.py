"""Chord section: a straight laser cut leaves a circular segment, not the sector that P assumes."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import Parameter
from coast_cli.effects.stages import OnTubes
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.tube import NotchedTube

_FROM = "0 for radial walls, 1 for a flat cut"


@dataclass(frozen=True)
class ChordSection(OnTubes):
    """The share of the change from sector to chord compliance; 1 is the whole of it."""

    share: float = 0.0

    id = "chord_section"
    title = "straight cut: chord section"
    component = "tube"
    equation = "1/EI = (1 - share)/EI_sector + share/EI_chord"
    source = "physics.md, section, second trap; exact circular segments"
    parameters = (Parameter("share", 0.0, 0.0, 1.5, (1.0,), _FROM),)
    needs = ("pairs",)
    decided_by = "the same sweep with a second pair of another notch depth"
    on_shapes = {
        "parameters": (Parameter("share", 0.0, 0.0, 1.5, (1.0,), _FROM, expected=(1.0, 0.1)),),
        "needs": (),
        "unlikely": -2.0,
        "decided_by": "tubes of two or more notch depths, each both ways up; or a section under a microscope",
    }

    def geometry(self, tube: NotchedTube) -> NotchedTube:
        """Take the chord section, its compliance brought to the share by the length that bends."""
        if self.share == 0.0 or tube.section == "chord":
            return tube
        chord = replace(tube, section="chord")
        ratio = chord.notch.second_moment / tube.notch.second_moment
        wanted = (1.0 - self.share) * ratio + self.share
        return replace(chord, end_length=wanted * (tube.cut + tube.end_length) - tube.cut)

    def joint(self, joint: Joint) -> Joint:
        """Soften each tube of a joint by an equivalent end length of its cuts; its tendon keeps its lever arm."""
        outer = None if joint.outer is None else self._softer(joint.outer)
        return replace(joint, outer=outer, middle=self._softer(joint.middle)) if self.share else joint

    def _softer(self, tube: NotchedTube) -> NotchedTube:
        chord = replace(tube, section="chord").notch.second_moment
        softer = self.share * (tube.notch.second_moment / chord - 1.0)
        return replace(tube, end_length=tube.end_length + softer * (tube.cut + tube.end_length))
