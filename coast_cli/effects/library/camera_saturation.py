"""Camera saturation: the response ends at a level, because the view ends there.

Where points leave the view one by one the end is soft: a hyperbola between the response and the level.
"""

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
    softness: float = 0.01

    id = "camera_saturation"
    title = "the response ends where the view ends"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "response -> min(response, level), rounded by a hyperbola over softness level"
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
        Parameter("softness", 0.01, 1e-4, 0.1, (0.01,), "of the level; points leave the view one by one", role="shape"),
    )
    needs = ("flat_end",)
    decided_by = "the same sweep with the camera moved back"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Cut the response off."""
        if self.level >= _NONE:
            return response
        below = 0.5 * (self.level - response)
        return np.asarray(response + below - np.hypot(below, 0.5 * self.softness * self.level))
