"""Camera offset: the response is shifted by a constant."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnSensor
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class CameraOffset(OnSensor):
    """A constant added to the response, in its SI unit (1/m, or rad where the response is an angle)."""

    offset: float = 0.0

    id = "camera_offset"
    title = "camera zero is off"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "response -> response + offset"
    source = "zero of the angle or circle fit on the straight segment"
    parameters = (Parameter("offset", 0.0, -30.0, 30.0, (0.02, -0.02), "a few noise widths", "response"),)
    decided_by = "the slack segment at two bending lengths, and a straight reference bar in the picture"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Shift the response."""
        return response + self.offset
