"""Lost steps: the motor loses stroke at one moment, and does not know."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnDrive
from coast_cli.units import MILLIMETRE

_EDGE = 0.002  # of the recording's duration, over which the loss is spread so that its moment can be fitted


@dataclass(frozen=True)
class LostSteps(OnDrive):
    """Stroke that is missing from one moment on."""

    lost_mm: float = 0.0
    time_s: float = 0.0

    id = "lost_steps"
    title = "motor loses steps"
    component = "actuator"
    scope = "bench"
    equation = "X1 -> X1 - lost from time_s on"
    source = "stall of stepping motors: Acarnley, Stepping Motors (2002), ch. 5"
    parameters = (
        Parameter("lost_mm", 0.0, -5.0, 5.0, (0.1,), "whole steps of a motor"),
        Parameter(
            "time_s",
            0.0,
            0.0,
            1e6,
            tuple(float(part) for part in np.arange(0.04, 1.0, 0.08).round(2)),
            "within the recording",
            "duration",
            role="shape",
        ),
    )
    needs = ("stroke", "time")
    unlikely = 2.0
    decided_by = "the same sweep twice, with the carriage read on a scale before and after"

    def drive(self, history: History) -> History:
        """Take the lost stroke off from its moment on."""
        if history.stroke is None or history.time is None or self.lost_mm == 0.0 or history.time.size == 0:
            return history
        edge = max(_EDGE * float(history.time[-1]), 1e-6)
        gone = 0.5 * (1.0 + np.tanh((history.time - self.time_s) / edge))
        return replace(history, stroke=history.stroke - self.lost_mm * MILLIMETRE * gone)
