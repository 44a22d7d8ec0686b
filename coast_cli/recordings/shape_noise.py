"""The noise of the points of shapes, from the shapes themselves: what lies across a smooth line through them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.noise import NoiseEstimate, Series, pooled_noise

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.model import ShapeRun

# Of the line: one coefficient for so many points, and never more than so many.
_COEFFICIENTS = ((4, 8), (8, 16))


def shape_noise(runs: Iterable[ShapeRun], known: float | None = None) -> NoiseEstimate:
    """Return the noise of points across the line, m, taken as one for all shapes: the one figure of every command.

    Points may be spaced unevenly, as along the line a smooth tube looks the same. ``known``: where it is known, m.
    """
    estimate = pooled_noise([Series(_across(run)) for run in runs])
    if known is None:
        return estimate
    return replace(estimate, level=known, log_level_std=0.0, interval=(known, known), determined=True)


def _across(run: ShapeRun) -> NDArray[np.float64]:
    """Return how far the points (n,) lie across a polynomial through them, m."""
    steps = np.hypot(np.diff(run.x), np.diff(run.y))
    along = np.concatenate(([0.0], np.cumsum(steps)))
    degree = max(1, *(min(most, len(run) // points) - 1 for points, most in _COEFFICIENTS))
    if not along[-1] > 0.0:
        return np.zeros(len(run))
    lines = [np.polynomial.Chebyshev.fit(along, values, degree) for values in (run.x, run.y)]
    dx, dy = run.x - lines[0](along), run.y - lines[1](along)
    tangent = [line.deriv()(along) for line in lines]
    size = np.maximum(np.hypot(*tangent), 1e-12)
    found: NDArray[np.float64] = (dy * tangent[0] - dx * tangent[1]) / size
    return found
