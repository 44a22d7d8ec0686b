"""Errors of a model on runs, as figures: of the response, of the tip, of the tension."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from coast_cli.diagnosis.answer import Errors
from coast_cli.diagnosis.fit import Fit, rms
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.space import Booleans
from coast_cli.effects.effect import Effect
from coast_cli.effects.forward import Prediction
from coast_cli.mechanics.joint import tip
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.model import JointRun
from coast_cli.recordings.summary import UNITS as RESPONSE_UNITS
from coast_cli.units import MILLIMETRE

UNITS: Mapping[str, str] = {name: unit for name, (unit, _) in RESPONSE_UNITS.items()}
_SI: Mapping[str, float] = {name: size for name, (_, size) in RESPONSE_UNITS.items()}


def to_unit(kind: str, value: float) -> float:
    """Return an SI response in the unit of tables: 1/m, degrees, mm or N."""
    return value / _SI[kind]


def errors_of(
    problem: JointProblem, coordinates: FloatArray, effects: Sequence[Effect], rows: Sequence[Booleans]
) -> Errors:
    """Return the errors of a model on the given rows of every run, outliers and dropped frames left out."""
    return pooled_errors(problem, problem.predict(coordinates, effects), rows)


def held_out_spread(problem: JointProblem, fitted: Fit, rows: Sequence[Booleans]) -> float:
    """Return how far predictions on some rows are unsure because the fitted parameters are, RMS in the table's unit."""
    unseen = problem.only(rows)
    space = unseen.space(fitted.effects)
    vector = space.joined(fitted.coordinates)
    here = unseen.residuals([space.split(vector)])[0]
    slopes = space.jacobian(
        lambda vectors: unseen.residuals([space.split(one) for one in vectors]), vector, here, space.moving
    )[: unseen.observed.size]
    variance = np.einsum("ij,jk,ik->i", slopes, fitted.covariance, slopes)
    return to_unit(problem.runs[0].kind, float(np.sqrt(np.mean(np.maximum(variance, 0.0)))))


def pooled_errors(problem: JointProblem, predictions: Sequence[Prediction], rows: Sequence[Booleans]) -> Errors:
    """Return the errors of given predictions; see ``errors_of``."""
    response, tips = [], []
    for run, prediction, wanted, usable in zip(problem.runs, predictions, rows, problem.usable, strict=True):
        use = usable & wanted[:, np.newaxis]
        response.append((prediction.response - run.response)[use])
        if problem.device is not None:
            continue
        whole = np.all(use, axis=1)
        pitch = float(np.mean(problem.joints[run.pair].middle.pitch))
        x, y = tip_of(run, prediction.response[whole], run.bending_length[whole], pitch)
        seen_x, seen_y = tip_of(run, run.response[whole], run.bending_length[whole], pitch)
        tips.append(np.hypot(x - seen_x, y - seen_y))
    error = np.concatenate(response)
    kind = problem.runs[0].kind
    return Errors(
        count=int(error.size),
        response=to_unit(kind, rms(error)),
        tip_mm=rms(np.concatenate(tips)) / MILLIMETRE if tips else float("nan"),
    )


def tip_of(run: JointRun, response: FloatArray, length: FloatArray, pitch: float) -> tuple[FloatArray, FloatArray]:
    """Return the tip (m) that a response stands for: an arc, or a chain of notches in the middle of their pitches."""
    if run.kind == "notch":
        angle = np.cumsum(response, axis=1)
        before = angle - response
        x = np.sum(0.5 * pitch * (np.cos(before) + np.cos(angle)), axis=1)
        y = np.sum(0.5 * pitch * (np.sin(before) + np.sin(angle)), axis=1)
        return x, y
    value = response[:, 0]
    return tip(value / length if run.kind == "bend" else value, length)
