"""Bounded least squares with an honest answer: several separate yes-or-no's instead of one "success".

One descent serves every fit of the package: Gauss-Newton inside a trust region, variables scaled by the Jacobian's columns
(More, Lecture Notes in Mathematics 630, 1978), steps bent along the bounds, an end by what the next step could still gain.
`least_squares` says which parameters stopped on a bound, which never moved, which the residual cannot see, and gives
intervals from the quadratic (covariance) or from the profile of the cost where the quadratic is poor (Bates and Watts,
Nonlinear Regression Analysis, 1988, chapter 6). Tested on NIST's StRD nonlinear problems to their certified digits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.mechanics.verdict import Verdict

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Booleans = NDArray[np.bool_]

Residual = Callable[["Floats"], "Floats"]
Jacobian = Callable[["Floats", "Floats"], "Floats"]

TOLERANCE = 1e-14
MOST_STEPS = 5000
POLISHING_STEPS = 30
SHRINKING = 0.9
PROFILE_HALVINGS = 12
AT_BOUND = 1e-6
UNSEEN = 1e-9
_TRIALS = 40  # of the radius, in one step
_SECULAR = 30  # iterations for the damping
_POOR, _GOOD = 0.25, 0.75  # share of the foretold fall below and above which the radius changes
_ROUNDING = 1e-15  # of the cost
_FIRST_DAMPING = 1e-3  # of the squared norm of a column


@dataclass(frozen=True, slots=True)
class Descent:
    """Where a descent ended: x [p], residual [n], Jacobian [n, p] of the last step, cost, and whether it settled."""

    x: Floats
    residual: Floats
    jacobian: Floats
    cost: float
    steps: int
    gain: float
    converged: bool


def descend(
    residual: Residual,
    jacobian: Jacobian,
    start: Floats,
    lower: Floats,
    upper: Floats,
    *,
    steps: int,
    tolerance: float,
    reach: Floats | None = None,
    grid: Floats | None = None,
    robust: bool = False,
) -> Descent:
    """Minimise half the sum of squares of a residual between bounds, by at most so many steps.

    Args:
        residual: x [p] -> [n]. jacobian: x and its residual -> [n, p]; a column of zeros keeps its parameter where it is.
        start: [p], inside the bounds. lower, upper: [p], may be infinite.
        tolerance: the descent has settled where a whole step foretells a fall of the cost below this share of it.
        reach: longest step of each parameter, [p], as a bound on the step; the others follow.
        grid: spacing to which steps are rounded, [p], so that the last bits of a processor lead nowhere else.
        robust: soft-L1 loss, which grows linearly past residuals of 1.
    """
    x, fun = start.copy(), residual(start)
    cost, foretold, radius = _cost(fun, robust=robust), np.inf, np.inf
    scale, slopes = np.zeros_like(x), np.zeros((fun.size, x.size))
    for taken in range(steps):
        slopes = jacobian(x, fun)
        weighted, target = _robust(slopes, fun) if robust else (slopes, fun)
        scale = np.maximum(scale, np.linalg.norm(weighted, axis=0))
        unit = np.where(scale > 0.0, scale, 1.0)
        free = (np.linalg.norm(weighted, axis=0) > 0.0) & ~_blocked(x, weighted.T @ target, lower, upper)
        foretold = _foretold(weighted[:, free] / unit[free], target)
        if foretold <= tolerance * cost:
            return Descent(x, fun, slopes, cost, steps=taken, gain=foretold, converged=True)
        if taken == 0 and reach is None:
            radius = float(np.linalg.norm(x * unit)) or 1.0
        elif taken == 0:
            radius = _first_radius(weighted[:, free] / unit[free], target)
        low, high = lower - x, upper - x
        if reach is not None:
            low, high = np.maximum(low, -reach), np.minimum(high, reach)
        for _ in range(_TRIALS):
            step = _step(weighted / unit, target, radius, free, low * unit, high * unit) / unit
            trial = x + step if grid is None else np.rint((x + step) / grid) * grid
            trial = np.clip(np.where(step == 0.0, x, trial), lower, upper)
            trial_fun = fun if np.array_equal(trial, x) else residual(trial)
            trial_cost = _cost(trial_fun, robust=robust)
            moved = weighted @ (trial - x)
            expected = -float(target @ moved) - 0.5 * float(moved @ moved)
            gain, size = (cost - trial_cost) / max(expected, 1e-300), float(np.linalg.norm((trial - x) * unit))
            radius = 0.25 * size if gain < _POOR else max(radius, 2.0 * size) if gain > _GOOD else radius
            if trial_cost < cost or expected <= _ROUNDING * cost:
                break
        if not trial_cost < cost:
            return Descent(x, fun, slopes, cost, steps=taken, gain=foretold, converged=True)
        settled = max(cost - trial_cost, expected) <= tolerance * cost
        x, fun, cost = trial, trial_fun, trial_cost
        if settled:
            return Descent(x, fun, slopes, cost, steps=taken + 1, gain=foretold, converged=True)
    return Descent(x, fun, slopes, cost, steps=steps, gain=foretold, converged=False)


def _blocked(x: Floats, gradient: Floats, lower: Floats, upper: Floats) -> Booleans:
    """Return which parameters stand on a bound and would leave it."""
    blocked: Booleans = ((x <= lower) & (gradient > 0.0)) | ((x >= upper) & (gradient < 0.0))
    return blocked


def _foretold(slopes: Floats, target: Floats) -> float:
    """Return by how much a whole Gauss-Newton step of the free parameters would lower the cost, to first order."""
    if slopes.shape[1] == 0:
        return 0.0
    left, size, _ = np.linalg.svd(slopes, full_matrices=False)
    along = left[:, size > UNSEEN * max(float(size.max()), 1e-300)].T @ target
    return 0.5 * float(along @ along)


def _step(slopes: Floats, target: Floats, radius: float, free: Booleans, low: Floats, high: Floats) -> Floats:
    """Return the best step inside a radius and between bounds: what would pass one stops there, and the others follow."""
    step = np.zeros(slopes.shape[1])
    moving = free.copy()
    while moving.any():
        rest = target + slopes @ np.where(moving, 0.0, step)
        fixed = float(np.linalg.norm(np.where(moving, 0.0, step)))
        step[moving] = _inside(slopes[:, moving], rest, np.sqrt(max(radius**2 - fixed**2, (0.01 * radius) ** 2)))
        beyond = moving & ((step < low) | (step > high))
        if not beyond.any():
            break
        step = np.where(beyond, np.clip(step, low, high), step)
        moving &= ~beyond
    return step


def _inside(slopes: Floats, target: Floats, radius: float) -> Floats:
    """Return the least-squares step no longer than a radius: damped by the root of the secular equation (Hebden, 1973)."""
    left, size, right = np.linalg.svd(slopes, full_matrices=False)
    seen = size > UNSEEN * size[0]
    size, along, right = size[seen], -(left.T @ target)[seen], right[seen]
    damping = 0.0
    for _ in range(_SECULAR):
        step = size * along / (size**2 + damping)
        norm = float(np.linalg.norm(step))
        if norm <= 1.01 * radius:
            break
        slope = float(np.sum(step**2 / (size**2 + damping)))
        damping += (norm / radius - 1.0) * norm**2 / slope
    found: Floats = right.T @ step
    return found


def _first_radius(slopes: Floats, target: Floats) -> float:
    """Return the length of a step that leaves out what the residual hardly sees, to begin with."""
    left, size, _ = np.linalg.svd(slopes, full_matrices=False)
    return float(np.linalg.norm(size * (left.T @ target) / (size**2 + _FIRST_DAMPING)))


def _robust(slopes: Floats, fun: Floats) -> tuple[Floats, Floats]:
    """Return Jacobian and residual weighted as soft L1 weights them here: iteratively reweighted, it never overshoots."""
    weight = (1.0 + fun**2) ** -0.25
    return slopes * weight[:, np.newaxis], fun * weight


@dataclass(frozen=True, eq=False)
class FitResult:
    """A fit of p parameters to n residuals.

    Attributes:
        x: [p].
        std: [p], infinite where the residual does not see the parameter or cannot tell it from others.
        covariance: [p, p], of the parameters that are seen; zero elsewhere.
        cost: half the sum of squared residuals (of the robust loss where that was asked for).
        residual: [n]. jacobian: [n, p], weighted by the robust loss.
        at_bound: whether a parameter stopped on one of its bounds.
        moved: whether it left its start.
        seen: whether the residual determines it.
        verdict: whether the solver converged, and what to do where it did not.
    """

    x: Floats
    std: Floats
    covariance: Floats
    cost: float
    residual: Floats
    jacobian: Floats
    at_bound: tuple[bool, ...]
    moved: tuple[bool, ...]
    seen: tuple[bool, ...]
    verdict: Verdict

    @property
    def variance(self) -> float:
        """Residual variance: twice the cost a degree of freedom; 0 where there is none left."""
        degrees = len(self.residual) - len(self.x)
        return 2.0 * self.cost / degrees if degrees > 0 else 0.0

    @property
    def correlation(self) -> Floats:
        """Correlation of the parameters, [p, p]; zero where a parameter is not seen."""
        spread = np.sqrt(np.diag(self.covariance))
        spread = np.where(spread > 0.0, spread, np.inf)
        table: Floats = self.covariance / np.outer(spread, spread)
        return table


def least_squares(
    residual: Residual,
    start: Floats,
    lower: Floats,
    upper: Floats,
    *,
    robust: bool = False,
    jacobian: Callable[[Floats], Floats] | None = None,
    tolerance: float = TOLERANCE,
    polish: bool = True,
) -> FitResult:
    """Minimise half the sum of squares of ``residual`` between bounds.

    Args:
        residual: parameters [p] -> residuals [n]; finite inside the bounds.
        start: [p], moved inside the bounds where it is not.
        lower, upper: [p], may be infinite.
        robust: Huber-like loss (soft L1) that grows linearly past residuals of 1, so weight them by their noise.
        jacobian: parameters -> [n, p]; by default central differences.
        tolerance: share of the cost that a further step may still gain where the descent ends.
        polish: take the last Gauss-Newton steps to all digits; not for a fit that is only a start.

    Returns:
        The fit; a solver that did not converge is a verdict in it, not an exception.
    """
    lower, upper = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    width = upper - lower
    begin = np.clip(np.asarray(start, dtype=np.float64), lower, upper)
    slopes = jacobian or _differences(residual, lower, upper)
    found = descend(
        residual,
        lambda x, _: slopes(x),
        begin,
        lower,
        upper,
        steps=MOST_STEPS,
        tolerance=tolerance,
        robust=robust,
    )
    x, fun, gradient, cost = found.x, found.residual, slopes(found.x), found.cost
    if robust:
        gradient = _robust(gradient, fun)[0]
    if polish and not robust and found.converged:
        x, fun, gradient = _polish(residual, slopes, x, lower, upper)
        cost = float(0.5 * fun @ fun)
    verdict = Verdict(
        converged=found.converged,
        message="converged"
        if found.converged
        else "the fit stopped at its step limit; start it closer or fix a parameter",
        iterations=found.steps,
        residual=found.gain,
    )
    size = np.maximum(np.abs(x), np.abs(begin))
    covariance, seen = _covariance(gradient, cost, np.where(size > 0.0, size, 1.0))
    spread = np.where(np.isfinite(width), width, np.maximum(np.abs(x), 1.0))
    return FitResult(
        x=x,
        std=np.where(seen, np.sqrt(np.diag(covariance)), np.inf),
        covariance=covariance,
        cost=cost,
        residual=fun,
        jacobian=gradient,
        at_bound=tuple((np.minimum(x - lower, upper - x) < AT_BOUND * spread).tolist()),
        moved=tuple((np.abs(x - begin) > 1e-9 * np.maximum(np.abs(begin), 1e-6 * spread)).tolist()),
        seen=tuple(seen.tolist()),
        verdict=verdict,
    )


def _polish(
    residual: Residual, jacobian: Callable[[Floats], Floats], x: Floats, lower: Floats, upper: Floats
) -> tuple[Floats, Floats, Floats]:
    """Take Gauss-Newton steps in the parameters off their bounds while they lower the cost.

    The solver stops when the cost no longer falls in double precision, where the parameters have half the digits.
    Returns parameters, residual and Jacobian.
    """
    fun = residual(x)
    gradient = jacobian(x)
    span = np.where(np.isfinite(upper - lower), upper - lower, np.maximum(np.abs(x), 1.0))
    free = (x - lower > AT_BOUND * span) & (upper - x > AT_BOUND * span)
    latest = np.inf
    for _ in range(POLISHING_STEPS if free.any() else 0):
        norms = np.linalg.norm(gradient[:, free], axis=0)
        norms = np.where(norms > 0.0, norms, 1.0)
        step = np.zeros_like(x)
        step[free] = np.linalg.lstsq(gradient[:, free] / norms, -fun, rcond=UNSEEN)[0] / norms
        trial = np.clip(x + step, lower, upper)
        trial_fun = residual(trial)
        if not float(trial_fun @ trial_fun) <= float(fun @ fun) * (1.0 + 1e-15):
            break
        size = float(np.max(np.abs(trial - x) / np.maximum(np.abs(x), 1e-300)))
        x, fun = trial, trial_fun
        gradient = jacobian(x)
        if size <= 1e-13 or size > SHRINKING * latest:
            break
        latest = size
    return x, fun, gradient


def _differences(residual: Residual, lower: Floats, upper: Floats) -> Callable[[Floats], Floats]:
    """Return the Jacobian by central differences that stay inside the bounds."""
    width = upper - lower
    least = np.where(np.isfinite(width), 1e-4 * width, 0.0)

    def jacobian(x: Floats) -> Floats:
        size = np.maximum(np.abs(x), least)
        step = np.finfo(np.float64).eps ** (1.0 / 3.0) * np.where(size > 0.0, size, 1.0)
        columns = []
        for place, size in enumerate(step):
            ahead, behind = x.copy(), x.copy()
            ahead[place] = min(x[place] + size, upper[place])
            behind[place] = max(x[place] - size, lower[place])
            columns.append((residual(ahead) - residual(behind)) / (ahead[place] - behind[place]))
        return np.column_stack(columns)

    return jacobian


def _covariance(jacobian: Floats, cost: float, size: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the covariance over the directions that the residual sees, and which parameters lie wholly in them."""
    count, parameters = jacobian.shape
    scaled = jacobian * size
    norms = np.linalg.norm(scaled, axis=0)
    visible = norms > UNSEEN * max(float(norms.max(initial=0.0)), 1e-300)
    unit = np.where(visible, norms, 1.0)
    values, vectors = np.linalg.eigh((scaled / unit).T @ (scaled / unit))
    kept = values > UNSEEN * max(float(values[-1]), 1e-300)
    blind = np.sqrt((vectors[:, ~kept] ** 2).sum(axis=1)) > 1e-3
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    to_parameters = size / unit
    variance = 2.0 * cost / (count - parameters) if count > parameters else 0.0
    covariance: Floats = variance * inverse * np.outer(to_parameters, to_parameters)
    seen = visible & ~blind
    covariance[~seen] = 0.0
    covariance[:, ~seen] = 0.0
    return covariance, seen


def profile_interval(
    residual: Residual,
    fit: FitResult,
    index: int,
    lower: Floats,
    upper: Floats,
    *,
    level: float = 0.9,
    robust: bool = False,
    variance: float | None = None,
) -> tuple[float, float]:
    """Return the interval of one parameter over which the cost, the others refitted, stays below its threshold.

    Args:
        residual, lower, upper, robust: as given to `least_squares`.
        fit: its answer.
        index: of the parameter.
        level: of confidence.
        variance: of a residual; by default that of the fit.

    Returns:
        (low, high); a bound of the parameter where the cost does not reach the threshold before it.
    """
    from scipy.stats import t

    degrees = max(len(fit.residual) - len(fit.x), 1)
    noise = fit.variance if variance is None else variance
    threshold = float(t.ppf(0.5 + 0.5 * level, degrees))
    others = [place for place in range(len(fit.x)) if place != index]
    latest = fit.x[others]

    def excess(value: float) -> float:
        """Return the signed root of the rise in cost, less the threshold."""
        nonlocal latest
        if others:
            at = least_squares(
                lambda rest: residual(np.insert(rest, index, value)),
                latest,
                lower[others],
                upper[others],
                robust=robust,
                tolerance=1e-10,
            )
            latest, cost = at.x, at.cost
        else:
            cost = _cost(residual(np.array([value])), robust=robust)
        return float(np.sqrt(max(2.0 * (cost - fit.cost), 0.0) / noise)) - threshold if noise > 0.0 else threshold

    ends = []
    for side, bound in ((-1.0, float(lower[index])), (1.0, float(upper[index]))):
        latest = fit.x[others]
        step = threshold * float(fit.std[index]) if np.isfinite(fit.std[index]) else np.inf
        inner, outer = float(fit.x[index]), float(np.clip(fit.x[index] + side * step, lower[index], upper[index]))
        for _ in range(12):
            if not np.isfinite(outer) or excess(outer) >= 0.0 or outer == bound:
                break
            inner, outer = outer, float(np.clip(outer + side * step, lower[index], upper[index]))
            step *= 2.0
        if not np.isfinite(outer) or outer == inner or excess(outer) < 0.0:
            ends.append(bound)
        else:
            ends.append(_bisected(excess, inner, outer))
    return ends[0], ends[1]


def _bisected(excess: Callable[[float], float], inside: float, outside: float) -> float:
    """Return where the excess turns positive; halving stays safe where a refit jumps to another valley."""
    for _ in range(PROFILE_HALVINGS):
        middle = 0.5 * (inside + outside)
        if excess(middle) < 0.0:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


def _cost(residuals: Floats, *, robust: bool) -> float:
    if robust:
        return float(np.sum(np.sqrt(1.0 + residuals**2) - 1.0))
    return float(0.5 * residuals @ residuals)
