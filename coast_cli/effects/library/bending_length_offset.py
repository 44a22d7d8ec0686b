"""Bending-length offset: the inner tube's tip is not where X2 says."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnDrive
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class BendingLengthOffset(OnDrive):
    """A constant error of X2."""

    offset_mm: float = 0.0

    id = "bending_length_offset"
    title = "inner tube's tip off its nominal place"
    component = "inner tube"
    equation = "X2 -> X2 + offset"
    source = "zeroing of the inner tube's stage; physics.md, controls"
    parameters = (Parameter("offset_mm", 0.0, -8.0, 8.0, (1.0, -1.0), "a few pitches"),)
    decided_by = "the same stroke sweep at three bending lengths, for instance 15, 25 and 40 mm"

    def drive(self, history: History) -> History:
        """Shift the bending length."""
        if self.offset_mm == 0.0:
            return history
        return replace(history, bending_length=np.maximum(history.bending_length + self.offset_mm * MILLIMETRE, 1e-4))
