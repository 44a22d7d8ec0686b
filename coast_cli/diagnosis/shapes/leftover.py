"""Structure that a fit leaves in the residuals, beyond what noise of the points draws.

*Smooth*: they are likelier as a smooth curve plus white noise than as AR(1) noise. *Repeats*: one photograph's residual
predicts that of another of the same tube the same way up, at equal arc length. *Level*: they stand above the noise, where
that is well known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.noise_model import NoiseBank
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.thresholds import POINTS_ABOVE_NOISE, POINTS_REPEAT, SMOOTHER_NATS
from coast_cli.mechanics.section import FloatArray

_SMOOTHED = 12


@dataclass(frozen=True, slots=True)
class LeftoverShape:
    """Structure left, m RMS; nats by which a smooth curve is likelier than noise; share that repeats."""

    size: float
    smooth: float
    repeats: float


def find_leftover(problem: ShapeProblem, fitted: Fit, floor: float, *, sure: bool) -> LeftoverShape:
    """Return the structure that a fit leaves; ``floor`` is the noise, m, ``sure`` whether its level is known."""
    bank = NoiseBank(problem.sequences, kernel="smooth")
    smooth = bank.evidence(fitted.residual)
    nats = smooth.log_likelihood - fitted.evidence.log_likelihood
    share = 1.0 - bank.white_share(smooth.colour) if nats > SMOOTHER_NATS else 0.0
    repeats = _repeats(problem, fitted.residual)
    if repeats > POINTS_REPEAT:
        share = max(share, repeats)
    size = fitted.rmse * float(np.sqrt(share))
    if sure and fitted.rmse > POINTS_ABOVE_NOISE * floor:
        size = max(size, float(np.sqrt(fitted.rmse**2 - floor**2)))
    return LeftoverShape(size, float(nats), repeats)


def _repeats(problem: ShapeProblem, residual: FloatArray) -> float:
    """Return the share of power that a smoothed photograph predicts in another of the same tube, the same way up."""
    groups: dict[tuple[object, ...], list[tuple[FloatArray, FloatArray]]] = {}
    for photograph, rows, (across, _) in zip(problem.photographs, problem.slices, problem.rows, strict=True):
        if int(across.sum()) >= 2 * _SMOOTHED:
            key = (tuple(number for number, _ in photograph.tubes), photograph.upward)
            groups.setdefault(key, []).append((photograph.at[across], residual[rows][: int(across.sum())]))
    error = power = 0.0
    for members in groups.values():
        for at, values in members:
            others = [other for other in members if other[0] is not at]
            if not others:
                continue
            predicted = np.mean([_smooth(other_at, other, at) for other_at, other in others], axis=0)
            error += float(np.sum((values - predicted) ** 2))
            power += float(np.sum(values**2))
    return 1.0 - error / power if power > 0.0 else 0.0


def _smooth(at: FloatArray, values: FloatArray, where: FloatArray) -> FloatArray:
    """Return a polynomial through the values, at other places."""
    degree = min(7, at.size // _SMOOTHED)
    found: FloatArray = np.polynomial.Chebyshev.fit(at, values, degree)(where)
    return found
