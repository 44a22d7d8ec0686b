"""Camera saturation: the response ends at a level, because the view ends there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnSensor
from coast_cli.mechanics.section import FloatArray

_NONE = 1e3


@dataclass(frozen=True)
class CameraSaturation(OnSensor):
    """A largest response that can be seen."""

    level: float = _NONE

    id = "camera_saturation"
    title = "the response ends where the view ends"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "response -> min(response, level)"
    source = "clipping of a sensor's range: Fraden, Handbook of Modern Sensors (2016), sec. 3.5"
    parameters = (
        Parameter(
            "level",
            _NONE,
            1e-6,
            _NONE,
            (1.0, 0.97, 0.9, 0.8),
            "SI unit of the response; inside what was seen",
            "response",
            role="shape",
        ),
    )
    needs = ("clipped",)
    decided_by = "the same sweep with the camera moved back"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Cut the response off."""
        return response if self.level >= _NONE else np.minimum(response, self.level)
