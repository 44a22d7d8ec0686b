"""How well a fit foretells points that it has not seen: those kept back, and each photograph against the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from coast_cli.diagnosis.contest import carried_start
from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.space import Booleans, inverse
from coast_cli.diagnosis.thresholds import MOST_UNSEEN_NOISE
from coast_cli.diagnosis.unseen import Unseen, judge_unseen, stretch_of
from coast_cli.mechanics.section import FloatArray


def points_foretold(problem: ShapeProblem, fitted: Fit, rows: Sequence[Booleans], asked: int = 1) -> Unseen:
    """Return how well a fit foretells points; ``problem`` is the one that it was fitted to, ``asked`` as `judge_unseen` has it.

    Numbers of tubes that no fitted photograph shows are as sure as their priors.
    """
    unseen = problem.only(rows)
    if unseen.size == 0:
        return Unseen(0.0, float(MOST_UNSEEN_NOISE), 0, 1.0)
    space = unseen.space(fitted.effects)
    vector = space.joined(carried_start(problem=problem, fitted=fitted, whole=unseen))
    here = unseen.residuals([space.split(vector)])[0]
    slopes = space.jacobian(
        lambda vectors: unseen.residuals([space.split(one) for one in vectors]), vector, here, space.moving
    )
    covariance = _carried_covariance(problem, fitted, unseen)
    return judge_unseen(here, slopes, covariance, problem.noise, stretch_of(problem.correlation), asked)


def photographs_against_the_rest(problem: ShapeProblem, fitted: Fit) -> dict[str, Unseen]:
    """Return by name how well the other photographs foretell each: to first order, and by a fit without it where that fails.

    To first order a photograph is left out of the fit by one Gauss-Newton step of the rest (Cook and Weisberg, Residuals and
    Influence in Regression, 1982, ch. 3).
    """
    level, stretch = max(problem.noise, 1e-15), stretch_of(problem.correlation)
    prior = np.diag(1.0 / problem.space(fitted.effects).spread ** 2)
    found = {}
    for index, (photograph, rows) in enumerate(zip(problem.photographs, problem.slices, strict=True)):
        mine = np.zeros(problem.size, dtype=bool)
        mine[rows] = True
        if not mine.any() or mine.all():
            continue
        rest, slopes = fitted.jacobian[~mine] / level, fitted.jacobian[mine]
        covariance = inverse(rest.T @ rest / stretch + prior)
        step = -covariance @ (rest.T @ fitted.residual[~mine]) / level / stretch
        missed = fitted.residual[mine] + slopes @ step
        one = judge_unseen(missed, slopes, covariance, level, stretch, len(problem.photographs))
        found[photograph.run.name] = one if one.passed else _refitted_without(problem, fitted, index)
    return found


def _refitted_without(problem: ShapeProblem, fitted: Fit, index: int) -> Unseen:
    """Return how well the other photographs foretell one, after a fit to them alone."""
    own = [train if place == index else np.zeros_like(train) for place, train in enumerate(problem.train)]
    rest = problem.only([train & ~mine for train, mine in zip(problem.train, own, strict=True)])
    start = carried_start(problem=problem, fitted=fitted, whole=rest)
    alone = fit(rest, fitted.effects, start, steps=6, until="fine")
    return points_foretold(rest, alone, own, len(problem.photographs))


def _carried_covariance(problem: ShapeProblem, fitted: Fit, unseen: ShapeProblem) -> FloatArray:
    """Return the covariance (q, q) of the numbers that unseen points depend on."""
    known = {parameter.name: place for place, parameter in enumerate(problem.base)}
    effects = range(len(problem.base), fitted.covariance.shape[0])
    places = [known.get(parameter.name, -1) for parameter in unseen.base] + list(effects)
    shared = np.array([place >= 0 for place in places])
    at = np.array(places)[shared]
    covariance = np.diag(unseen.space(fitted.effects).width ** 2)
    covariance[np.ix_(shared, shared)] = fitted.covariance[np.ix_(at, at)]
    return np.asarray(covariance)
