"""Camera scale: places are measured too large or too small by a factor."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_effect import ShapeEffect
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class CameraScale(ShapeEffect):
    """A factor on both coordinates."""

    scale: float = 1.0

    id = "camera_scale"
    title = "camera scale is off"
    component = "camera"
    kind = "sensor"
    stage = "sensor"
    scope = "camera"
    equation = "(x, y) -> scale (x, y)"
    source = "pixels per millimetre calibrated off the plane of bending"
    parameters = (Parameter("scale", 1.0, 0.5, 2.0, (1.02,), "calibration targets are good to a few per cent"),)
    decided_by = "a ruler in the plane of the tube, in the same picture"

    def see(self, x: FloatArray, y: FloatArray, centre: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Scale the picture."""
        return x * self.scale, y * self.scale
