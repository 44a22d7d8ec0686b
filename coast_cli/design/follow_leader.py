"""The body of a COAST robot along a planar path: straight, one bend of constant curvature, straight; and where it bends.

Following the leader, every part of the body passes where the tip passed before it: the bend keeps its curvature and its
place and only grows. So what the robot does along a path is one curve, cut off at each feed, and is off the path at an arc
length by the same distance however far the tip has gone on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from coast_cli.mechanics.joint import tip
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.planar_path import PlanarPath

_CANDIDATES, _POINTS = 40, 257  # places that a bend may begin or end at first, and arc lengths that are compared
_SAME = 1e-8  # m; bodies this near are the same
_SHARPER = 2.0  # how many times as sharply as the path a body may bend, so that a kink is no answer
_STEPS = 300  # of the simplex, at most
_PLACES = 12  # of a distance in m; the rest is rounding error
_PARTS = 256  # a path is shortened by steps of this part of it


@dataclass(frozen=True, slots=True)
class Body:
    """A body that leaves the origin along +x: straight to ``start`` (m), bent over ``bend`` (m) to ``curvature`` (1/m)."""

    start: float
    bend: float
    curvature: float

    def bent(self, feed: FloatArray) -> FloatArray:
        """Return how long the bend is (X2, m) at each feed (m)."""
        return np.clip(feed - self.start, 0.0, self.bend)

    def beyond(self, feed: FloatArray) -> FloatArray:
        """Return how far the outer tube is fed on beyond the bend (X3, m) at each feed (m)."""
        return np.maximum(feed - self.start - self.bend, 0.0)

    def place(self, along: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x, y (m) at arc lengths (m)."""
        x, y = _place(np.asarray(self.start), np.asarray(self.bend), np.asarray(self.curvature), along)
        return x, y

    def distance(self, path: PlanarPath, along: FloatArray) -> FloatArray:
        """Return how far the body is off a path (m) at equal arc lengths (m)."""
        at_x, at_y = path.place_at(along)
        x, y = self.place(along)
        return np.hypot(x - at_x, y - at_y)


def deviation(path: PlanarPath, body: Body, feed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the largest and the RMS distance (m) of the body from the path over its arc length, at each feed (m)."""
    distance = body.distance(path, path.arc_length)
    squared = distance**2
    summed = np.cumsum(0.5 * (squared[1:] + squared[:-1]) * np.diff(path.arc_length))
    over = np.interp(feed, path.arc_length, np.concatenate(([0.0], summed)))
    mean = np.divide(over, feed, out=np.zeros_like(feed), where=feed > 0.0)
    largest = np.interp(feed, path.arc_length, np.maximum.accumulate(distance))
    return np.round(largest, _PLACES), np.asarray(np.round(np.sqrt(mean), _PLACES), dtype=float)


def follow_path(path: PlanarPath, longest: float, within: float, *, extends: bool) -> tuple[Body, float]:
    """Return the body that follows a path as far as it can, and how far along that is, m.

    That is the body with the smallest largest distance from the whole path, or, where this is more than ``within`` (m),
    from the longest part of it that some body follows, found by halving; a shorter part is never harder.

    Args:
        longest: the most that the bend may be, m. extends: whether an outer tube can be fed on beyond it.
    """
    best = nearest_body(path, longest, extends=extends)
    if _largest(path, best) <= within:
        return best, path.length
    low, high = 0, path.arc_length.size - 1
    best = Body(path.length, 0.0, 0.0)
    while high - low > path.arc_length.size // _PARTS:
        middle = (low + high) // 2
        part = _part(path, middle)
        body = nearest_body(part, longest, extends=extends)
        if _largest(part, body) <= within:
            low, best = middle, body
        else:
            high = middle
    distance = best.distance(path, path.arc_length)
    off = np.flatnonzero(distance > within)
    return best, float(path.arc_length[max(off[0] - 1, 0)]) if off.size else path.length


def nearest_body(path: PlanarPath, longest: float, *, extends: bool) -> Body:
    """Return the body with the smallest largest distance from a path, bent at most twice as sharply as the path.

    A survey over both ends of the bend, the curvature by linear least squares in the tangent's angle; from the nearest,
    Nelder and Mead's simplex on the mean square distance, then on the largest. Of bodies that are equally near the one
    whose bend starts last and is shortest.
    """
    along = np.linspace(0.0, path.length, _POINTS)
    first, distance = _survey(path, longest, along[::4], extends=extends)
    if distance <= _SAME:
        return first
    return _refined(path, first, longest, along, extends=extends)


def _part(path: PlanarPath, last: int) -> PlanarPath:
    """Return the path up to one of its samples."""
    fine = {name: getattr(path, name)[: last + 1] for name in ("arc_length", "angle", "curvature", "x", "y")}
    end = fine["arc_length"][-1]
    return replace(path, rows=np.append(path.rows[path.rows < end], end), **fine)


def _largest(path: PlanarPath, body: Body) -> float:
    return float(body.distance(path, path.arc_length).max())


def _survey(path: PlanarPath, longest: float, along: FloatArray, *, extends: bool) -> tuple[Body, float]:
    """Return the nearest of the bodies that begin and end their bend at chosen places, and its RMS distance (m)."""
    rows = path.rows[:: max(1, -(-path.rows.size // _CANDIDATES))]
    places = np.union1d(np.append(rows, path.length), np.linspace(0.0, path.length, _CANDIDATES))
    start, end = (grid.ravel() for grid in np.meshgrid(places, places, indexing="ij"))
    last = np.minimum(start + longest, path.length)
    kept = (end >= start) & (end <= last) if extends else end == path.length
    start, end = start[kept], np.minimum(end, last)[kept]
    bend = end - start
    turn = np.clip(along - start[:, None], 0.0, bend[:, None])
    square = np.sum(turn**2, axis=1)
    curvature = np.divide(turn @ path.angle_at(along), square, out=np.zeros_like(square), where=square > 0.0)
    sharpest = _SHARPER * float(np.abs(path.curvature).max())
    curvature = np.clip(curvature, -sharpest, sharpest)
    at_x, at_y = path.place_at(along)
    x, y = _place(start[:, None], bend[:, None], curvature[:, None], along)
    distance = np.sqrt(np.mean((x - at_x) ** 2 + (y - at_y) ** 2, axis=1))
    chosen = np.lexsort((bend, -start, distance > distance.min() + _SAME))[0]
    found = Body(float(start[chosen]), float(bend[chosen]), float(f"{curvature[chosen]:.9g}"))
    return found, float(distance[chosen])


def _refined(path: PlanarPath, first: Body, longest: float, along: FloatArray, *, extends: bool) -> Body:
    from scipy.optimize import minimize

    sharpest = _SHARPER * float(np.abs(path.curvature).max())
    scale = np.array([path.length, path.length, sharpest])

    def body(values: FloatArray) -> Body:
        start = float(np.clip(values[0], 0.0, 1.0)) * path.length
        last = min(longest, path.length - start)
        bend = float(np.clip(values[1] * path.length, 0.0, last)) if extends else last
        return Body(start, bend, float(np.clip(values[2], -1.0, 1.0)) * sharpest)

    at_x, at_y = path.place_at(along)

    def squared(values: FloatArray) -> FloatArray:
        x, y = body(values).place(along)
        return np.asarray(((x - at_x) ** 2 + (y - at_y) ** 2) / path.length**2)

    def mean_square(values: FloatArray) -> float:
        return float(np.mean(squared(values)))

    def largest(values: FloatArray) -> float:
        return float(np.sqrt(np.max(squared(values))))

    found = np.array([first.start, first.bend, first.curvature]) / scale
    for aim, size in ((mean_square, 0.1), (largest, 0.02)):
        simplex = found + np.vstack([np.zeros(3), size * np.diag(np.where(found > 0.5, -1.0, 1.0))])
        options: Any = {"initial_simplex": simplex, "xatol": 1e-7, "fatol": 1e-12, "maxiter": _STEPS}
        found = minimize(aim, found, method="Nelder-Mead", options=options).x
    best = body(found)
    # What the simplex leaves open is cut off, so that any machine prints the same.
    return Body(round(best.start, 6), round(best.bend, 6), float(f"{best.curvature:.6g}"))


def _place(
    start: FloatArray, bend: FloatArray, curvature: FloatArray, along: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return x, y (m) of bodies at arc lengths (m); shapes broadcast."""
    x, y = tip(curvature, np.clip(along - start, 0.0, bend))
    beyond = np.maximum(along - start - bend, 0.0)
    angle = curvature * bend
    return np.minimum(along, start) + x + beyond * np.cos(angle), y + beyond * np.sin(angle)
