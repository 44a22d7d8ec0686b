"""What is recorded, predicted and left, row by row with its time, as CSV: for who looks into errors with tools of their own."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from typing import IO, TYPE_CHECKING

import numpy as np

from coast_cli.output.csv import cell
from coast_cli.recordings.summary import UNITS
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.diagnosis.compare import JointErrors, ModelComparison, ShapeErrors
    from coast_cli.output.answer import Cell

NAMES = ("model", "run", "line", "time_s", "drive", "quantity", "recorded", "predicted", "residual")


def write_residuals(comparison: ModelComparison, stream: IO[str]) -> None:
    """Write a line for each recorded value; ``quantity`` says what it is and its unit, ``drive`` is in mm or N.

    Of a shape each point has two lines, x and y at equal arc length.
    """
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(NAMES)
    for name, one in comparison.models:
        for joint in one.joint:
            writer.writerows([cell(value) for value in row] for row in _of_joint(name, joint))
        for shape in one.shape:
            writer.writerows([cell(value) for value in row] for row in _of_shape(name, shape))


def _of_joint(model: str, one: JointErrors) -> Iterator[tuple[Cell, ...]]:
    run = one.run
    quantity, unit = UNITS[run.kind]
    drive = run.drive / (MILLIMETRE if run.stroke is not None else 1.0)
    times = [None] * len(run) if run.time is None else run.time.tolist()
    for column in range(run.response.shape[1]):
        name = quantity.replace("notch", f"notch_{column + 1}")
        seen, told = run.response[:, column] / unit, one.predicted[:, column] / unit
        rows = zip(run.line.tolist(), times, drive.tolist(), seen.tolist(), told.tolist(), strict=True)
        for line, time, at, recorded, predicted in rows:
            if np.isfinite(recorded):
                yield model, run.name, line, time, at, name, recorded, predicted, recorded - predicted


def _of_shape(model: str, one: ShapeErrors) -> Iterator[tuple[Cell, ...]]:
    run = one.run
    for name, seen, told in (("x_mm", run.x, one.x), ("y_mm", run.y, one.y)):
        points = zip(run.line.tolist(), (seen / MILLIMETRE).tolist(), (told / MILLIMETRE).tolist(), strict=True)
        for line, recorded, predicted in points:
            yield model, run.name, line, None, None, name, recorded, predicted, recorded - predicted
