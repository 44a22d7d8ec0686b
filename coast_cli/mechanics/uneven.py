"""Uneven bending: the outer tube covers the segment up to a length only, and beyond it the middle tube bends alone.

The tendon puts one moment through the whole segment, so the covered part and the free one are springs in series: where both
tubes are they share it, where the outer tube has ended the middle one takes all of it and bends more. P reports uneven
bending above X2 = 25 mm, "compliance of the outer tube", and gives no model; this reading of it is ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from coast_cli.mechanics.bending_law import Softening
from coast_cli.mechanics.section import FloatArray

_HALVINGS = 60


@dataclass(frozen=True, slots=True)
class Free:
    """The middle tube where it bends alone.

    Attributes:
        cover: length from the inner tube's tip over which the outer tube covers it, m. rigidity: of it alone, N m^2.
        softening: how it softens.
    """

    cover: float
    rigidity: float
    softening: Softening


class Part(NamedTuple):
    """One part of a segment: its share of the length, its curvature (1/m) and the slope of that by the mean one."""

    share: FloatArray | float
    curvature: FloatArray
    rate: FloatArray | float


def parts(
    rigidity: float, softening: Softening, free: Free, curvature: FloatArray, bending_length: FloatArray
) -> tuple[Part, Part]:
    """Return the covered and the free part of segments of mean curvatures (1/m) and lengths X2 (m), of one shape.

    Args:
        rigidity, softening: of both tubes together.
    """
    covered = np.minimum(free.cover / bending_length, 1.0)
    inside = curvature / (covered + (1.0 - covered) * rigidity / free.rigidity)
    if softening.parts or free.softening.parts:
        inside = _shared(rigidity, softening, free, curvature, covered)
    even = covered == 1.0
    inside = np.where(even, curvature, inside)
    beyond = np.where(even, curvature, (curvature - covered * inside) / np.where(even, 1.0, 1.0 - covered))
    stiff, alone = rigidity * softening.slope(inside), free.rigidity * free.softening.slope(beyond)
    moment_rate = 1.0 / (covered / stiff + (1.0 - covered) / alone)
    inside_rate = np.where(even, 1.0, moment_rate / stiff)
    return Part(covered, inside, inside_rate), Part(1.0 - covered, beyond, np.where(even, 1.0, moment_rate / alone))


def _shared(
    rigidity: float, softening: Softening, free: Free, curvature: FloatArray, covered: FloatArray
) -> FloatArray:
    """Return the curvature of the covered part under the moment that the free part carries too, found by halving."""
    low, high = np.zeros_like(curvature), curvature.copy()
    rest = np.where(covered < 1.0, 1.0 - covered, 1.0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = np.maximum(curvature - covered * middle, 0.0) / rest
        stiffer = rigidity * softening.carried(middle) > free.rigidity * free.softening.carried(beyond)
        low, high = np.where(stiffer, low, middle), np.where(stiffer, middle, high)
    return np.asarray(0.5 * (low + high))
