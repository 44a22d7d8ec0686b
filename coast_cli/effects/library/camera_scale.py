"""Camera scale: the response is measured too large or too small by a factor."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Effect, History, Parameter
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class CameraScale(Effect):
    """A factor on the response."""

    scale: float = 1.0

    id = "camera_scale"
    title = "camera scale is off"
    component = "camera"
    kind = "sensor"
    stage = "sensor"
    scope = "camera"
    equation = "response -> scale response"
    source = "pixels per millimetre calibrated off the plane of bending"
    parameters = (Parameter("scale", 1.0, 0.3, 3.0, (1.05, 0.95), "calibration targets are good to a few per cent"),)
    decided_by = "the same stroke sweep at three bending lengths, or with tension recorded"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Scale the response."""
        return response * self.scale
