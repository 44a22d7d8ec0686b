"""When a motor lost steps: every row of every run is tried as the moment, to first order, and the best ones are kept.

A step of the stroke changes the response by its slope over the stroke from that row on. What the base parameters could do
instead is taken off first; further moments of the same run are added as long as each earns its place, and each is then put
where it is best beside the others (matching pursuit: Mallat and Zhang, IEEE Trans. Signal Processing 41 (1993) 3397).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.fit import Fit, fit, rms
from coast_cli.diagnosis.thresholds import MOMENT_NATS
from coast_cli.effects.library.lost_steps import LostSteps
from coast_cli.effects.library.run_differs import RunDiffers

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem

_MOST_MOMENTS = 3
_MOST_PLACES = 60  # moments of one run that are tried
_EARLIEST = 0.02  # of a run: before it a loss is a zero that was set elsewhere
_NUDGE_MM = 0.02
_MOST_MM = 4.9
_STEPS = 6
_UNSEEN = 1e-4  # of the largest power: a moment after which nothing moves


def lost_steps(problem: JointProblem, run: int | None = None) -> tuple[LostSteps, ...]:
    """Return lost steps as a rough fit finds them: the run, its moments, and how much; nothing where no run shows any.

    Args:
        run: number of the run in which they are sought; every fitted run by default.
    """
    numbers = range(len(problem.runs)) if run is None else (run,)
    base = problem.refitted
    found = [one for number in numbers if (one := _best_moment(problem, base, number)) is not None]
    if not found:
        return ()
    first = max(found, key=lambda one: one.gain)
    number, moments = first.run, [first.moment]
    fitted = _fit(problem, number, moments)
    for _ in range(_MOST_MOMENTS - 1):
        more = _best_moment(problem, fitted, number)
        if more is None:
            break
        moments.append(more.moment)
        fitted = _fit(problem, number, moments)
    for place in range(len(moments) if len(moments) > 1 else 0):
        rest = [moment for index, moment in enumerate(fitted_moments(fitted)) if index != place]
        moved = _best_moment(problem, _fit(problem, number, rest), number)
        if moved is not None:
            better = _fit(problem, number, [*rest, moved.moment])
            fitted = min((fitted, better), key=lambda one: one.rmse)
    return (LostSteps.of(number, fitted_moments(fitted)),)


def fitted_moments(fitted: Fit) -> list[tuple[float, float]]:
    """Return what a fit of lost steps says was lost (mm), and when (s), in order of time."""
    moments = next(effect.moments for effect in fitted.effects if isinstance(effect, LostSteps))
    return sorted((one for one in moments if one[0] != 0.0), key=lambda one: one[1])


def _fit(problem: JointProblem, number: int, moments: list[tuple[float, float]]) -> Fit:
    return fit(problem, (LostSteps.of(number, moments),), problem.refitted.coordinates, steps=_STEPS, until="rough")


@dataclass(frozen=True, slots=True)
class _Found:
    """One more moment (mm, s) of a run, and by how many nats it explains more."""

    run: int
    moment: tuple[float, float]
    gain: float


def _best_moment(problem: JointProblem, fitted: Fit, number: int) -> _Found | None:
    """Return the moment of one run that explains most of what a fit leaves; None where none earns its place."""
    run = problem.runs[number]
    if run.time is None or not problem.train[number].any():
        return None
    size = fitted.residual.size
    nudge = RunDiffers(run=float(number), stroke_zero_mm=_NUDGE_MM)
    nudged = problem.residuals([(fitted.coordinates, problem.ordered((*fitted.effects, nudge)))])[0]
    slope = (nudged - fitted.stacked)[:size] / _NUDGE_MM
    owner = np.concatenate([np.full(rows.size, index) for index, _, rows in problem.sequences])
    rows = np.concatenate([rows for _, _, rows in problem.sequences])
    mine = owner == number
    places = np.unique(rows[mine])
    places = places[places >= max(_EARLIEST * len(run), 1)]
    if places.size == 0 or not np.any(slope):
        return None
    places = places[np.unique(np.linspace(0, places.size - 1, _MOST_PLACES).astype(int))]
    level = max(rms(fitted.residual), problem.floor)
    nuisance = fitted.jacobian[:size] / level
    precision = nuisance.T @ nuisance + np.diag(1.0 / problem.space(fitted.effects).spread ** 2)
    steps = np.where(mine[:, np.newaxis] & (rows[:, np.newaxis] >= places), slope[:, np.newaxis], 0.0) / level
    steps -= nuisance @ np.linalg.solve(precision, nuisance.T @ steps)
    power = np.sum(steps**2, axis=0)
    seen = power > _UNSEEN * float(power.max())
    pull = np.where(seen, steps.T @ fitted.residual / level, 0.0)
    gains = 0.5 * pull**2 / np.where(seen, power, 1.0)
    best = int(np.argmax(gains))
    if gains[best] < MOMENT_NATS:
        return None
    clock = run.time - run.time[0]
    at = 0.5 * float(clock[places[best]] + clock[places[best] - 1])
    # Recorded less predicted falls where stroke is missing.
    lost = float(np.clip(-pull[best] / power[best], -_MOST_MM, _MOST_MM))
    return _Found(number, (lost, at), float(gains[best]))
