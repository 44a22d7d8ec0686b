"""Fit the base model's own parameters to recordings: values, honest intervals, and what the recordings cannot tell.

Bounded least squares in the measured response: the values are those with the smallest error, as P judges a model. A
first, robust pass finds outliers and the colour of what is left; intervals are as wide as residuals of that colour make
them (the covariance of least squares under correlated errors; White, Econometrica 48, 1980). Parameters whose effects
are one product are found by the null space of the sensitivities and held, one after the other, at configured values.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.calibratable import HELD_FIRST, LOGARITHMIC, Calibratable
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.noise_model import NOISE_COLOURS, NoiseBank
from coast_cli.mechanics.least_squares import FitResult, Residual, least_squares, profile_interval

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun
    from coast_cli.spec.config import Config

    Floats = NDArray[np.float64]
    Booleans = NDArray[np.bool_]

OUTLIER = 5.0
LEVEL = 0.9
POOR_QUADRATIC = 0.1
FINE_TOLERANCE = 1e-9
ROUGH_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Estimate:
    """A fitted parameter: value, standard deviation, interval of 90 % and how it was found."""

    parameter: Calibratable
    value: float
    std: float
    low: float
    high: float
    profiled: bool
    at_bound: bool


@dataclass(frozen=True, eq=False)
class CalibrationFit:
    """A fit of some runs.

    Attributes:
        posed, weights: what was fitted in the second pass.
        estimates: in the order of the parameters.
        correlation: of the fitted coordinates, [p, p].
        held: parameters that these recordings cannot tell, with the reason in words.
        converged: whether the fit settled.
    """

    posed: Posed
    weights: tuple[Weights, ...]
    estimates: tuple[Estimate, ...]
    correlation: Floats
    held: tuple[tuple[Calibratable, str], ...]
    converged: bool

    @property
    def values(self) -> dict[str, float]:
        """Fitted and fixed values by name."""
        return {**self.posed.fixed, **{estimate.parameter.name: estimate.value for estimate in self.estimates}}


@dataclass(frozen=True)
class Posed:
    """Parameters and the runs that they are fitted to, those of one kind together.

    Attributes:
        fixed: values of parameters that are held, by name. weights: of the squares of single runs, by name; else 1.
    """

    parameters: tuple[Calibratable, ...]
    problems: tuple[JointProblem, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    weights: Mapping[str, float] = field(default_factory=dict)

    def values(self, coordinates: Floats, held: Mapping[str, float]) -> dict[str, float]:
        """Return all values by name."""
        free = [parameter for parameter in self.parameters if parameter.name not in held]
        return {**self.fixed, **held, **{p.name: p.outer(c) for p, c in zip(free, coordinates, strict=True)}}

    @cached_property
    def white(self) -> tuple[Weights, ...]:
        """Weights of the first pass: each response by its own rough level."""
        return tuple(Weights(problem.noise, 0, problem.tension_noise or 1.0, 0) for problem in self.problems)

    def residual(self, values: Mapping[str, float], weights: Sequence[Weights]) -> Floats:
        """Return predicted less recorded responses and tensions, each over its noise, all problems together."""
        parts = []
        for problem, weight in zip(self.problems, weights, strict=True):
            response, tension = problem.fitted(problem.predict_with(values, ()))
            parts.append((response - problem.observed) / weight.level)
            parts.append((tension - problem.observed_tension) / weight.tension_level)
        return np.concatenate(parts) * self._roots if self.weights else np.concatenate(parts)

    @cached_property
    def _roots(self) -> Floats:
        """The root of the weight of each row of the residual."""
        parts = []
        for problem in self.problems:
            roots = [float(np.sqrt(self.weights.get(run.name, 1.0))) for run in problem.runs]
            parts += [np.full(rows.size, roots[run]) for run, _, rows in problem.sequences]
            parts += [np.full(rows.size, roots[run]) for run, rows in problem.tension_sequences]
        return np.concatenate(parts)

    def sequences(self, weights: Sequence[Weights]) -> Iterator[tuple[NDArray[np.int64], int]]:
        """Yield (rows in its run, colour of the noise) of each stretch of the residual, in its order."""
        for problem, weight in zip(self.problems, weights, strict=True):
            yield from ((rows, weight.colour) for _, _, rows in problem.sequences)
            yield from ((rows, weight.tension_colour) for _, rows in problem.tension_sequences)

    def only(self, rows: Mapping[str, Booleans]) -> Posed:
        """Return the same fit on the given rows of each run; runs that are not named are still simulated."""
        masks = [[rows.get(run.name, np.zeros(len(run), bool)) for run in problem.runs] for problem in self.problems]
        return replace(self, problems=tuple(p.only(mask) for p, mask in zip(self.problems, masks, strict=True)))


@dataclass(frozen=True)
class Weights:
    """Level (SI) and colour of the noise on a problem's response and on its tension."""

    level: float
    colour: int
    tension_level: float
    tension_colour: int


def pose(
    config: Config,
    runs: Sequence[JointRun],
    parameters: Sequence[Calibratable],
    fixed: Mapping[str, float] | None = None,
    weights: Mapping[str, float] | None = None,
) -> Posed:
    """Return the fit of parameters to runs, grouped by what they record; ``fixed`` and ``weights`` as of ``Posed``.

    Raises:
        BadInput: a run's tubes or drive do not go with the configuration.
    """
    kinds: dict[tuple[str, int, bool, bool], list[JointRun]] = {}
    for run in runs:
        kind = (run.kind, run.response.shape[1], run.stroke is None, run.tension is None)
        kinds.setdefault(kind, []).append(run)
    problems = tuple(build_joint_problem(config, members) for members in kinds.values())
    return Posed(tuple(parameters), problems, fixed or {}, weights or {})


def fit_parameters(posed: Posed, start: Mapping[str, float] | None = None) -> CalibrationFit:
    """Fit the parameters; what the recordings cannot tell is held at ``start`` (the configured values by default)."""
    at = {parameter.name: parameter.value for parameter in posed.parameters} | dict(start or {})
    held: dict[str, float] = {}
    reasons: list[tuple[Calibratable, str]] = []
    while True:
        free = [parameter for parameter in posed.parameters if parameter.name not in held]
        if not free:
            return CalibrationFit(posed, posed.white, (), np.zeros((0, 0)), tuple(reasons), converged=True)
        near = _solve(posed, free, at, held, posed.white, tolerance=ROUGH_TOLERANCE)
        start_here = posed.values(near.x, held)
        rough = _solve(posed, free, start_here, held, posed.white, robust=True, tolerance=ROUGH_TOLERANCE)
        if not all(rough.seen):
            given_up, reason = _given_up(free, rough)
            held[given_up.name] = at[given_up.name]
            reasons.append((given_up, reason))
            continue
        break
    posed, weights = _second_pass(posed, posed.values(rough.x, held))
    fine = _coloured(posed, weights, _solve(posed, free, posed.values(rough.x, held), held, weights))
    return CalibrationFit(
        posed,
        weights,
        tuple(_estimates(posed, free, held, weights, fine)),
        fine.correlation,
        tuple(reasons),
        fine.verdict.converged,
    )


def refit(whole: CalibrationFit, rows: Mapping[str, Booleans]) -> CalibrationFit | None:
    """Refit some rows of each run, weighted as in the whole fit; what they cannot tell stays at the whole fit's values.

    Returns None where the rows are too few.
    """
    posed = whole.posed.only(rows)
    posed = replace(posed, problems=tuple(p for p in posed.problems if any(mask.any() for mask in p.train)))
    weights = [
        w
        for p, w in zip(whole.posed.only(rows).problems, whole.weights, strict=True)
        if any(mask.any() for mask in p.train)
    ]
    free = [estimate.parameter for estimate in whole.estimates]
    held = {parameter.name: parameter.value for parameter, _ in whole.held}
    reasons: list[tuple[Calibratable, str]] = []
    while free:
        if sum(problem.observed.size for problem in posed.problems) <= len(free):
            return None
        fine = _solve(posed, free, whole.values, held, weights)
        if all(fine.seen):
            fine = _coloured(posed, weights, fine)
            return CalibrationFit(
                posed,
                tuple(weights),
                tuple(_estimates(posed, free, held, weights, fine, profile=False)),
                fine.correlation,
                tuple(reasons),
                fine.verdict.converged,
            )
        given_up, reason = _given_up(free, fine)
        held[given_up.name] = whole.values[given_up.name]
        free.remove(given_up)
        reasons.append((given_up, reason))
    return None


def _solve(
    posed: Posed,
    free: Sequence[Calibratable],
    at: Mapping[str, float],
    held: Mapping[str, float],
    weights: Sequence[Weights],
    *,
    robust: bool = False,
    tolerance: float = FINE_TOLERANCE,
) -> FitResult:
    return least_squares(
        lambda x: posed.residual(posed.values(x, held), weights),
        np.array([parameter.inner(at[parameter.name]) for parameter in free]),
        *_bounds(free),
        robust=robust,
        tolerance=tolerance,
        polish=tolerance == FINE_TOLERANCE,
    )


def _coloured(posed: Posed, weights: Sequence[Weights], fine: FitResult) -> FitResult:
    """Return the fit with the covariance that residuals of the found colour give it."""
    from scipy.signal import fftconvolve

    inverse = np.linalg.pinv(fine.jacobian.T @ fine.jacobian, hermitian=True)
    spread = np.zeros_like(inverse)
    start = 0
    for rows, colour in posed.sequences(weights):
        slopes = np.zeros((int(rows[-1]) + 1 if rows.size else 0, len(fine.x)))
        slopes[rows] = fine.jacobian[start : start + rows.size]
        start += rows.size
        memory, white = NOISE_COLOURS[colour]
        spread += white * slopes.T @ slopes
        if white < 1.0 and rows.size:
            lag = np.abs(np.arange(1 - len(slopes), len(slopes)))
            smeared = fftconvolve(slopes, (memory**lag)[:, None], axes=0)
            spread += (1.0 - white) * slopes.T @ smeared[len(slopes) - 1 : 2 * len(slopes) - 1]
    # what the fit takes out of the residual is more than p degrees where the residual is as slow as the sensitivities
    degrees = len(fine.residual) - float(np.trace(inverse @ spread))
    covariance = 2.0 * fine.cost / max(degrees, 1.0) * inverse @ spread @ inverse
    return replace(fine, covariance=covariance, std=np.sqrt(np.maximum(np.diag(covariance), 0.0)))


def _bounds(free: Sequence[Calibratable]) -> tuple[Floats, Floats]:
    return np.array([p.inner(p.low) for p in free]), np.array([p.inner(p.high) for p in free])


def _given_up(free: Sequence[Calibratable], rough: FitResult) -> tuple[Calibratable, str]:
    """Return the parameter to hold next, and why in words."""
    unseen = [parameter for parameter, seen in zip(free, rough.seen, strict=True) if not seen]
    found = min(unseen, key=lambda parameter: HELD_FIRST.index(parameter.name))
    rivals = [p.name for p in unseen if p is not found and np.linalg.norm(rough.jacobian[:, free.index(p)]) > 0.0]
    if np.linalg.norm(rough.jacobian[:, free.index(found)]) == 0.0 or not rivals:
        return found, "these recordings do not depend on it"
    return found, f"these recordings fix only its product with {' and '.join(rivals)}"


def _second_pass(posed: Posed, values: Mapping[str, float]) -> tuple[Posed, tuple[Weights, ...]]:
    """Drop outliers of the first pass, and take level and colour from what it left."""
    problems, weights = [], []
    for problem in posed.problems:
        predictions = problem.predict_with(values, ())
        usable = []
        errors = [prediction.response - run.response for run, prediction in zip(problem.runs, predictions, strict=True)]
        spread = 1.4826 * float(np.nanmedian(np.abs(np.concatenate([error.ravel() for error in errors]))))
        for mask, error in zip(problem.usable, errors, strict=True):
            usable.append(mask & ~(np.abs(error) > OUTLIER * max(spread, problem.noise)))
        kept = replace(problem, usable=tuple(usable))
        response, tension = kept.fitted(predictions)
        level, colour = _level_and_colour(kept.bank, response - kept.observed)
        weights.append(Weights(level, colour, *_level_and_colour(kept.tension_bank, tension - kept.observed_tension)))
        problems.append(kept)
    return replace(posed, problems=tuple(problems)), tuple(weights)


def _level_and_colour(bank: NoiseBank, residual: Floats) -> tuple[float, int]:
    """Return the level and colour of a residual; white unless a colour is worth its two parameters (Akaike)."""
    if residual.size == 0:
        return 1.0, 0
    evidence = bank.evidence(residual)
    white = max(float(np.sqrt(np.mean(residual**2))), 1e-15)
    likelihood = -0.5 * residual.size * (np.log(2.0 * np.pi * white**2) + 1.0)
    return (evidence.level, evidence.colour) if evidence.log_likelihood > likelihood + 2.0 else (white, 0)


def _estimates(
    posed: Posed,
    free: Sequence[Calibratable],
    held: Mapping[str, float],
    weights: Sequence[Weights],
    fine: FitResult,
    *,
    profile: bool = True,
) -> Iterator[Estimate]:
    """Yield each parameter with its interval: quadratic where the cost is, by the profile (if allowed) elsewhere."""
    from scipy.stats import t

    def residual(x: Floats) -> Floats:
        return posed.residual(posed.values(x, held), weights)

    lower, upper = _bounds(free)
    inverse = np.asarray(np.linalg.pinv(fine.jacobian.T @ fine.jacobian, hermitian=True), dtype=np.float64)
    half = float(t.ppf(0.5 + 0.5 * LEVEL, max(len(fine.residual) - len(fine.x), 1)))
    for index, parameter in enumerate(free):
        std, x = float(fine.std[index]), float(fine.x[index])
        profiled = profile and _poor(residual, fine, index, inverse[:, index], half * std, (lower, upper))
        if profiled:
            variance = std**2 / inverse[index, index] if inverse[index, index] > 0.0 else None
            low, high = profile_interval(residual, fine, index, lower, upper, level=LEVEL, variance=variance)
        else:
            low, high = max(x - half * std, lower[index]), min(x + half * std, upper[index])
        value = parameter.outer(x)
        slope = value if parameter.name in LOGARITHMIC else 1.0
        yield Estimate(
            parameter, value, std * slope, parameter.outer(low), parameter.outer(high), profiled, fine.at_bound[index]
        )


def _poor(
    residual: Residual, fine: FitResult, index: int, direction: Floats, half: float, bounds: tuple[Floats, Floats]
) -> bool:
    """Whether the cost at the ends of the interval is not the quadratic's, or a bound is within reach.

    Args:
        direction: in which the other parameters follow, the parameter's column of the inverse of the normal matrix.
        half: half the width of the interval.
    """
    lower, upper = bounds
    if not np.isfinite(half) or half == 0.0 or direction[index] <= 0.0 or fine.at_bound[index]:
        return True
    step = half * direction / direction[index]
    for at in (fine.x - step, fine.x + step):
        if (at <= lower).any() or (at >= upper).any():
            return True
        there = residual(at)
        rise = 0.5 * float(there @ there) - fine.cost
        if abs(rise / (0.5 * half**2 / direction[index]) - 1.0) > POOR_QUADRATIC:
            return True
    return False
