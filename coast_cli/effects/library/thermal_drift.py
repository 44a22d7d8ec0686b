"""Thermal drift: stiffness or zero change slowly with time, towards a new balance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnDrift, OnSensor
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class ThermalDrift(OnDrift, OnSensor):
    """Drift of stiffness, of the shape at rest, or of the zero of the response; linear where the time constant is long."""

    stiffness_change: float = 0.0
    zero_change: float = 0.0
    rest_change_per_m: float = 0.0
    time_constant_s: float = 1000.0

    id = "thermal_drift"
    title = "stiffness or zero drifts with time"
    component = "material"
    equation = (
        "M = EI (1 + stiffness_change g) (kappa - rest_change g), response -> response + zero_change g, "
        "g = 1 - exp(-t/time_constant)"
    )
    source = "plateau stress +6.5 MPa/K (physics.md); Newton's law of warming for g"
    parameters = (
        Parameter("stiffness_change", 0.0, -0.9, 5.0, (0.05, 0.0), "tens of per cent"),
        Parameter("zero_change", 0.0, -100.0, 100.0, (0.0, 0.05), "SI unit of the response", "response"),
        Parameter("rest_change_per_m", 0.0, -60.0, 60.0, (0.0, 0.05), "as large as a natural curvature", "curvature"),
        Parameter(
            "time_constant_s",
            1000.0,
            0.05,
            1e6,
            (0.1, 0.4, 3.0),
            "a fraction of the recording and longer",
            "duration",
            role="shape",
        ),
    )
    needs = ("time",)
    unlikely = 2.0  # a bench keeps its temperature, and three changes at once bend to anything slow
    decided_by = "the same sweep repeated at the start and at the end of an hour, slack in between"

    def drift(self, time: FloatArray) -> FloatArray | None:
        """Return the share of the change that is reached at each time."""
        if self.stiffness_change == 0.0 and self.rest_change_per_m == 0.0:
            return None
        return self._part(time)

    def drifted(self, share: float) -> tuple[float, float]:
        """Return the factor on stiffness and the curvature at rest (1/m) at a share of the change."""
        return max(1.0 + self.stiffness_change * share, 0.05), self.rest_change_per_m * share

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Add the drift of the zero."""
        if history.time is None or self.zero_change == 0.0:
            return response
        return response + (self.zero_change * self._part(history.time))[:, np.newaxis]

    def _part(self, time: FloatArray) -> FloatArray:
        return np.asarray(-np.expm1(-time / self.time_constant_s))
