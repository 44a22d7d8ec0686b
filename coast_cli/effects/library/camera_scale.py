"""Camera scale: the response is measured too large or too small by a factor."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.shape_stages import OnImage
from coast_cli.effects.stages import OnSensor
from coast_cli.mechanics.section import FloatArray

_FROM = "calibration targets are good to a few per cent"


@dataclass(frozen=True)
class CameraScale(OnSensor, OnImage):
    """A factor on the response, or on both coordinates of a picture."""

    scale: float = 1.0

    id = "camera_scale"
    title = "camera scale is off"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "response -> scale response"
    source = "pixels per millimetre calibrated off the plane of bending"
    parameters = (Parameter("scale", 1.0, 0.3, 3.0, (1.05, 0.95), _FROM),)
    decided_by = "the same stroke sweep at three bending lengths, or with tension recorded"
    on_shapes = {
        "equation": "(x, y) -> scale (x, y)",
        "parameters": (Parameter("scale", 1.0, 0.5, 2.0, (1.02,), _FROM),),
        "decided_by": "a ruler in the plane of the tube, in the same picture",
    }

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Scale the response."""
        return response * self.scale

    def see(self, x: FloatArray, y: FloatArray, centre: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Scale the picture."""
        return x * self.scale, y * self.scale
