"""Thermal drift: stiffness or zero change slowly with time, in proportion to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import Effect, History, Parameter
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class ThermalDrift(Effect):
    """Linear drift of the bending stiffness and of the zero of the response."""

    stiffness_per_s: float = 0.0
    zero_per_s: float = 0.0

    id = "thermal_drift"
    title = "stiffness or zero drifts with time"
    component = "material"
    stage = "structure"
    equation = "EI -> EI (1 + stiffness_per_s t); response -> response + zero_per_s t (its own SI unit)"
    source = "plateau stress +6.5 MPa/K (physics.md); a slow warming is linear over one recording"
    parameters = (
        Parameter("stiffness_per_s", 0.0, -0.02, 0.02, (1e-4,), "tens of per cent an hour at most"),
        Parameter("zero_per_s", 0.0, -2.0, 2.0, (1e-3,), "a few noise widths a minute"),
    )
    needs = ("time",)
    decided_by = "the same sweep repeated at the start and at the end of an hour, slack in between"

    def stiffness_drift(self, time: FloatArray) -> FloatArray | None:
        """Return the relative change of stiffness."""
        return None if self.stiffness_per_s == 0.0 else np.maximum(self.stiffness_per_s * time, -0.9)

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Add the drift of the zero."""
        if history.time is None or self.zero_per_s == 0.0:
            return response
        return response + (self.zero_per_s * history.time)[:, np.newaxis]
