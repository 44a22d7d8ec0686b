"""Capstan hysteresis: friction along pulleys and notches turns round with the motion.

The base model holds the loading side, F = e^(mu alpha) eta^Nf F_segment. On release the same friction helps the tendon
to hold on, so the gain becomes its inverse: the tip waits at each reversal, and the wait grows with tension.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import Parameter
from coast_cli.effects.stages import OnTransmission
from coast_cli.mechanics.joint import Joint


@dataclass(frozen=True)
class CapstanHysteresis(OnTransmission):
    """Friction of the whole tendon path that reverses with its motion."""

    pulley_friction: float = 0.0
    notch_friction_exponent: float = 0.0
    spread: float = 0.0

    id = "capstan_hysteresis"
    title = "tendon friction turns round with the motion"
    component = "pulleys, notches"
    equation = "load: F = e^phi F_seg; release: F = e^(phi - 2 h) F_seg, h = pulley_friction alpha + exponent X2/pitch"
    source = "capstan equation (Euler-Eytelwein); P (10)-(11), release observed but not modelled"
    parameters = (
        Parameter("pulley_friction", 0.0, 0.0, 0.8, (0.01, 0.05, 0.15, 0.3), "nitinol on steel 0.16 to 0.69"),
        Parameter("notch_friction_exponent", 0.0, 0.0, 0.03, (0.0,), "ln eta a notch: eta 1 to 1.03"),
        Parameter(
            "spread",
            0.0,
            0.0,
            1.6,
            (0.3,),
            "of ln h along the path; Dahl friction rounds like pi/sqrt(6)",
            role="shape",
        ),
    )
    needs = ("release",)
    reverses = True
    decided_by = (
        "release sweeps from two strokes, small and large, with tension recorded: this loop widens with tension"
    )

    @property
    def rounding(self) -> float:
        """Return how unevenly the path waits."""
        return self.spread

    def friction(self, direction: int, joint: Joint, bending_length: float) -> float:
        """Return the exponent taken off on release."""
        if direction > 0:
            return 0.0
        wrap = joint.wrap_angle if joint.wrap_angle > 0.0 else np.pi
        notches = bending_length / joint.pitch
        return -2.0 * (self.pulley_friction * wrap + self.notch_friction_exponent * notches)
