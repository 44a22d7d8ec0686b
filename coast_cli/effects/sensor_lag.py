"""Sensor lag: the camera's answer comes late, so that the loop grows with rate and vanishes in a hold."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Effect, History, Parameter
from coast_cli.effects.memory import relax
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class SensorLag(Effect):
    """A first-order delay of the response."""

    time_constant_s: float = 0.0

    id = "sensor_lag"
    title = "camera answers late"
    component = "camera"
    kind = "sensor"
    stage = "sensor"
    equation = "y' = (response - y)/time_constant"
    source = "first-order lag of exposure, filtering and time stamps"
    parameters = (Parameter("time_constant_s", 0.0, 0.0, 30.0, (0.05, 0.2, 0.8, 3.0), "frames to seconds"),)
    needs = ("time",)
    decided_by = "the same loading and release at two rates, ten times apart, ending in a hold"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Delay the response."""
        if history.time is None or self.time_constant_s == 0.0 or response.shape[0] == 0:
            return response
        return relax(response, history.time, self.time_constant_s, response[0])
