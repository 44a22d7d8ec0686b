"""Tendon superelasticity: a nitinol tendon stretches faster past a tension, on its stress plateau."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Parameter
from coast_cli.effects.knee import past
from coast_cli.effects.stages import OnStretch
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class TendonSuperelasticity(OnStretch):
    """Extra compliance of the tendon past a knee."""

    knee_n: float = 1.0
    extra_compliance: float = 0.0
    knee_width: float = 0.1

    id = "tendon_superelasticity"
    title = "tendon on its stress plateau"
    component = "tendon"
    equation = "stretch = F/k + extra_compliance past(F, knee)/k"
    source = "plateau 360 to 650 MPa loading, slope 3 to 10 % of E (physics.md, sizes worth knowing)"
    parameters = (
        Parameter(
            "knee_n",
            1.0,
            0.02,
            20.0,
            (0.3, 0.55, 0.75),
            "plateau stress times the wire's area",
            "tension",
            role="shape",
        ),
        Parameter("extra_compliance", 0.0, 0.0, 40.0, (2.0,), "plateau slope 3 to 10 % of E"),
        Parameter("knee_width", 0.1, 0.01, 0.5, (0.1,), "relative to the knee; grains yield one by one", role="shape"),
    )
    needs = ("stroke",)
    decided_by = "one loading sweep to the largest stroke, with tension recorded"

    def stretch(self, stretch: FloatArray, tension: FloatArray, joint: Joint) -> FloatArray:
        """Add the plateau's elongation."""
        if self.extra_compliance == 0.0 or joint.tendon is None:
            return stretch
        extra = past(tension, self.knee_n, self.knee_width * self.knee_n)
        return stretch + self.extra_compliance * extra / joint.tendon.stiffness
