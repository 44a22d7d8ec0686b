"""Lead-screw pitch error: the carriage is off by a wave with the period of the screw."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnDrive
from coast_cli.units import MILLIMETRE

SCREW_PITCH = 25.4e-3 / 40.0  # 40 threads an inch (physics.md)


@dataclass(frozen=True)
class LeadscrewPitchError(OnDrive):
    """Periodic stroke error, in a sine and a cosine part so that the fit is linear in both."""

    sine_mm: float = 0.0
    cosine_mm: float = 0.0

    id = "leadscrew_pitch_error"
    title = "periodic error of the lead screw"
    component = "actuator"
    equation = "x = X1 + sine sin(2 pi X1 / p) + cosine cos(2 pi X1 / p), p = 0.635 mm"
    source = "screw of 40 threads an inch; drunken-thread error, Slocum, Precision Machine Design (1992), sec. 10.8"
    parameters = (
        Parameter("sine_mm", 0.0, -0.3, 0.3, (0.02, 0.0), "well under half a pitch"),
        Parameter("cosine_mm", 0.0, -0.3, 0.3, (0.02, 0.0), "well under half a pitch"),
    )
    needs = ("stroke",)
    decided_by = "a slow stroke sweep in steps of at most 0.05 mm over three turns of the screw"

    def drive(self, history: History) -> History:
        """Add the wave to the stroke."""
        if history.stroke is None or (self.sine_mm == 0.0 and self.cosine_mm == 0.0):
            return history
        turn = 2.0 * np.pi * history.stroke / SCREW_PITCH
        error = (self.sine_mm * np.sin(turn) + self.cosine_mm * np.cos(turn)) * MILLIMETRE
        return replace(history, stroke=history.stroke + error)
