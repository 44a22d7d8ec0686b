"""Errors of a model on runs, as figures: of the response, of the tip, of the tension."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.problem import Problem
from coast_cli.effects.effect import Effect
from coast_cli.effects.forward import Prediction
from coast_cli.mechanics.joint import tip
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.model import JointRun
from coast_cli.units import DEGREE, MILLIMETRE

UNITS = {"curvature": "curvature_per_m", "bend": "bend_deg", "notch": "notch_deg"}


@dataclass(frozen=True, slots=True)
class Errors:
    """RMS errors: of the response in its table unit, of the tip in mm; and over how many samples."""

    count: int
    response: float
    tip_mm: float


def to_unit(kind: str, value: float) -> float:
    """Return an SI response as its table unit: 1/m, or degrees."""
    return value if kind == "curvature" else value / DEGREE


def errors_of(
    problem: Problem, coordinates: FloatArray, effects: Sequence[Effect], rows: Sequence[NDArray[np.bool_]]
) -> Errors:
    """Return the errors of a model on the given rows of every run, outliers and dropped frames left out."""
    return pooled_errors(problem, problem.predict(coordinates, effects), rows)


def held_out_spread(problem: Problem, fitted: Fit, rows: Sequence[NDArray[np.bool_]]) -> float:
    """Return how far predictions on some rows are unsure because the fitted parameters are, RMS in the table's unit."""
    whole = problem.only(rows)
    origin, _ = whole.fitted(whole.predict(fitted.coordinates, fitted.effects))
    columns = []
    for place, std in enumerate(np.sqrt(np.maximum(np.diagonal(fitted.covariance), 0.0))):
        step = 0.1 * float(std)
        coordinates, effects = _stepped(fitted, place, step)
        moved, _ = whole.fitted(whole.predict(coordinates, effects))
        columns.append((moved - origin) / step if step > 0.0 else np.zeros_like(origin))
    tangents = np.stack(columns, axis=1)
    variance = np.einsum("ij,jk,ik->i", tangents, fitted.covariance, tangents)
    return to_unit(problem.runs[0].kind, float(np.sqrt(np.mean(np.maximum(variance, 0.0)))))


def _stepped(fitted: Fit, place: int, step: float) -> tuple[FloatArray, tuple[Effect, ...]]:
    """Return the fit's base coordinates and effects with one of all its parameters moved, inside its range."""
    coordinates = fitted.coordinates.copy()
    if place < coordinates.size:
        coordinates[place] += step
        return coordinates, fitted.effects
    place -= coordinates.size
    effects = list(fitted.effects)
    for index, effect in enumerate(effects):
        if place < len(effect.parameters):
            parameter = effect.parameters[place]
            value = float(np.clip(getattr(effect, parameter.name) + step, parameter.low, parameter.high))
            effects[index] = replace(effect, **{parameter.name: value})
            break
        place -= len(effect.parameters)
    return coordinates, tuple(effects)


def pooled_errors(problem: Problem, predictions: Sequence[Prediction], rows: Sequence[NDArray[np.bool_]]) -> Errors:
    """Return the errors of given predictions; see ``errors_of``."""
    response, tips = [], []
    for run, prediction, wanted, usable in zip(problem.runs, predictions, rows, problem.usable, strict=True):
        use = usable & wanted[:, np.newaxis]
        response.append((prediction.response - run.response)[use])
        whole = np.all(use, axis=1)
        pitch = float(np.mean(problem.joints[run.pair].middle.pitch))
        x, y = tip_of(run, prediction.response[whole], run.bending_length[whole], pitch)
        seen_x, seen_y = tip_of(run, run.response[whole], run.bending_length[whole], pitch)
        tips.append(np.hypot(x - seen_x, y - seen_y))
    error, distance = np.concatenate(response), np.concatenate(tips)
    kind = problem.runs[0].kind
    return Errors(
        count=int(error.size),
        response=to_unit(kind, _rms(error)),
        tip_mm=_rms(distance) / MILLIMETRE,
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


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0
