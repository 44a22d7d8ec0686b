"""Notch closure: the notch's faces touch and the stiffness rises past a curvature."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Parameter, Segment
from coast_cli.effects.knee import past
from coast_cli.effects.stages import OnStructure
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class NotchClosure(OnStructure):
    """Contact stiffness past a closing curvature."""

    closure_ratio: float = 1.0
    added_stiffness: float = 0.0
    knee_width: float = 0.05

    id = "notch_closure"
    title = "notch faces touch"
    component = "notches"
    equation = "M = EI (kappa + added_stiffness past(kappa, closure_ratio kappa_n)), kappa_n pitch = cut/(ro + ybar)"
    source = "physics.md, sizes worth knowing: notch faces touch at cut/(ro + ybar)"
    parameters = (
        Parameter(
            "closure_ratio",
            1.0,
            1e-4,
            3.0,
            (0.35, 0.55, 0.75, 0.9),
            "1 by geometry; burrs close early",
            "closure",
            role="shape",
            expected=(0.95, 0.22),  # burrs, round corners and a camera that sees several notches: 0.6 to 1.5 are 95 %
            logarithmic=True,
        ),
        Parameter("added_stiffness", 0.0, 0.0, 200.0, (2.0, 20.0), "the closed strip is a full ring in compression"),
        Parameter(
            "knee_width", 0.05, 0.003, 0.4, (0.05,), "relative to the closure; faces close unevenly", role="shape"
        ),
    )
    decided_by = "one loading sweep past the closing angle cut/(ro + ybar) of the notches, with tension recorded"

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Add the contact's moment."""
        if self.added_stiffness == 0.0:
            return moment
        closure = self.closure_ratio * segment.closing_curvature
        beyond = past(curvature, closure, self.knee_width * closure)
        return moment + self.added_stiffness * segment.rigidity * beyond
