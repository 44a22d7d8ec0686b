"""Viscous friction: drag grows with speed, so that the segment itself is late, whatever the camera does.

A moment c kappa' beside EI kappa makes a lag. A stroke-driven tendon pushes the segment with its own stiffness too, so the lag
shortens with the bending length, which a late camera's does not; and the tension rises by what the drag takes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.memory import relax
from coast_cli.effects.stages import OnDrive, OnSettling
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class ViscousFriction(OnSettling, OnDrive):
    """Drag on the bending tubes, and drag of the tendon in its sheath."""

    time_constant_s: float = 0.0
    sheath_time_s: float = 0.0

    id = "viscous_friction"
    title = "drag grows with speed"
    component = "sheath, tubes"
    equation = "M = EI (kappa + time_constant kappa'); tendon in its sheath: x' = (X1 - x)/sheath_time"
    source = "Kelvin-Voigt solid: Findley, Lai and Onaran, Creep and Relaxation (1976), sec. 5.4"
    parameters = (
        Parameter("time_constant_s", 0.0, 0.0, 200.0, (0.02, 0.1, 0.0), "part of a sweep", "duration"),
        Parameter("sheath_time_s", 0.0, 0.0, 60.0, (0.0, 0.01), "part of a sweep", "duration", needs="rates"),
    )
    needs = ("time", "rates")
    decided_by = "the same loading and release at two rates and two bending lengths, with tension recorded"

    def drive(self, history: History) -> History:
        """Let the stroke at the tendon come late."""
        if history.time is None or history.stroke is None or self.sheath_time_s == 0.0 or history.stroke.size == 0:
            return history
        return replace(history, stroke=relax(history.stroke, history.time, self.sheath_time_s, history.stroke[0]))

    def settle(self, curvature: FloatArray, history: History, joint: Joint, rigidity: float, arm: float) -> FloatArray:
        """Let the segment come late by its drag over what pushes it: its own stiffness and the tendon's."""
        if history.time is None or self.time_constant_s == 0.0 or curvature.shape[0] == 0:
            return curvature
        pushed = rigidity
        if history.stroke is not None and joint.tendon is not None:
            pushed += joint.tendon.stiffness * arm**2 * float(np.mean(history.bending_length))
        return relax(curvature, history.time, self.time_constant_s * rigidity / pushed, curvature[0])
