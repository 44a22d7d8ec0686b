"""A device without tubes: what the far end does is a ratio times what the drive does beyond its zero, to both sides."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class Transmission:
    """Response = ratio (drive - zero) + load_ratio load.

    Attributes:
        ratio: response by drive, SI; of either sign. zero: drive without a response, SI.
        load_ratio: force at the drive by the load of the far end (N by N or N m); only of a force.
        ratio_unit, drive_unit: SI values of the units in which a configuration gives ratio and zero.
    """

    ratio: float
    zero: float
    load_ratio: float = 0.0
    ratio_unit: float = 1.0
    drive_unit: float = 1.0

    def response(self, drive: FloatArray, load: FloatArray | None) -> FloatArray:
        """Return the response (n,) to a drive (n,), SI."""
        carried = 0.0 if load is None else self.load_ratio * load
        return np.asarray(self.ratio * (drive - self.zero) + carried)

    def drive_of(self, response: float, load: float) -> float:
        """Return the drive that a response stands for; the zero where the ratio is none."""
        if self.ratio == 0.0:
            return self.zero
        return (response - self.load_ratio * load) / self.ratio + self.zero

    def with_values(self, values: Mapping[str, float]) -> Transmission:
        """Return it with numbers replaced, in the units and by the names of a configuration."""
        ratio, zero = values.get("ratio"), values.get("zero_mm")
        return replace(
            self,
            ratio=self.ratio if ratio is None else ratio * self.ratio_unit,
            zero=self.zero if zero is None else zero * self.drive_unit,
            load_ratio=values.get("load_ratio", self.load_ratio),
        )
