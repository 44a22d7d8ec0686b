"""Recordings as a file with our own columns: what was read of other people's, written so that it is read without a mapping."""

from __future__ import annotations

from math import isnan
from typing import IO, TYPE_CHECKING

import numpy as np

from coast_cli.errors import UsageError
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun, Recordings, ResponseKind, ShapeRun

    Floats = NDArray[np.float64]

RESPONSES: dict[ResponseKind, tuple[str, float]] = {
    "curvature": ("curvature_per_m", 1.0),
    "bend": ("bend_deg", DEGREE),
    "notch": ("notch_{}_deg", DEGREE),
    "position": ("position_mm", MILLIMETRE),
    "force": ("force_n", 1.0),
}
DIGITS = "%.12g"


def write_recordings(recordings: Recordings, stream: IO[str]) -> None:
    """Write all runs as one CSV file with our columns; a dropped response is an empty cell.

    Raises:
        UsageError: the runs have different columns, which one file cannot hold.
    """
    joint = recordings.joint.runs if recordings.joint else ()
    shape = recordings.shape.runs if recordings.shape else ()
    columns = [*map(_joint_columns, joint), *map(_shape_columns, shape)]
    header = list(columns[0])
    for name, own in zip(recordings.run_names, columns, strict=True):
        if list(own) != header:
            differs = ", ".join(sorted({*own} ^ {*header}))
            raise UsageError(f"runs {recordings.run_names[0]} and {name} differ in {differs}; convert them apart.")
    stream.write(",".join(header) + "\n")
    for own in columns:
        stream.writelines(",".join(row) + "\n" for row in zip(*own.values(), strict=True))


def _shape_columns(run: ShapeRun) -> dict[str, list[str]]:
    names = {"run": run.name, "outer": run.outer or "", "middle": run.middle or "", "natural": run.natural or ""}
    return _repeated(names, len(run)) | {"x_mm": _texts(run.x / MILLIMETRE), "y_mm": _texts(run.y / MILLIMETRE)}


def _joint_columns(run: JointRun) -> dict[str, list[str]]:
    names = {"run": run.name} | ({"outer": run.outer or "", "middle": run.middle} if run.middle else {})
    name, unit = RESPONSES[run.kind]
    values: dict[str, Floats | None] = {
        "time_s": run.time,
        "bending_length_mm": None if np.isnan(run.bending_length).all() else run.bending_length / MILLIMETRE,
        "stroke_mm": None if run.stroke is None else run.stroke / MILLIMETRE,
        "tension_n": run.tension,
        **{name.format(index): column / unit for index, column in enumerate(run.response.T, start=1)},
        "load_n": run.load,
        "load_n_m": run.load_moment,
    }
    return _repeated(names, len(run)) | {name: _texts(one) for name, one in values.items() if one is not None}


def _repeated(texts: dict[str, str], count: int) -> dict[str, list[str]]:
    return {name: [_cell(text)] * count for name, text in texts.items()}


def _texts(values: Floats) -> list[str]:
    return ["" if isnan(value) else DIGITS % value for value in values.tolist()]


def _cell(text: str) -> str:
    """Return a text as a cell: quoted where it must be, and never a formula of a spreadsheet."""
    guarded = f"'{text}" if text[:1] in "=+-@" and text else text
    return '"' + guarded.replace('"', '""') + '"' if any(mark in guarded for mark in ',;"\n\r\t') else guarded
