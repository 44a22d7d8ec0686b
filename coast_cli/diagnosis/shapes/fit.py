"""Fit a set of effects together with the base parameters, and say how likely what is left is as noise of the points.

Levenberg-Marquardt inside bounds. Every derivative of a step is taken in one batch of beams, and only for the photographs
that a parameter touches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from coast_cli.diagnosis.noise_model import Evidence
from coast_cli.diagnosis.shapes.forward import Job
from coast_cli.diagnosis.shapes.problem import Problem
from coast_cli.effects.shapes.effect import ShapeEffect
from coast_cli.mechanics.section import FloatArray

_STEPS = 12
_FINE_STEPS = 4
_SETTLED = 0.8  # of the rough level: what is left may be far below it, and then the rough pass stopped early
_GAIN = 1e-3  # fall of the cost, in nats, under which a fit has settled
_GAIN_SHARE = 2e-5
_DIFFERENCE = 1e-3


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted hypothesis.

    Attributes:
        effects: with their fitted parameters. coordinates: base parameters in fit coordinates (p,).
        covariance: of base and then effect parameters (q, q), of logarithms where a fit moves those.
        evidence: of the residual as noise.
        log_likelihood: of it, plus the log priors. rmse: m. residual: observed less model, m.
        jacobian: of the residual by every parameter, (n, q). at_bound: (q,).
    """

    effects: tuple[ShapeEffect, ...]
    coordinates: FloatArray
    covariance: FloatArray
    evidence: Evidence
    log_likelihood: float
    rmse: float
    residual: FloatArray
    jacobian: FloatArray
    at_bound: tuple[bool, ...]

    @property
    def ids(self) -> tuple[str, ...]:
        """Effect ids in the order in which they act."""
        return tuple(effect.id for effect in self.effects)

    @property
    def key(self) -> frozenset[tuple[str, float]]:
        """What the hypothesis is: effects, and what was chosen for them."""
        return frozenset(effect.variant for effect in self.effects)


def fit(
    problem: Problem,
    effects: Sequence[ShapeEffect] = (),
    start: FloatArray | None = None,
    *,
    level: float,
    steps: int = _STEPS,
    polish: bool = True,
) -> Fit:
    """Fit base parameters and those of ``effects`` from their current values.

    Args:
        start: base coordinates to start from; as configured by default.
        level: rough noise of the points, m. steps: limit of the rough pass. polish: whether colour is fitted too.
    """
    space = Space(problem, tuple(effects))
    base = problem.configured() if start is None else start
    vector = np.clip(space.joined(base), space.low, space.high)
    vector, residual = _descend(space, vector, level, 0, steps)
    evidence = problem.bank.evidence(residual)
    if polish and (evidence.colour or evidence.level < _SETTLED * level):
        vector, residual = _descend(space, vector, max(evidence.level, 1e-12), evidence.colour, _FINE_STEPS)
        evidence = problem.bank.evidence(residual)
    return _finished(space, vector, residual, evidence)


def _finished(space: Space, vector: FloatArray, residual: FloatArray, evidence: Evidence) -> Fit:
    problem = space.problem
    coordinates, fitted = space.split(vector)
    jacobian = space.jacobian(vector, residual)
    white = problem.bank.whiten(jacobian, evidence.colour) / max(evidence.level, 1e-12)
    precision = white.T @ white + np.diag(1.0 / space.width**2)
    covariance = np.asarray(np.linalg.pinv(precision, hermitian=True), dtype=float)
    margin = 1e-6 * (space.high - space.low)
    touching = (vector <= space.low + margin) | (vector >= space.high - margin)
    prior = -0.5 * float(np.sum(space.prior(vector) ** 2))
    return Fit(
        effects=fitted,
        coordinates=coordinates,
        covariance=covariance,
        evidence=evidence,
        log_likelihood=evidence.log_likelihood + prior,
        rmse=float(np.sqrt(np.mean(residual**2))) if residual.size else 0.0,
        residual=residual,
        jacobian=jacobian,
        at_bound=tuple(bool(touch) for touch in touching),
    )


class Space:
    """The vector of base and effect parameters: bounds, priors, and how it becomes residuals."""

    def __init__(self, problem: Problem, effects: tuple[ShapeEffect, ...]) -> None:
        self.problem, self.effects = problem, effects
        parameters = [parameter for effect in effects for parameter in effect.fitted()]
        low, high = problem.bounds()
        factors = [p.name in effect.logarithmic for effect in effects for p in effect.fitted()]
        self.factors = np.array([False] * low.size + factors, dtype=bool)
        self.low = self._coordinates(np.concatenate([low, [p.low for p in parameters]]))
        self.high = self._coordinates(np.concatenate([high, [p.high for p in parameters]]))
        expected = [effect.expected.get(p.name) for effect in effects for p in effect.fitted()]
        widths = [width for effect in effects for width in type(effect).widths(problem.scene)]
        self.mean = np.concatenate([problem.configured(), [0.0 if e is None else e[0] for e in expected]])
        self.held = np.concatenate([np.ones(low.size, bool), [e is not None for e in expected]]).astype(bool)
        self.width = np.concatenate([[p.prior for p in problem.base], widths])

    def joined(self, base: FloatArray) -> FloatArray:
        """Return base coordinates with the effects' parameters as they stand."""
        return self._coordinates(np.concatenate([base, *(effect.fitted_values() for effect in self.effects)]))

    def _coordinates(self, values: FloatArray) -> FloatArray:
        moved: FloatArray = np.where(self.factors, np.log(np.where(self.factors, values, 1.0)), values)
        return moved

    def prior(self, vector: FloatArray) -> FloatArray:
        """Return how far the parameters that are expected somewhere lie from it, in standard deviations."""
        off: FloatArray = np.where(self.held, (vector - self.mean) / self.width, 0.0)
        return off

    def split(self, vector: FloatArray) -> tuple[FloatArray, tuple[ShapeEffect, ...]]:
        """Return base coordinates and effects of a vector."""
        values = np.where(self.factors, np.exp(np.where(self.factors, vector, 0.0)), vector)
        at, effects = len(self.problem.base), []
        for effect in self.effects:
            count = len(effect.fitted())
            effects.append(effect.with_fitted(np.clip(values[at : at + count], *_ranges(effect))))
            at += count
        return vector[: len(self.problem.base)], tuple(effects)

    def residual(self, vector: FloatArray) -> FloatArray:
        """Return the residuals at a vector, m."""
        return self.problem.residual(*self.split(vector))

    def jacobian(self, vector: FloatArray, residual: FloatArray) -> FloatArray:
        """Return the derivative of the residual by each parameter, (n, q)."""
        problem = self.problem
        jobs: list[Job] = []
        places: list[tuple[int, int, float]] = []
        owner = [effect for effect in self.effects for _ in effect.fitted()]
        for column in range(vector.size):
            step = _DIFFERENCE * self.width[column]
            if vector[column] + step > self.high[column]:
                step = -step
            moved = vector.copy()
            moved[column] += step
            state = problem.state(*self.split(moved))
            if column < len(problem.base):
                touched = problem.touched_by_base(column, self.effects)
            else:
                touched = problem.touched(owner[column - len(problem.base)])
            jobs += [(index, state) for index in touched]
            places += [(index, column, step) for index in touched]
        jacobian = np.zeros((residual.size, vector.size))
        if jobs:
            for (index, column, step), moved in zip(places, problem.residuals(jobs), strict=True):
                rows = problem.slices[index]
                jacobian[rows, column] = (moved - residual[rows]) / step
        return jacobian


def _ranges(effect: ShapeEffect) -> tuple[list[float], list[float]]:
    return [p.low for p in effect.fitted()], [p.high for p in effect.fitted()]


def _descend(space: Space, vector: FloatArray, level: float, colour: int, steps: int) -> tuple[FloatArray, FloatArray]:
    """Return vector and residual where the cost, in nats, no longer falls."""
    bank = space.problem.bank

    def cost_of(residual: FloatArray, at: FloatArray) -> tuple[FloatArray, float]:
        white = np.concatenate([bank.whiten(residual, colour) / level, space.prior(at)])
        return white, 0.5 * float(white @ white)

    residual = space.residual(vector)
    white, cost = cost_of(residual, vector)
    damping = 1e-4
    for _ in range(steps):
        jacobian = np.concatenate(
            [
                bank.whiten(space.jacobian(vector, residual), colour) / level,
                np.diag(space.held / space.width),
            ]
        )
        gradient = jacobian.T @ white
        active = ~(((vector <= space.low) & (gradient > 0)) | ((vector >= space.high) & (gradient < 0)))
        if not np.any(active):
            break
        normal = jacobian[:, active].T @ jacobian[:, active]
        diagonal = np.diag(normal) + 1e-12 * max(float(np.max(np.diag(normal))), 1e-30)
        fall = 0.0
        for _ in range(5):
            step = np.zeros_like(vector)
            step[active] = -np.linalg.lstsq(normal + damping * np.diag(diagonal), gradient[active], rcond=None)[0]
            trial = np.clip(vector + np.clip(step, -8.0 * space.width, 8.0 * space.width), space.low, space.high)
            trial_residual = space.residual(trial)
            trial_white, trial_cost = cost_of(trial_residual, trial)
            if trial_cost < cost:
                fall = cost - trial_cost
                break
            damping = max(damping * 10.0, 1e-3)
        if fall <= 0.0:
            break
        vector, residual, white, cost = trial, trial_residual, trial_white, trial_cost
        damping = max(damping / 10.0, 1e-9)
        if fall < _GAIN + _GAIN_SHARE * cost:
            break
    return vector, residual
