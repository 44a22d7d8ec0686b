"""Figures of every pair at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.pair import Assembly, pair_figures
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube


@dataclass(frozen=True, slots=True)
class PairTable:
    """Figures of all pairs, middle-major, shape (n_middle * n_outer,)."""

    total_precurvature: FloatArray
    signed_precurvature: FloatArray
    ratio_mean: FloatArray
    ratio_series: FloatArray
    total_mean: FloatArray
    total_series: FloatArray
    converged: NDArray[np.bool_]


def pair_table(
    outer: Sequence[NotchedTube], middle: Sequence[NotchedTube], gravity: float, assembly: Assembly
) -> PairTable:
    """Return figures."""
    found = [pair_figures(o, m, gravity) for m in middle for o in outer]
    return PairTable(
        *(np.array([getattr(f, name) for f in found]) for name in list(PairTable.__dataclass_fields__)[:-1]),
        np.array([f.verdict.converged for f in found]),
    )
