"""A smooth knee: how far a law has gone past a point, rounded over a width so that a fit has a slope everywhere."""

from __future__ import annotations

import numpy as np

from coast_cli.mechanics.section import FloatArray


def past(value: FloatArray, knee: FloatArray | float, width: FloatArray | float) -> FloatArray:
    """Return width * ln(1 + exp((value - knee)/width)), width > 0, which is max(value - knee, 0) for a narrow one."""
    return width * np.logaddexp(0.0, (value - knee) / width)
