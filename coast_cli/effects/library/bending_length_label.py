"""A wrong label: the bending length of one run is not what its column says."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import RUN, History, Parameter
from coast_cli.effects.stages import OnDrive
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class BendingLengthLabel(OnDrive):
    """X2 of one run alone."""

    run: float = 0.0
    error_mm: float = 0.0

    id = "bending_length_label"
    title = "one run's bending length is not what its column says"
    component = "record (one run)"
    kind = "sensor"
    scope = "bench"
    equation = "in that run: X2 -> X2 + error"
    source = "transcription errors in records: ISO 5725-2 (2019), sec. 7.2.5"
    parameters = (
        RUN,
        Parameter("error_mm", 0.0, -60.0, 60.0, (4.0, -4.0), "one planned length for another"),
    )
    needs = ("runs",)
    unlikely = 2.0
    decided_by = "that run repeated, with its bending length measured on the picture"

    def drive(self, history: History) -> History:
        """Replace the bending length of the run."""
        if history.run != round(self.run) or self.error_mm == 0.0:
            return history
        length = np.maximum(history.bending_length + self.error_mm * MILLIMETRE, 1e-3)
        return replace(history, bending_length=length)
