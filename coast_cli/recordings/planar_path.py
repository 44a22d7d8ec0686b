"""Read a planar path: a CSV file of arc length and signed curvature, or of points, as one curve in SI units.

Between rows of curvature it is a straight line, so that the tangent's angle is exact. Points are taken as exact and
joined by a cubic spline (not-a-knot) over the length of their chords; smooth measured ones before. Points in space are
turned into their plane where they have one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import BadInput, nearest
from coast_cli.recordings.path_plane import FLAT, in_plane
from coast_cli.recordings.table import Table, read_table
from coast_cli.rows import short_repr
from coast_cli.units import CURVATURE, LENGTH, MILLIMETRE

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Quantity -> its unit suffixes; the short names are those of formulas.
QUANTITIES: dict[str, Mapping[str, float]] = {
    "arc_length": LENGTH,
    "s": LENGTH,
    "curvature": CURVATURE,
    "kappa": CURVATURE,
    "x": LENGTH,
    "y": LENGTH,
    "z": LENGTH,
}
SAME = {"s": "arc_length", "kappa": "curvature"}
KINDS = (("arc_length", "curvature"), ("x", "y"))
ALLOWED = "arc_length_mm and curvature_per_m (or s_mm and kappa_per_mm), or x_mm and y_mm (and z_mm, in one plane)"
LONGEST, SHARPEST = 100.0, 1e5  # m, 1/m: past any robot
MOST_ROWS = 20_000
_PIECES = 4096  # of the curve, for lengths and places


@dataclass(frozen=True, eq=False)
class PlanarPath:
    """A path in its own frame: it starts at the origin along +x; arrays of (m,), SI.

    Attributes:
        source, digest: the file and the SHA-256 of its bytes.
        rows: arc length of each row of the file, from zero, (n,).
        arc_length, angle, curvature, x, y: fine samples; the angle is the tangent's, rad, curvature is positive to the left.
        roll: of its plane about its start, rad; 0 where left of the path is left in x and y.
        notes: how the file was read, where there is a choice.
    """

    __repr__ = short_repr

    source: str
    digest: str
    rows: Floats
    arc_length: Floats
    angle: Floats
    curvature: Floats
    x: Floats
    y: Floats
    roll: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Length of the path, m."""
        return float(self.rows[-1])

    def place_at(self, arc_length: Floats) -> tuple[Floats, Floats]:
        """Return x and y (m) at arc lengths (m) of any shape."""
        return self._at(arc_length, self.x), self._at(arc_length, self.y)

    def angle_at(self, arc_length: Floats) -> Floats:
        """Return the tangent's angle (rad) at arc lengths (m) of any shape."""
        return self._at(arc_length, self.angle)

    def curvature_at(self, arc_length: Floats) -> Floats:
        """Return the curvature (1/m) at arc lengths (m) of any shape."""
        return self._at(arc_length, self.curvature)

    def _at(self, arc_length: Floats, values: Floats) -> Floats:
        return np.asarray(np.interp(arc_length, self.arc_length, values))


def read_path(path: str | Path) -> PlanarPath:
    """Read a planar path: a CSV file of arc length and curvature, or of points, units in the names of its columns.

    Raises:
        BadInput: with file, line and column of the first thing that is wrong.

    Example:
        >>> coast.read_path("no-such.csv")
        Traceback (most recent call last):
        coast_cli.errors.BadInput: no-such.csv: cannot be read (No such file or directory).
    """
    table = read_table(path)
    columns, notes = _columns(table)
    if not 2 <= len(table.line) <= MOST_ROWS:
        raise table.error(f"a path of {len(table.line)} rows", row=0, allowed=f"2 to {MOST_ROWS}")
    if "curvature" in columns:
        return _of_curvature(table, columns, notes)
    return _of_points(table, columns, notes)


def path_of_curvature(arc_length: Floats, curvature: Floats, source: str = "", digest: str = "") -> PlanarPath:
    """Return the path of a curvature (1/m) given at increasing arc lengths (m), straight lines in between.

    Args:
        arc_length: m, (n,). curvature: 1/m, positive to the left, (n,).
        source, digest: what it came from, for provenance.

    Example:
        >>> path = coast.path_of_curvature(np.array([0.0, 0.02, 0.04]), np.array([0.0, 20.0, 20.0]))
        >>> round(path.angle[-1].item(), 3)
        0.6
    """
    rows = arc_length - arc_length[0]
    fine = np.union1d(np.linspace(0.0, rows[-1], _PIECES + 1), rows)
    kappa = np.interp(fine, rows, curvature)
    step = np.diff(fine)
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (kappa[1:] + kappa[:-1]) * step)))
    # Along one piece the angle is a parabola: Simpson's rule on its direction errs by the fifth power of the piece.
    middle = angle[:-1] + step * (3.0 * kappa[:-1] + kappa[1:]) / 8.0
    direction, halfway = np.exp(1j * angle), np.exp(1j * middle)
    place = np.concatenate(([0.0], np.cumsum(step * (direction[:-1] + 4.0 * halfway + direction[1:]) / 6.0)))
    return PlanarPath(source, digest, rows, fine, angle, kappa, place.real, place.imag)


def _of_curvature(table: Table, columns: Mapping[str, tuple[str, float]], notes: tuple[str, ...]) -> PlanarPath:
    along, kappa = (table.numbers(columns[name][0]) * columns[name][1] for name in KINDS[0])
    step = np.diff(along)
    if (step <= 0.0).any():
        row = 1 + int(np.argmax(step <= 0.0))
        raise table.error(
            "the arc length does not grow",
            name=columns["arc_length"][0],
            row=row,
            found=f"{along[row] * 1e3:g} mm after {along[row - 1] * 1e3:g} mm",
            allowed="rows in order, each further on",
        )
    if (np.abs(kappa) > SHARPEST).any():
        row = int(np.argmax(np.abs(kappa) > SHARPEST))
        raise table.error(
            "the curvature is out of range",
            name=columns["curvature"][0],
            row=row,
            found=f"{kappa[row]:g} 1/m",
            allowed=f"-{SHARPEST:g} to {SHARPEST:g} 1/m",
        )
    _refuse_long(table, float(along[-1] - along[0]))
    if along[0] != 0.0:
        notes += (f"{table.path}: the path starts at {along[0] * 1e3:g} mm; feed counts from there.",)
    found = path_of_curvature(along, kappa, table.path, table.digest)
    return replace(found, notes=notes)


def _of_points(table: Table, columns: Mapping[str, tuple[str, float]], notes: tuple[str, ...]) -> PlanarPath:
    from scipy.interpolate import CubicSpline

    names = [name for name in ("x", "y", "z") if name in columns]
    points = np.column_stack([table.numbers(columns[name][0]) * columns[name][1] for name in names])
    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if (chord == 0.0).any():
        raise table.error("two points coincide", row=1 + int(np.argmax(chord == 0.0)))
    if len(points) < 4:
        raise table.error(f"a path of {len(points)} points", row=0, allowed="at least four, for a spline through them")
    _refuse_long(table, float(chord.sum()))
    roll = 0.0
    if "z" in columns:
        points, roll, notes = _flat(table, points, columns["z"][0], notes)
    knots = np.concatenate(([0.0], np.cumsum(chord)))
    fine = np.union1d(np.linspace(0.0, knots[-1], _PIECES + 1), knots)
    spline = CubicSpline(knots, points)
    place, slope, turn = (spline(fine, order) for order in (0, 1, 2))
    speed = np.hypot(slope[:, 0], slope[:, 1])
    if speed.min() < 1e-6:
        raise table.error(
            "the spline through the points turns back on itself", allowed="points in order along the path"
        )
    curvature = (slope[:, 0] * turn[:, 1] - slope[:, 1] * turn[:, 0]) / speed**3
    angle = np.unwrap(np.arctan2(slope[:, 1], slope[:, 0]))
    halfway = np.hypot(*spline(0.5 * (fine[1:] + fine[:-1]), 1).T)
    pieces = np.diff(fine) * (speed[:-1] + 4.0 * halfway + speed[1:]) / 6.0
    along = np.concatenate(([0.0], np.cumsum(pieces)))
    turned = ((place[:, 0] - place[0, 0]) + 1j * (place[:, 1] - place[0, 1])) * np.exp(-1j * angle[0])
    rows = np.interp(knots, fine, along)
    notes += (f"{table.path}: curvature is that of a cubic spline through {len(points)} points, taken as exact.",)
    found = PlanarPath(
        table.path, table.digest, rows, along, angle - angle[0], curvature, turned.real.copy(), turned.imag.copy()
    )
    return replace(found, notes=notes, roll=roll)


def _flat(table: Table, points: Floats, name: str, notes: tuple[str, ...]) -> tuple[Floats, float, tuple[str, ...]]:
    """Return points in space as points of their plane, its roll (rad) and what to say of it."""
    plane, roll, off = in_plane(points)
    if off.max() > FLAT:
        raise table.error(
            "the path leaves the plane of its start, and the robot bends in one plane",
            name=name,
            row=int(np.argmax(off > FLAT)),
            found=f"{off.max() / MILLIMETRE:.3g} mm at most",
            allowed=f"points within {FLAT / MILLIMETRE:g} mm of one plane, whose roll is then in roll_deg",
        )
    note = f"{table.path}: its points lie within {max(off.max(), 1e-9) / MILLIMETRE:.1g} mm of one plane"
    return plane, roll, (*notes, f"{note}, rolled by {np.degrees(roll):.4g} degrees.")


def _refuse_long(table: Table, length: float) -> None:
    if length > LONGEST:
        raise table.error(
            "the path is too long",
            row=len(table.line) - 1,
            found=f"{length:g} m",
            allowed=f"at most {LONGEST:g} m",
            hint="Is the unit in the header right?",
        )


def _columns(table: Table) -> tuple[dict[str, tuple[str, float]], tuple[str, ...]]:
    """Return quantity -> (name in the file, factor to SI), and notes on columns that are not used."""
    found: dict[str, tuple[str, float]] = {}
    wrong: list[tuple[str, str]] = []
    unknown: list[str] = []
    for name in table.names:
        quantity, rest = _parse(name)
        if quantity is None:
            unknown.append(name)
        elif rest not in QUANTITIES[quantity]:
            wrong.append((name, quantity))
        else:
            key = SAME.get(quantity, quantity)
            if key in found:
                raise table.error(
                    f"{key} stands in two columns", found=f"{found[key][0]}, {name}", allowed="one of them"
                )
            found[key] = name, QUANTITIES[quantity][rest]
    kind = next((kind for kind in KINDS if set(kind) <= set(found)), None)
    if kind is None:
        raise _no_path(table, found, wrong, unknown)
    if kind == KINDS[0] and "z" in found:
        allowed = "points x_mm, y_mm and z_mm, or no z"
        raise table.error("a path of curvature has no z", name=found["z"][0], allowed=allowed)
    used = (*kind, "z") if "z" in found else kind
    spare = [*unknown, *(name for name, _ in wrong), *(name for key, (name, _) in found.items() if key not in used)]
    known = [quantity + suffix for quantity in QUANTITIES for suffix in QUANTITIES[quantity]]
    notes = (f"{table.path}: column {name!r} is not used. {nearest(name, known)}".rstrip() for name in spare if name)
    return {key: found[key] for key in used}, tuple(notes)


def _parse(name: str) -> tuple[str | None, str]:
    lower = name.lower()
    for quantity in QUANTITIES:
        if lower == quantity or lower.startswith(f"{quantity}_"):
            return quantity, lower[len(quantity) :]
    return None, ""


def _no_path(table: Table, found: Mapping[str, object], wrong: list[tuple[str, str]], unknown: list[str]) -> BadInput:
    """Return what to say of a header without a whole path: a unit first, then a name that looks like a missing one."""
    if wrong:
        name, quantity = wrong[0]
        bare = name.lower() == quantity
        return table.error(
            f"{SAME.get(quantity, quantity)} {'without a unit' if bare else 'with a unit that is not known'}",
            name=name,
            allowed=" ".join(quantity + suffix for suffix in QUANTITIES[quantity]),
        )
    missing = [quantity for quantity in QUANTITIES if SAME.get(quantity, quantity) not in found]
    known = [quantity + suffix for quantity in missing for suffix in QUANTITIES[quantity]]
    hint = next((words for name in unknown if (words := nearest(name.lower(), known))), None)
    return table.error(
        "a column is missing" if found else "no path", found=", ".join(table.names), allowed=ALLOWED, hint=hint
    )
