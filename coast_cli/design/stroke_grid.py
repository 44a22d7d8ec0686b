"""Stroke tables for a controller: a grid of the joint model, and how far straight lines between its nodes are off.

The grid is that of one branch, load or release. Between nodes a controller interpolates on both axes (bilinear); the error is the
largest on a finer grid of the model itself, with a tenth more for what lies between its points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from coast_cli.design.stroke import StrokeTable, stroke_table
from coast_cli.effects.effect import Effect
from coast_cli.errors import UsageError
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

MOST_NODES = 100_000
_FINER = (16, 4)  # parts of a cell along the drive, which has a kink at the dead band, and along the length
_SPARE = 1.1
_SINGLE = 1e-6  # relative; rounding of the table and of a controller's own sums


@dataclass(frozen=True, eq=False)
class StrokeGrid:
    """A table over bending lengths (slowest) and curvatures or strokes.

    Attributes:
        drive_name, value_name: the axis and what the table has, with units: curvature_per_m and stroke_mm, or the reverse.
        bending_length_mm: (m,). drive: (n,), both rising. value: (m, n), as single precision numbers.
        steps: of the motor, (m, n) whole numbers; None without [actuator] or of curvatures.
        max_error: largest interpolation error, in the unit of the value. branch: load or release.
    """

    drive_name: str
    value_name: str
    bending_length_mm: FloatArray
    drive: FloatArray
    value: FloatArray
    steps: FloatArray | None
    max_error: float
    branch: str = "load"

    @property
    def told_error(self) -> str:
        """The largest error in words."""
        return f"{self.max_error:.3g} {'mm' if self.value_name == 'stroke_mm' else '1/m'}"

    @property
    def checksum(self) -> int:
        """CRC-32 of the table's bytes: little-endian single precision, bending length slowest."""
        return crc32(self.value.astype("<f4").tobytes())


@dataclass(frozen=True, slots=True)
class TableOrigin:
    """What a table was made for and from: the pair, the configuration's file and SHA-256, the motor's steps per mm."""

    pair: str
    source: str
    digest: str
    steps_per_mm: float | None


def stroke_grid(
    joint: Joint,
    bending_lengths: Sequence[float],
    *,
    curvatures: Sequence[float] = (),
    strokes: Sequence[float] = (),
    effects: Sequence[Effect] = (),
    steps_per_mm: float | None = None,
    release: bool = False,
) -> StrokeGrid:
    """Return the table of a joint; arguments as for ``stroke_table``, and the motor's steps for one mm of stroke.

    Raises:
        UsageError: axes that do not rise, too few or too many nodes, or a curvature that no pull holds.
    """
    inverse = bool(strokes)
    drive = np.asarray(strokes or curvatures, dtype=float)
    length = np.asarray(bending_lengths, dtype=float)
    _check(joint, drive, length)

    def values(lengths: FloatArray, drives: FloatArray) -> FloatArray:
        given = {"strokes": drives.tolist()} if inverse else {"curvatures": drives.tolist()}
        found: StrokeTable = stroke_table(joint, lengths.tolist(), effects=effects, release=release, **given)
        column = found.columns["curvature_per_m" if inverse else "stroke_mm"]
        return np.array([np.nan if value is None else value for value in column]).reshape(lengths.size, -1)

    table = values(length, drive)
    if np.isnan(table).any():
        row, place = np.argwhere(np.isnan(table))[0]
        raise UsageError(
            f"no pull holds {drive[place]:g} 1/m at X2 {length[row] / MILLIMETRE:g} mm, and a table for a controller has no "
            "gaps: give curvatures that the branch reaches."
        )
    rounded = table.astype(np.float32).astype(float)
    finer = _between(length, _FINER[1]), _between(drive, _FINER[0])
    off = np.abs(_bilinear(rounded, length, drive, *finer) - values(*finer))
    error = _SPARE * float(np.nanmax(off)) + _SINGLE * float(np.abs(table).max())
    known = None if inverse or steps_per_mm is None else np.rint(rounded * steps_per_mm)
    names = ("stroke_mm", "curvature_per_m") if inverse else ("curvature_per_m", "stroke_mm")
    axis = drive / MILLIMETRE if inverse else drive
    return StrokeGrid(*names, length / MILLIMETRE, axis, rounded, known, error, "release" if release else "load")


def _check(joint: Joint, drive: FloatArray, length: FloatArray) -> None:
    if joint.tendon is None:
        raise UsageError("a table for a controller is of strokes, and there is no [tendon].")
    if drive.size < 2 or np.any(np.diff(drive) <= 0.0) or np.any(np.diff(length) <= 0.0):
        raise UsageError(
            "a table for a controller needs two curvatures (or strokes) or more, and bending lengths, each above the last."
        )
    if drive.size * length.size > MOST_NODES:
        raise UsageError(f"a table of {drive.size * length.size} nodes: allowed: at most {MOST_NODES}.")


def _between(axis: FloatArray, parts: int) -> FloatArray:
    """Return an axis with each of its steps divided."""
    place = np.arange((axis.size - 1) * parts + 1) / parts
    return np.asarray(np.interp(place, np.arange(axis.size), axis))


def _bilinear(
    table: FloatArray, length: FloatArray, drive: FloatArray, lengths: FloatArray, drives: FloatArray
) -> FloatArray:
    along = np.stack([np.interp(drives, drive, row) for row in table])
    return np.stack([np.interp(lengths, length, column) for column in along.T], axis=1)
