"""Camera tilt: the picture plane is not parallel to the plane of bending."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import OnImage
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class CameraTilt(OnImage):
    """Heights foreshortened, and all sizes falling with the distance along x."""

    foreshortening: float = 0.0
    perspective_per_m: float = 0.0

    id = "camera_tilt"
    title = "the camera looks at an angle"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "(x, y) -> (x, (1 - foreshortening) y) / (1 + perspective x)"
    source = "pinhole camera, to first order in the tilt about each axis"
    parameters = (
        Parameter("foreshortening", 0.0, -0.3, 0.3, (0.02, -0.02), "1 - cosine of the tilt about the tube's axis"),
        Parameter("perspective_per_m", 0.0, -4.0, 4.0, (0.0, 0.2, -0.2), "tilt over the camera's distance"),
    )
    unlikely = 3.0
    decided_by = "a grid in the plane of the tube, in the same picture"

    @classmethod
    def one_sided(cls) -> bool:
        """Return that every side has a start of its own."""
        return True

    def scaled(self, amount: float) -> Self:
        """Return both tilts times the amount."""
        factor = float(np.clip(amount, 1e-3, 10.0))
        return replace(
            self,
            foreshortening=float(np.clip(self.foreshortening * factor, -0.28, 0.28)),
            perspective_per_m=float(np.clip(self.perspective_per_m * factor, -3.8, 3.8)),
        )

    def see(self, x: FloatArray, y: FloatArray, centre: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Project."""
        depth = 1.0 + self.perspective_per_m * x
        return x / depth, (1.0 - self.foreshortening) * y / depth
