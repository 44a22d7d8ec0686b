"""Sensor lag: the camera's answer comes late, so that the loop grows with rate and vanishes in a hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.memory import relax
from coast_cli.effects.stages import OnSensor
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class SensorLag(OnSensor):
    """Two first-order lags in a row and a pure delay of the response; exposure and filters are the ones, queues the other.

    At one rate a delay is play to the letter, so it is looked for only where rates differ or the drive holds.
    """

    time_constant_s: float = 0.0
    delay_s: float = 0.0
    second_time_s: float = 0.0

    id = "sensor_lag"
    title = "camera answers late"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "z' = (response(t - delay) - z)/second_time; y' = (z - y)/time_constant"
    source = "first-order lag of exposure and filtering, dead time of transfer and time stamps"
    parameters = (
        Parameter("time_constant_s", 0.0, 0.0, 30.0, (0.05, 0.2, 0.8, 3.0, 0.0), "frames to seconds"),
        Parameter("delay_s", 0.0, 0.0, 30.0, (0.0, 0.1, 0.4, 1.5), "frames to seconds", needs="rates"),
        Parameter("second_time_s", 0.0, 0.0, 30.0, (0.0, 0.05), "frames to seconds", needs="rates"),
    )
    needs = ("time",)
    decided_by = "the same loading and release at two rates, ten times apart, ending in a hold"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Delay the response."""
        time = history.time
        if time is None or response.shape[0] == 0 or not any(self.values()):
            return response
        late = response
        if self.delay_s > 0.0:
            late = np.stack([np.interp(time - self.delay_s, time, column) for column in response.T], axis=1)
        if self.second_time_s > 0.0:
            late = relax(late, time, self.second_time_s, late[0])
        return relax(late, time, self.time_constant_s, late[0])
