"""Errors of a model on photographs, as figures: along the whole shape and at the tip."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from coast_cli.diagnosis.answer import Errors
from coast_cli.diagnosis.fit import Fit, rms
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.space import Booleans
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

UNIT = "shape_mm"


def shape_errors_of(
    problem: ShapeProblem, coordinates: FloatArray, effects: Sequence[Any], rows: Sequence[Booleans]
) -> Errors:
    """Return the errors of a model on the given points of every photograph."""
    state = problem.state(coordinates, effects)
    chosen = [index for index, wanted in enumerate(rows) if wanted.any()]
    shape, tips = [], []
    for index, line in zip(chosen, problem.forward.lines([(index, state) for index in chosen]), strict=True):
        run = problem.photographs[index].run
        distance = np.hypot(run.x - line.x[0], run.y - line.y[0])
        shape.append(distance[rows[index]])
        tips.append(distance[-1])
    distances = np.concatenate(shape) if shape else np.zeros(0)
    return Errors(distances.size, rms(distances) / MILLIMETRE, rms(np.array(tips)) / MILLIMETRE)


def expected_of(problem: ShapeProblem, fitted: Fit, rows: Sequence[Booleans], noise: float) -> float:
    """Return the RMS distance, mm, at which a right model is expected from points it was not fitted to.

    Noise of the points (m, along either axis) and, to first order, what fitted parameters leave open; numbers of tubes that
    no fitted photograph shows are taken as known.
    """
    chosen = [index for index, wanted in enumerate(rows) if wanted.any()]
    space = problem.space(fitted.effects)
    vector = space.joined(fitted.coordinates)
    moved = [vector]
    root = np.linalg.cholesky(fitted.covariance + 1e-12 * np.diag(space.spread**2))
    moved += [np.clip(vector + step, space.low, space.high) for step in root.T]
    states = [problem.state(*space.split(one)) for one in moved]
    lines = problem.forward.lines([(index, state) for state in states for index in chosen])
    variance = []
    for place, index in enumerate(chosen):
        here = lines[place]
        others = lines[place + len(chosen) :: len(chosen)]
        spread = sum((other.x[0] - here.x[0]) ** 2 + (other.y[0] - here.y[0]) ** 2 for other in others)
        variance.append((spread + np.zeros_like(here.x[0]))[rows[index]])
    return float(np.sqrt(2.0 * noise**2 + np.mean(np.concatenate(variance)))) / MILLIMETRE if chosen else 0.0
