"""Load cell offset: the tension column is shifted against stroke and curvature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnLoadCell
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class LoadCellOffset(OnLoadCell):
    """A constant on the tension that is read."""

    offset_n: float = 0.0

    id = "load_cell_offset"
    title = "load cell is not zeroed"
    component = "load cell"
    kind = "sensor"
    scope = "bench"
    equation = "tension read = tension + offset"
    source = "static characteristics of force transducers: ISO 376 (2011)"
    parameters = (Parameter("offset_n", 0.0, -20.0, 20.0, (0.05, -0.05), "a zero that was not taken", "tension"),)
    needs = ("witness",)
    decided_by = "a known weight on the load cell, and the slack tendon read"

    def weigh(self, tension: FloatArray, history: History) -> FloatArray:
        """Change what is read."""
        return tension if self.offset_n == 0.0 else np.asarray(tension + self.offset_n)
