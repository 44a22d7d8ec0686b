"""A smooth knee: how far a law has gone past a point, rounded over a width so that a fit has a slope everywhere."""

from __future__ import annotations

import numpy as np

from coast_cli.mechanics.section import FloatArray


def past(value: FloatArray, knee: float, width: float) -> FloatArray:
    """Return width * ln(1 + exp((value - knee)/width)), which is max(value - knee, 0) for a narrow width."""
    if width <= 0.0:
        return np.maximum(value - knee, 0.0)
    return width * np.logaddexp(0.0, (value - knee) / width)
