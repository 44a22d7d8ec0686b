"""What is zero but for rounding, which differs from processor to processor, is zero."""

from __future__ import annotations

import numpy as np

from coast_cli.mechanics.section import FloatArray

_ROUNDING = 1e-12  # of the largest value among which a rounded zero lies


def without_rounding(values: FloatArray, among: FloatArray | None = None) -> FloatArray:
    """Return values with zeros where they are 1e-12 of the largest of them, or of ``among``, and less."""
    largest = np.max(np.abs(values if among is None else among), initial=0.0)
    return np.asarray(np.where(np.abs(values) < _ROUNDING * largest, 0.0, values))
