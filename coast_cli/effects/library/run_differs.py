"""One run that disagrees with the rest: its camera was calibrated otherwise, or its stroke was zeroed elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import RUN, History, Parameter
from coast_cli.effects.stages import OnDrive, OnSensor
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class RunDiffers(OnSensor, OnDrive):
    """Gain and offset of the response, and zero of the stroke, of one run alone."""

    run: float = 0.0
    gain: float = 1.0
    offset: float = 0.0
    stroke_zero_mm: float = 0.0

    id = "run_differs"
    title = "one run disagrees with the rest"
    component = "record (one run)"
    kind = "sensor"
    scope = "bench"
    equation = "in that run: response -> gain response + offset, X1 -> X1 - stroke_zero"
    source = "homogeneity of runs: ISO 5725-2 (2019), sec. 7.3, consistency of laboratories"
    parameters = (
        RUN,
        Parameter("gain", 1.0, 0.2, 5.0, (1.1,), "a camera that was calibrated anew"),
        Parameter("offset", 0.0, -200.0, 200.0, (0.0,), "SI unit of the response", "response"),
        Parameter("stroke_zero_mm", 0.0, -5.0, 5.0, (0.0,), "a zero that was set anew", needs="stroke"),
    )
    needs = ("runs",)
    unlikely = 2.0  # a bench keeps its settings from run to run
    decided_by = "that run repeated, first and last among the others"

    def drive(self, history: History) -> History:
        """Shift the stroke of the run."""
        if history.run != round(self.run) or history.stroke is None or self.stroke_zero_mm == 0.0:
            return history
        return replace(history, stroke=history.stroke - self.stroke_zero_mm * MILLIMETRE)

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Scale and shift the response of the run."""
        if history.run != round(self.run) or (self.gain == 1.0 and self.offset == 0.0):
            return response
        return np.asarray(self.gain * response + self.offset)
