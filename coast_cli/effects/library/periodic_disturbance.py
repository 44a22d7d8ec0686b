"""Periodic disturbance: something swings with a period of its own, breathing, a room's air or the mains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnSensor
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class PeriodicDisturbance(OnSensor):
    """A wave in the response, in a sine and a cosine part so that the fit is linear in both."""

    sine: float = 0.0
    cosine: float = 0.0
    period_s: float = 4.0

    id = "periodic_disturbance"
    title = "something swings with a period of its own"
    component = "environment"
    kind = "sensor"
    scope = "camera"
    equation = "response -> response + sine sin(2 pi t / period) + cosine cos(2 pi t / period)"
    source = "breathing 3 to 6 s; harmonic regression: Bloomfield, Fourier Analysis of Time Series (2000), ch. 2"
    parameters = (
        Parameter("sine", 0.0, -100.0, 100.0, (0.02,), "SI unit of the response", "response"),
        Parameter("cosine", 0.0, -100.0, 100.0, (0.02,), "SI unit of the response", "response"),
        Parameter("period_s", 4.0, 0.01, 1e5, (0.1,), "from what the samples resolve to the run", "period", "shape"),
    )
    needs = ("time", "period")
    decided_by = "a minute at rest, and a minute at the largest stroke, with the drive still"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Add the wave."""
        if history.time is None or (self.sine == 0.0 and self.cosine == 0.0):
            return response
        turn = 2.0 * np.pi * history.time / self.period_s
        return response + (self.sine * np.sin(turn) + self.cosine * np.cos(turn))[:, np.newaxis]
