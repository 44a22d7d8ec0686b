"""Load cell scale: the tension column is scaled against stroke and curvature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnLoadCell
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class LoadCellScale(OnLoadCell):
    """A factor on the tension that is read."""

    scale: float = 1.0

    id = "load_cell_scale"
    title = "load cell reads in another scale"
    component = "load cell"
    kind = "sensor"
    scope = "bench"
    equation = "tension read = scale tension"
    source = "static characteristics of force transducers: ISO 376 (2011)"
    parameters = (Parameter("scale", 1.0, 0.3, 3.0, (1.1, 0.9), "a calibration that was lost"),)
    needs = ("witness",)
    decided_by = "a known weight on the load cell, and the slack tendon read"

    def weigh(self, tension: FloatArray, history: History) -> FloatArray:
        """Change what is read."""
        return tension if self.scale == 1.0 else np.asarray(self.scale * tension)
