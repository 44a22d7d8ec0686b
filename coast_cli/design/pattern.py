"""The notch pattern of a tube as a laser cuts it: the outer skin unrolled, one rectangle a notch.

A notch takes the skin on which its depth is reached: of the circle all but the angle 2 acos((d - ro)/ro) that the strip keeps,
with radial walls and with a straight cut alike. The laser's path lies half a kerf inside the notch's edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from coast_cli.errors import BadInput
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.units import DEGREE, MILLIMETRE


@dataclass(frozen=True, eq=False)
class Pattern:
    """A tube's outer skin unrolled; lengths in m, along the tube from the clamp, around it from the notches' middle.

    Attributes:
        name: of the tube. length, circumference: of the skin. depth: of each notch, (n,).
        start, end, width: of each notch, (n,). kerf: of the laser; its path lies half of it inside the notch.
    """

    name: str
    length: float
    circumference: float
    depth: FloatArray
    start: FloatArray
    end: FloatArray
    width: FloatArray
    kerf: float

    @property
    def path(self) -> FloatArray:
        """The laser's closed path round each notch, (n, 4, 2): along and around, m."""
        along = np.stack((self.start + self.kerf / 2.0, self.end - self.kerf / 2.0), axis=1)
        across = (self.width - self.kerf) / 2.0
        around = np.stack((-across, across), axis=1)
        corners = ((0, 0), (1, 0), (1, 1), (0, 1))
        return np.stack([np.stack((along[:, i], around[:, j]), axis=1) for i, j in corners], axis=1)


def notch_pattern(tube: NotchedTube, kerf: float = 0.0) -> Pattern:
    """Return the pattern of a tube cut by a laser of that kerf (m).

    Raises:
        BadInput: the kerf is as wide as a notch, which it would then cut too wide.
    """
    end = np.cumsum(tube.pitch)
    kept = 2.0 * np.arccos((tube.depth - tube.outer_radius) / tube.outer_radius)
    width = (2.0 * np.pi - kept) * tube.outer_radius
    narrowest = np.minimum(tube.cut, width)
    if kerf >= narrowest.min():
        notch = int(np.argmin(narrowest))
        raise BadInput(
            f"a kerf as wide as notch {notch + 1} of {tube.name} leaves no path inside it",
            key="kerf",
            found=f"{kerf / MILLIMETRE:g} mm",
            allowed=f"below {narrowest[notch] / MILLIMETRE:.4g} mm",
        )
    circumference = 2.0 * np.pi * tube.outer_radius
    return Pattern(tube.name, tube.length, circumference, tube.depth, end - tube.cut, end, width, kerf)


def pattern_columns(patterns: Sequence[Pattern]) -> dict[str, Any]:
    """Return a row for each notch of each tube, lengths in mm."""

    def joined(parts: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate(parts) / MILLIMETRE

    return {
        "tube": [one.name for one in patterns for _ in one.depth],
        "notch": [number + 1 for one in patterns for number in range(one.depth.size)],
        "start_mm": joined([one.start for one in patterns]),
        "end_mm": joined([one.end for one in patterns]),
        "depth_mm": joined([one.depth for one in patterns]),
        "angle_deg": np.concatenate([2.0 * np.pi * one.width / one.circumference for one in patterns]) / DEGREE,
        "width_mm": joined([one.width for one in patterns]),
        "laser_start_mm": joined([one.path[:, 0, 0] for one in patterns]),
        "laser_end_mm": joined([one.path[:, 1, 0] for one in patterns]),
        "laser_width_mm": joined([one.width - one.kerf for one in patterns]),
    }
