"""Rows that a fit has not seen: how far it misses them, beside what noise and the fit's own doubt allow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, ndtri

from coast_cli.diagnosis.fit import rms
from coast_cli.diagnosis.thresholds import (
    BY_CHANCE,
    FEWEST_IN_REGION,
    LONE_SHARE,
    MOST_UNSEEN_NOISE,
    OUTLIER_NOISE,
    UNSEEN_DOUBT,
)
from coast_cli.mechanics.section import FloatArray

_MOST_CORRELATION = 0.95


@dataclass(frozen=True, slots=True)
class Unseen:
    """Rows that a fit has not seen: the error, and what is allowed, both in noise widths; and over how many rows.

    ``p_value`` is the chance of a larger error, were all noise, doubt and small misfit that are granted there.
    """

    error: float
    allowed: float
    count: int
    p_value: float

    @property
    def passed(self) -> bool:
        """Whether the rows lie where noise and the fit's own doubt let expect them."""
        return self.count < FEWEST_IN_REGION or self.error <= self.allowed


def stretch_of(correlation: float) -> float:
    """Return by how much noise of a correlation makes variances of parameters larger than white noise does."""
    known = float(np.clip(correlation, 0.0, _MOST_CORRELATION))
    return (1.0 + known) / (1.0 - known)


def judge_unseen(
    residual: FloatArray, slopes: FloatArray, covariance: FloatArray, level: float, stretch: float, asked: int = 1
) -> Unseen:
    """Return what a residual (n,) on unseen rows says.

    Args:
        slopes: derivative of the residual by the fit's parameters (n, q). covariance: of those (q, q).
        level: of the noise. stretch: as `stretch_of` has it.
        asked: how many runs are asked alike; of so many, noise makes one look missed in one recording of a hundred.
    """
    level = max(level, 1e-15)
    lone = np.abs(residual) > OUTLIER_NOISE * max(level, float(np.median(np.abs(residual))) if residual.size else 0.0)
    if lone.mean() <= LONE_SHARE:  # a few samples that stand off are outliers, also two in a row
        residual, slopes = residual[~lone], slopes[~lone]
    doubt = float(np.sqrt(max(float(np.mean(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))), 0.0)))
    chance = stretch / max(residual.size, 1)
    allowed = MOST_UNSEEN_NOISE * (1.0 + ndtri(1.0 - BY_CHANCE / asked) * np.sqrt(0.5 * chance))
    error = rms(residual) / level
    granted = np.hypot(MOST_UNSEEN_NOISE, doubt / level)
    return Unseen(
        error,
        float(np.hypot(allowed, UNSEEN_DOUBT * doubt / level)),
        residual.size,
        float(chdtrc(1.0 / chance, (error / granted) ** 2 / chance)),
    )
