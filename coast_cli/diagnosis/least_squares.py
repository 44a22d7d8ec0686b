"""Bounded least squares with an honest answer: several separate yes-or-no's instead of one "success".

A thin layer over scipy's trust-region reflective solver (Branch, Coleman and Li, SIAM J. Sci. Comput. 21, 1999). It
says which parameters stopped on a bound, which never moved, which the residual cannot see, and gives intervals from the
quadratic (covariance) or from the profile of the cost where the quadratic is poor (Bates and Watts, Nonlinear
Regression Analysis, 1988, chapter 6). Tested on NIST's StRD nonlinear problems to their certified digits.
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

Residual = Callable[["Floats"], "Floats"]

TOLERANCE = 1e-14
MOST_EVALUATIONS = 5000
POLISHING_STEPS = 30
SHRINKING = 0.9
PROFILE_HALVINGS = 12
AT_BOUND = 1e-6
UNSEEN = 1e-9


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
    scale: Floats | None = None,
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
        scale: [p], typical size of a step in each parameter; by default taken from the Jacobian.
        robust: Huber-like loss (soft L1) that grows linearly past residuals of 1, so weight them by their noise.
        jacobian: parameters -> [n, p]; by default three-point differences.
        tolerance: of cost, step and gradient.
        polish: take the last Gauss-Newton steps to all digits; not for a fit that is only a start.

    Returns:
        The fit; a solver that did not converge is a verdict in it, not an exception.
    """
    from scipy.optimize import least_squares as solve

    lower, upper = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    width = upper - lower
    margin = np.where(np.isfinite(width), 1e-10 * width, 0.0)
    begin = np.clip(np.asarray(start, dtype=np.float64), lower + margin, upper - margin)
    with np.errstate(over="ignore"):  # the trust region's secular equation may pass through infinity on its way
        solution = solve(
            residual,
            begin,
            jac=jacobian if jacobian is not None else "3-point",
            bounds=(lower, upper),
            x_scale="jac" if scale is None else scale,
            loss="soft_l1" if robust else "linear",
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
            max_nfev=MOST_EVALUATIONS,
        )
    x, fun, gradient, cost = solution.x, solution.fun, np.asarray(solution.jac), float(solution.cost)
    if polish and not robust and solution.status > 0:
        x, fun, gradient = _polish(residual, jacobian or _differences(residual, lower, upper), x, lower, upper)
        cost = float(0.5 * fun @ fun)
    verdict = Verdict(
        converged=bool(solution.status > 0),
        message="converged"
        if solution.status > 0
        else "the fit stopped at its step limit; start it closer or fix a parameter",
        iterations=int(solution.nfev),
        residual=float(solution.optimality),
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
