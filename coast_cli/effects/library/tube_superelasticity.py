"""Tube superelasticity: the strips reach their stress plateau and the bending stiffness falls past a curvature.

Linear tubes get a knee. Tubes that have a stress-strain curve of their own (``[materials.NAME.superelastic]``) keep it, with
the plateau begun at the fitted strain.
"""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Parameter, Segment
from coast_cli.effects.knee import past
from coast_cli.effects.plateau import fitted_tubes, has_own_curve, softened
from coast_cli.effects.stages import OnStructure
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray

_LOWER = 0.4  # lower plateau over upper, which loading does not reach


@dataclass(frozen=True)
class TubeSuperelasticity(OnStructure):
    """Softening of the bending law past a knee."""

    knee_strain: float = 0.1
    stiffness_lost: float = 0.0
    knee_width: float = 0.1

    id = "tube_superelasticity"
    title = "notched tube on its stress plateau"
    component = "tubes"
    equation = (
        "M = EI (kappa - stiffness_lost past(kappa, knee)), knee where the strip's fibre reaches knee_strain; of tubes with a "
        "curve of their own M = integral of sigma y, its plateau begun at E knee_strain with slope (1 - stiffness_lost) E"
    )
    source = "plateau 360 to 650 MPa, slope 3 to 10 % of E (physics.md, sizes worth knowing)"
    parameters = (
        Parameter(
            "knee_strain",
            0.1,
            1e-4,
            0.1,
            (0.25, 0.45, 0.65, 0.85),
            "plateau stress over E: 0.5 to 1.6 %",
            "strain",
            role="shape",
            expected=(0.0089, 0.29),  # 95 % of them; the middle is geometric
            logarithmic=True,
        ),
        Parameter("stiffness_lost", 0.0, 0.0, 0.98, (0.5,), "plateau slope 3 to 10 % of E"),
        Parameter(
            "knee_width",
            0.1,
            0.01,
            0.6,
            (0.15,),
            "relative to the knee; the strip yields from its edge",
            role="shape",
            needs="linear_tubes",
        ),
    )
    decided_by = "one loading sweep to the largest stroke at the shortest bending length, with tension recorded"

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off what the plateau no longer carries."""
        if self.stiffness_lost == 0.0:
            return moment
        joint = segment.joint
        if has_own_curve(joint):
            upper = self.plateau(joint)
            tubes = fitted_tubes(joint, upper, _LOWER * upper, self.stiffness_lost)
            return moment + segment.rigidity * softened(joint, tubes, curvature)
        knee = self.knee_strain / segment.strain_per_curvature
        beyond = past(curvature, knee, self.knee_width * knee)
        return moment - self.stiffness_lost * segment.rigidity * beyond

    def plateau(self, joint: Joint) -> float:
        """Return the stress at which the plateau begins, Pa."""
        return self.knee_strain * joint.youngs_modulus
