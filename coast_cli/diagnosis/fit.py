"""Fit a set of effects together with the base model's own parameters, and say how likely what is left is as noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from coast_cli.diagnosis.likelihood import Evidence
from coast_cli.diagnosis.problem import Booleans, Problem
from coast_cli.effects.effect import Effect
from coast_cli.mechanics.section import FloatArray

_DIFFERENCE = 1e-4
_ROUGH_STEPS = 14
_FINE_STEPS = 5
# Every record has a small smooth misfit that no parameter stands for: this share of the noise, in so many shapes. It does
# not average out with more samples, so intervals must not shrink as if it did.
_MISFIT, _MISFIT_SHAPES = 0.155, 6.0
_SIZES_FIRST = 3  # steps in which shapes stay where they start
_GAIN = 5e-4  # relative fall of the cost under which a fit has settled


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted hypothesis.

    Attributes:
        effects: with their fitted parameters.
        coordinates: base parameters in fit coordinates (p,).
        covariance: of base parameters and then effect parameters, in their own units where linear, (q, q).
        evidence: of the response's residual. tension_evidence: of the tension's.
        log_likelihood: of both, plus the log prior of the base parameters.
        rmse: of the fitted response, SI. residual: observed less fitted response (n,).
        at_bound: for each of the q parameters.
        converged: whether the fit settled before its step limit.
    """

    effects: tuple[Effect, ...]
    coordinates: FloatArray
    covariance: FloatArray
    evidence: Evidence
    tension_evidence: Evidence
    log_likelihood: float
    rmse: float
    residual: FloatArray
    tension_residual: FloatArray
    at_bound: tuple[bool, ...]
    converged: bool

    @property
    def parameter_count(self) -> int:
        """Number of effect parameters."""
        return sum(len(effect.parameters) for effect in self.effects)

    @property
    def ids(self) -> tuple[str, ...]:
        """Effect ids in the order in which they act."""
        return tuple(effect.id for effect in self.effects)


@dataclass(frozen=True, slots=True)
class _Space:
    """The joint vector of base and effect parameters, and how it becomes effects.

    Attributes:
        low, high: bounds. scale: step of a difference. reach: longest step. shape: which parameters are shapes; all (q,).
    """

    problem: Problem
    effects: tuple[Effect, ...]
    low: FloatArray
    high: FloatArray
    scale: FloatArray
    reach: FloatArray
    shape: Booleans

    def split(self, vector: FloatArray) -> tuple[FloatArray, tuple[Effect, ...]]:
        """Return base coordinates and effects of a vector."""
        size = len(self.problem.base)
        effects, at = [], size
        for effect in self.effects:
            count = len(effect.parameters)
            effects.append(effect.with_values(vector[at : at + count]))
            at += count
        return vector[:size], tuple(effects)

    def predicted(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return fitted responses and tensions at a vector."""
        coordinates, effects = self.split(vector)
        return self.problem.fitted(self.problem.predict(coordinates, effects))


def fit(
    problem: Problem,
    effects: Sequence[Effect] = (),
    start: FloatArray | None = None,
    *,
    steps: int = _ROUGH_STEPS,
    polish: bool = True,
) -> Fit:
    """Fit base parameters and the parameters of ``effects`` from their current values.

    A rough pass at the white level of the recording, then one at the colour that the rough pass left.

    Args:
        start: base coordinates to start from; as configured by default.
        steps: limit of the rough pass. polish: whether the second pass is made.
    """
    ordered = tuple(effects)
    space = _space(problem, ordered)
    base = problem.configured() if start is None else start
    vector = np.concatenate([base, *(np.array(effect.values()) for effect in ordered)])
    vector = np.clip(vector, space.low, space.high)
    weights = (problem.noise, problem.tension_noise or 1.0)
    vector, jacobian, converged = _descend(space, vector, weights, (0, 0), min(steps, _SIZES_FIRST), ~space.shape)
    if (steps > _SIZES_FIRST and np.any(space.shape)) or not converged:
        vector, jacobian, converged = _descend(space, vector, weights, (0, 0), steps - min(steps, _SIZES_FIRST))
    evidence, tension_evidence = _evidence(space, vector)
    if polish:
        weights = (max(evidence.level, 1e-15), max(tension_evidence.level, 1e-15))
        colours = (evidence.colour, tension_evidence.colour)
        vector, jacobian, fine = _descend(space, vector, weights, colours, _FINE_STEPS)
        evidence, tension_evidence = _evidence(space, vector)
        converged = converged or fine
    response, tension = space.predicted(vector)
    residual, tension_residual = problem.observed - response, problem.observed_tension - tension
    coordinates, fitted = space.split(vector)
    normal = jacobian.T @ jacobian
    doubt = 1.0 + _MISFIT**2 * residual.size / _MISFIT_SHAPES
    covariance = np.asarray(doubt * np.linalg.pinv(normal, hermitian=True), dtype=np.float64)
    prior = -0.5 * float(np.sum(_prior_residual(problem, vector) ** 2))
    margin = 1e-6 * (space.high - space.low)
    touching = ((vector <= space.low + margin) | (vector >= space.high - margin)) & (space.high > space.low)
    return Fit(
        effects=fitted,
        coordinates=coordinates,
        covariance=covariance,
        evidence=evidence,
        tension_evidence=tension_evidence,
        log_likelihood=evidence.log_likelihood + tension_evidence.log_likelihood + prior,
        rmse=float(np.sqrt(np.mean(residual**2))) if residual.size else 0.0,
        residual=residual,
        tension_residual=tension_residual,
        at_bound=tuple(bool(t) for t in touching),
        converged=converged,
    )


def _space(problem: Problem, effects: tuple[Effect, ...]) -> _Space:
    low, high = problem.bounds()
    spread = [0.1 if parameter.logarithmic else max(parameter.prior * 0.3, 1e-6) for parameter in problem.base]
    lows, highs, reach, shape = [*low], [*high], [3.0 * s for s in spread], [False] * len(spread)
    for place, own in enumerate(problem.base):
        reach[place] = 0.7 if own.logarithmic else max(own.prior, 1e-6)
    for effect in effects:
        for parameter, value in zip(effect.parameters, effect.values(), strict=True):
            pinned = parameter.needs is not None and not problem.holds.get(parameter.needs, True)
            lows.append(parameter.null if pinned else parameter.low)
            highs.append(parameter.null if pinned else parameter.high)
            spread.append(max(abs(value), (parameter.high - parameter.low) * 1e-3))
            shape.append(parameter.role == "shape")
            reach.append(max(0.4 * abs(value), 0.05 * (parameter.high - parameter.low)) if shape[-1] else np.inf)
    return _Space(problem, effects, np.array(lows), np.array(highs), np.array(spread), np.array(reach), np.array(shape))


def _prior_residual(problem: Problem, vector: FloatArray) -> FloatArray:
    size = len(problem.base)
    width = np.array([parameter.prior for parameter in problem.base])
    return np.asarray((vector[:size] - problem.configured()) / width) if size else np.zeros(0)


def _weighted(space: _Space, vector: FloatArray, weights: tuple[float, float], colours: tuple[int, int]) -> FloatArray:
    response, tension = space.predicted(vector)
    problem = space.problem
    return np.concatenate(
        [
            problem.bank.whiten((response - problem.observed) / weights[0], colours[0]),
            problem.tension_bank.whiten((tension - problem.observed_tension) / weights[1], colours[1]),
            _prior_residual(problem, vector),
        ]
    )


def _descend(
    space: _Space,
    vector: FloatArray,
    weights: tuple[float, float],
    colours: tuple[int, int],
    steps: int,
    moving: Booleans | None = None,
) -> tuple[FloatArray, FloatArray, bool]:
    """Levenberg-Marquardt with steps kept inside the bounds; return vector, Jacobian and whether it settled.

    Args:
        moving: which parameters move; all by default.
    """
    free = np.ones(vector.size, bool) if moving is None else moving
    residual = _weighted(space, vector, weights, colours)
    cost = float(residual @ residual)
    damping, jacobian, settled = 1e-3, np.zeros((residual.size, vector.size)), False
    for _ in range(steps):
        jacobian = _jacobian(space, vector, residual, weights, colours, free)
        gradient = jacobian.T @ residual
        blocked = ((vector <= space.low) & (gradient > 0)) | ((vector >= space.high) & (gradient < 0))
        active = free & ~blocked
        if not np.any(active):
            settled = True
            break
        normal = jacobian[:, active].T @ jacobian[:, active]
        diagonal = np.diag(normal).copy()
        diagonal[diagonal <= 0.0] = 1.0
        improved = False
        for _ in range(6):
            step = np.zeros_like(vector)
            step[active] = -np.linalg.solve(normal + damping * np.diag(diagonal), gradient[active])
            step = np.clip(step, -space.reach, space.reach)
            trial = np.clip(vector + step, space.low, space.high)
            trial_residual = _weighted(space, trial, weights, colours)
            trial_cost = float(trial_residual @ trial_residual)
            if trial_cost < cost:
                improved = True
                break
            damping *= 6.0
        if not improved:
            settled = True
            break
        fall = (cost - trial_cost) / max(cost, 1e-300)
        vector, residual, cost = trial, trial_residual, trial_cost
        damping = max(damping / 8.0, 1e-9)
        if fall < _GAIN:
            settled = True
            break
    if not np.any(jacobian):
        jacobian = _jacobian(space, vector, residual, weights, colours, free)
    return vector, jacobian, settled


def _jacobian(
    space: _Space,
    vector: FloatArray,
    residual: FloatArray,
    weights: tuple[float, float],
    colours: tuple[int, int],
    free: Booleans,
) -> FloatArray:
    columns = []
    for place in range(vector.size):
        if not free[place]:
            columns.append(np.zeros_like(residual))
            continue
        step = _DIFFERENCE * space.scale[place]
        if vector[place] + step > space.high[place]:
            step = -step
        moved = vector.copy()
        moved[place] += step
        columns.append((_weighted(space, moved, weights, colours) - residual) / step)
    return np.stack(columns, axis=1) if columns else np.zeros((residual.size, 0))


def _evidence(space: _Space, vector: FloatArray) -> tuple[Evidence, Evidence]:
    response, tension = space.predicted(vector)
    problem = space.problem
    return (
        problem.bank.evidence(problem.observed - response),
        problem.tension_bank.evidence(problem.observed_tension - tension),
    )
