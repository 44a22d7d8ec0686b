"""How well a fit foretells rows that it has not seen, in noise widths, beside what noise and its own doubt allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.space import Booleans, inverse
from coast_cli.diagnosis.thresholds import MOST_UNSEEN_NOISE
from coast_cli.diagnosis.unseen import Unseen, judge_unseen, stretch_of
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.mechanics.section import FloatArray

_MOST_SUSPECTS = 3


def foretold(problem: JointProblem, fitted: Fit, rows: Sequence[Booleans], *, asked: int = 1) -> Unseen:
    """Return how well a fit foretells rows; ``problem`` is the one that it was fitted to, ``asked`` how many runs are asked."""
    unseen = problem.only(rows)
    if unseen.observed.size == 0:
        return Unseen(0.0, float(MOST_UNSEEN_NOISE), 0, 1.0)
    residual, slopes = _residual_and_slopes(unseen, fitted)
    return _judged(problem, residual, slopes, fitted.covariance, asked)


def strangers(problem: JointProblem, fitted: Fit, base: Fit, runs: Mapping[str, Unseen]) -> dict[str, Unseen]:
    """Return by name the fitted runs that the others do not foretell: seen to first order, then refitted without the run.

    A law without a name may bend anywhere, so a run that the others do not foretell speaks against it only where it does
    worse there than ``base``, the fit of the base model. ``runs``: how well the others foretell each, to first order.
    """
    suspects = {name: one for name, one in runs.items() if not one.passed}
    worst = sorted(suspects, key=lambda name: (-suspects[name].error / suspects[name].allowed, name))[:_MOST_SUSPECTS]
    found = {}
    for name in worst:
        mine = [
            rows if run.name == name else 0 * rows > 0 for run, rows in zip(problem.runs, problem.train, strict=True)
        ]
        rest = problem.only([rows & ~own for rows, own in zip(problem.train, mine, strict=True)])
        one = foretold(rest, fit(rest, fitted.effects, fitted.coordinates, steps=0), mine, asked=len(runs))
        if any(isinstance(effect, UnnamedLaw) for effect in fitted.effects):
            one = replace(one, allowed=max(one.allowed, foretold(rest, base, mine).error))
        if not one.passed:
            found[name] = one
    return found


def runs_against_the_rest(problem: JointProblem, fitted: Fit) -> dict[str, Unseen]:
    """Return by name how well the other runs foretell each fitted run, to first order.

    A run is left out of the fit by one Gauss-Newton step: parameters move to where the rest draws them (Cook and Weisberg,
    Residuals and Influence in Regression, 1982, ch. 3).
    """
    size = problem.observed.size
    residual, slopes = fitted.residual, fitted.jacobian[:size]
    level = max(problem.floor, 1e-15)
    spread = problem.space(fitted.effects).spread
    prior = np.diag(1.0 / spread**2)
    stretch = _stretch(problem)
    owner = np.concatenate([np.full(rows.size, index) for index, _, rows in problem.sequences])
    found = {}
    for index in np.unique(owner).tolist():
        mine = owner == index
        if np.all(mine):
            return {}
        rest = slopes[~mine] / level
        covariance = inverse(rest.T @ rest / stretch + prior)
        # At the optimum the whole gradient vanishes, so what the run pulls is what the rest would take back.
        step = covariance @ (slopes[mine].T @ residual[mine]) / level**2 / stretch
        found[problem.runs[index].name] = _judged(
            problem, residual[mine] + slopes[mine] @ step, slopes[mine], covariance, len(problem.runs)
        )
    return found


def _stretch(problem: JointProblem) -> float:
    """Return by how much coloured noise makes variances of parameters larger than white noise does."""
    return stretch_of(problem.noise_estimate.correlation)


def _judged(
    problem: JointProblem, residual: FloatArray, slopes: FloatArray, covariance: FloatArray, asked: int
) -> Unseen:
    """Return what unseen rows say; a run of slow noise is no fault, so all of it is granted."""
    return judge_unseen(residual, slopes, covariance, problem.highest_floor, _stretch(problem), asked)


def _residual_and_slopes(problem: JointProblem, fitted: Fit) -> tuple[FloatArray, FloatArray]:
    space = problem.space(fitted.effects)
    vector = space.joined(fitted.coordinates)
    here = problem.residuals([space.split(vector)])[0]
    slopes = space.jacobian(
        lambda vectors: problem.residuals([space.split(one) for one in vectors]), vector, here, space.moving
    )
    size = problem.observed.size
    return here[:size], slopes[:size]
