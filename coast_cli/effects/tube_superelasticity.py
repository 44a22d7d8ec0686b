"""Tube superelasticity: the strips reach their stress plateau and the bending stiffness falls past a curvature."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Effect, Parameter, Segment
from coast_cli.effects.knee import past
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class TubeSuperelasticity(Effect):
    """Softening of the bending law past a knee."""

    knee_strain: float = 1.0
    stiffness_lost: float = 0.0
    knee_width: float = 0.1

    id = "tube_superelasticity"
    title = "notched tube on its stress plateau"
    component = "tubes"
    stage = "structure"
    equation = "M = EI (kappa - stiffness_lost past(kappa, knee)), knee where the strip's fibre reaches knee_strain"
    source = "plateau 360 to 650 MPa, slope 3 to 10 % of E (physics.md, sizes worth knowing)"
    parameters = (
        Parameter(
            "knee_strain",
            1.0,
            1e-5,
            1.0,
            (0.25, 0.45, 0.65, 0.85),
            "plateau stress over E: 0.5 to 1.6 %",
            "strain",
            role="shape",
        ),
        Parameter("stiffness_lost", 0.0, 0.0, 0.98, (0.5,), "plateau slope 3 to 10 % of E"),
        Parameter(
            "knee_width", 0.1, 0.01, 0.6, (0.15,), "relative to the knee; the strip yields from its edge", role="shape"
        ),
    )
    decided_by = "one loading sweep to the largest stroke at the shortest bending length, with tension recorded"

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off what the plateau no longer carries."""
        if self.stiffness_lost == 0.0:
            return moment
        knee = self.knee_strain / segment.strain_per_curvature
        beyond = past(curvature, knee, self.knee_width * knee)
        return moment - self.stiffness_lost * segment.rigidity * beyond
