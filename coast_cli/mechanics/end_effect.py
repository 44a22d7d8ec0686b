"""The notch end effect: the extra cut length by which stress spreads from the strip to the full ring.

Beam theory ends the soft strip where the ring begins. In the solid the ring's corners stay idle over a length, so a
notch bends as if its cut were longer by delta: pitch/EI_eff = uncut/EI_1 + (cut + delta)/EI_2. P leaves it out. Delta
comes from a table of 3-D solid finite elements of one periodic cell in pure bending (examples/solid/cells.py wrote
end_effect.json beside this file), in outer radii over ri/ro, depth and uncut/ro, for radial walls and for flat cuts.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike

from coast_cli.mechanics.section import FloatArray, SectionKind

RELATIVE_ERROR = 0.006
"""Of delta, mesh and interpolation: root mean square over 120 cells solved apart on a finer mesh, cuts of 0.5 to 4 ro.

The worst errs 3 %: walls below 0.13 ro with rings above 4 ro feel the length of the cut, by 3 % from 2 to 8 ro.
"""

SHORTEST_CUT = 0.5
"""In outer radii. Below, the two ends of a cut feel each other: delta falls, by 3 % at a cut of 0.1."""


@dataclass(frozen=True, slots=True)
class EndEffectTable:
    """Delta / ro, shape (inner, depth, uncut), over three ascending axes; it is 0 at the first uncut length, 0."""

    inner_ratio: FloatArray
    depth: FloatArray
    uncut_ratio: FloatArray
    extra_cut_ratio: FloatArray


@cache
def end_effect_table(kind: SectionKind) -> EndEffectTable:
    """Read the frozen table of one kind of cut, "sector" or "chord"."""
    document = json.loads(files("coast_cli.mechanics").joinpath("end_effect.json").read_text(encoding="utf-8"))[kind]
    inner, depth, uncut, values = (
        np.array(document[key], dtype=float) for key in ("inner_ratio", "depth", "uncut_ratio", "extra_cut_ratio")
    )
    # a ring of no length cannot stiffen anything: delta = 0 exactly
    return EndEffectTable(inner, depth, np.append(0.0, uncut), np.pad(values, ((0, 0), (0, 0), (1, 0))))


def end_length(
    outer_radius: ArrayLike,
    inner_radius: ArrayLike,
    depth: ArrayLike,
    cut: ArrayLike,
    uncut: ArrayLike,
    kind: SectionKind = "sector",
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the extra cut length delta of every notch, m, and notes on what lies outside the table.

    Args:
        outer_radius, inner_radius, depth, cut, uncut: m; arrays broadcast.
        kind: "sector" for radial cut walls, "chord" for a straight cut.

    Accurate to RELATIVE_ERROR for a Poisson's ratio of 0.28 to 0.38. Outside the table the value at its edge is taken
    and a note says so; past the longest uncut length delta no longer changes, which needs no note.
    """
    ro, ri, d, c, u = np.broadcast_arrays(
        *(np.asarray(a, dtype=float) for a in (outer_radius, inner_radius, depth, cut, uncut))
    )
    table = end_effect_table(kind)
    inner, height = ri / ro, _depth_coordinate(ro, ri, d, kind)
    notes = (
        *_outside("ri/ro", inner, table.inner_ratio, inner),
        *_outside("depth/(2 ro)", height, table.depth, d / (2.0 * ro)),
    )
    if np.any(c < SHORTEST_CUT * ro):
        shortest = f"the shortest cut is {float(np.min(c / ro)):.3g} ro"
        note = f"end effect: {shortest}; the table holds from {SHORTEST_CUT:g} ro, and delta falls by 3 % at 0.1 ro"
        notes += (note,)
    return ro * interpolate(table, inner, height, u / ro), notes


def _depth_coordinate(ro: FloatArray, ri: FloatArray, depth: FloatArray, kind: SectionKind) -> FloatArray:
    """Return the table's depth axis: a flat cut meets the edge of the bore at 1, and past it the strip is solid."""
    if kind == "sector":
        return depth / (2.0 * ro)
    height = depth - ro
    return np.where(height <= ri, height / ri, 1.0 + (height - ri) / (ro - ri))


def _outside(name: str, values: FloatArray, axis: FloatArray, shown: FloatArray) -> tuple[str, ...]:
    beyond = (values < axis[0] - 1e-9) | (values > axis[-1] + 1e-9)
    if not np.any(beyond):
        return ()
    worst = float(shown[beyond].flat[0])
    return (f"end effect: {name} = {worst:.4g} lies outside the table of 3-D solids; the value at its edge is used",)


def interpolate(table: EndEffectTable, inner: FloatArray, depth: FloatArray, uncut: FloatArray) -> FloatArray:
    """Return delta / ro by local cubics, axis by axis, monotone wherever four table points are (Fritsch, Carlson 1980).

    Wall thickness and ring length enter by their logarithm, over which delta is smoothest.
    """
    axes = (-np.log(1.0 - table.inner_ratio), table.depth, np.log(table.uncut_ratio + 0.5))
    inner, uncut = np.clip(inner, 0.0, table.inner_ratio[-1]), np.clip(uncut, 0.0, table.uncut_ratio[-1])
    queries = (-np.log(1.0 - inner), depth, np.log(uncut + 0.5))
    values = table.extra_cut_ratio
    for number, axis in enumerate(axes):
        values = _with_ghosts(axis, values, number)
    stencils = [_stencil(axis, np.clip(query, axis[0], axis[-1])) for axis, query in zip(axes, queries, strict=True)]
    (i, x, p), (j, y, q), (k, z, r) = stencils
    cube = values[i[..., :, None, None], j[..., None, :, None], k[..., None, None, :]]
    square = _local_cubic(z[..., None, None, :], cube, r[..., None, None])
    row = _local_cubic(y[..., None, :], square, q[..., None])
    return _local_cubic(x, row, p)


def _stencil(axis: FloatArray, query: FloatArray) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """Return four neighbouring places on the axis with its ghosts, their coordinates, and the query."""
    first = np.clip(np.searchsorted(axis, query, side="right") - 1, 0, axis.size - 2)
    index = first[..., None] + np.arange(4)
    return index, _ghosted(axis)[index], query


def _ghosted(axis: FloatArray) -> FloatArray:
    return np.concatenate(([2.0 * axis[0] - axis[1]], axis, [2.0 * axis[-1] - axis[-2]]))


def _with_ghosts(axis: FloatArray, values: FloatArray, number: int) -> FloatArray:
    """Continue the table by one place at both ends of an axis, along the parabola through its last three."""
    v = np.moveaxis(values, number, 0)
    places = _ghosted(axis)
    ends = []
    for ghost, near in ((places[0], slice(0, 3)), (places[-1], slice(-3, None))):
        a, b, c = axis[near]
        weights = (
            (ghost - b) * (ghost - c) / ((a - b) * (a - c)),
            (ghost - a) * (ghost - c) / ((b - a) * (b - c)),
            (ghost - a) * (ghost - b) / ((c - a) * (c - b)),
        )
        ends.append(np.tensordot(weights, v[near], axes=1)[None])
    return np.moveaxis(np.concatenate((ends[0], v, ends[1])), 0, number)


def _local_cubic(x: FloatArray, v: FloatArray, query: FloatArray) -> FloatArray:
    """Return the cubic between the middle two of four places (last axis): parabola slopes, limited off a peak."""
    step = np.diff(x, axis=-1)
    secant = np.diff(v, axis=-1) / step
    before, after = secant[..., :-1], secant[..., 1:]
    slope = (before * step[..., 1:] + after * step[..., :-1]) / (step[..., 1:] + step[..., :-1])
    limit = 3.0 * np.minimum(np.abs(before), np.abs(after))
    slope = np.where(before * after > 0.0, np.clip(slope, -limit, limit), slope)
    h = step[..., 1]
    t = (query - x[..., 1]) / h
    return (
        v[..., 1] * (1.0 + 2.0 * t) * (1.0 - t) ** 2
        + v[..., 2] * t**2 * (3.0 - 2.0 * t)
        + h * t * (1.0 - t) * (slope[..., 0] * (1.0 - t) - slope[..., 1] * t)
    )
