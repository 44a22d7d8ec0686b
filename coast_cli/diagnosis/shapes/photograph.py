"""A recorded shape made ready: which tubes, which way up, and where along the tube each of its points lies.

A point tells where the tube passes, not which of its sections it is: points are placed by their own arc length, and only
what lies across the model's line counts. Two things are known better: the last point is the tip, unless the trace ends early
(``ends``), and a shape with the clamp and one point a pitch has its points on the middles of the rings. A trace may begin
after the clamp and have gaps: what is not seen is not counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from coast_cli.errors import BadInput
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.model import ShapeRun
    from coast_cli.spec.build import Design

_SMOOTH_DEGREE = 8
_POINTS_A_COEFFICIENT = 3
_BACKWARD = 6.0  # noise levels
_WIDEST_GAP = 0.5  # of the tube
_LENGTHS = (0.5, 1.35)  # recorded, from the clamp to the last point, over configured
_FEWEST = 3
_DOUBLED = 0.1  # of the points
_LATEST_START = 0.5  # of the tube
_RING_SPACING = 0.08  # of a pitch


@dataclass(frozen=True, eq=False)
class Photograph:
    """One recorded shape.

    Attributes:
        run: the recording.
        tubes: number (1 for the first of the file, outer tubes first) and tube of each, one or outer and middle.
        upward: +1 where the natural curvature of the tube, or of the outer one, points up, -1 down.
        at: arc length along the configured tube of each point, m, [n].
        placed: points whose place along the tube is known, [n]: all rings, or the tip alone.
        recorded_length: of the line through the points, m.
    """

    run: ShapeRun
    tubes: tuple[tuple[int, NotchedTube], ...]
    upward: float
    at: FloatArray
    placed: NDArray[np.bool_]
    recorded_length: float

    @property
    def length(self) -> float:
        """Of the overlap of its tubes, m."""
        return min(tube.length for _, tube in self.tubes)

    @property
    def shows_tip(self) -> bool:
        """Whether the last point is taken for the tip."""
        return bool(self.placed[-1])

    @property
    def begins_at(self) -> float:
        """Arc length of the first point, m."""
        return float(self.at[0])

    def ending_early(self) -> Photograph:
        """Return the same where the last point is not the tip: points lie where they were seen, in the camera's scale."""
        at = np.clip(self.at * (self.recorded_length / self.length), 0.0, self.length)
        return replace(self, at=at, placed=np.zeros(len(self.run), dtype=bool))

    @property
    def is_pair(self) -> bool:
        """Whether two tubes are assembled."""
        return len(self.tubes) == 2


def photographs(design: Design, runs: Sequence[ShapeRun]) -> tuple[Photograph, ...]:
    """Return the shapes, checked.

    Raises:
        BadInput: points that are out of order, begin beyond the middle of the tube, of another length, or with x and y swapped.
    """
    numbers = {tube.name: place + 1 for place, tube in enumerate((*design.outer, *design.middle))}
    return tuple(_photograph(design, numbers, run) for run in runs)


def _photograph(design: Design, numbers: dict[str, int], run: ShapeRun) -> Photograph:
    tubes = tuple(
        (numbers[tube.name], tube) for tube in (design.tube(name) for name in (run.outer, run.middle) if name)
    )
    length = min(tube.length for _, tube in tubes)
    outer_names = {tube.name for tube in design.outer}
    usual = 1.0 if tubes[0][1].name in outer_names else -1.0
    upward = usual if run.natural is None else 1.0 if run.natural == "up" else -1.0
    _check(run, length)
    arc = arc_length(run.x, run.y)
    recorded = float(arc[-1])
    rings = _ring_middles(tubes, len(run))
    at = np.clip(arc * (length / recorded), 0.0, length)
    placed = np.zeros(len(run), dtype=bool)
    if rings is not None and _on_rings(arc, rings, length):
        at, placed = rings, np.ones(len(run), dtype=bool)
        recorded = recorded * length / float(rings[-1])
    else:
        placed[-1] = True
    _check_length(run, length, recorded)
    return Photograph(run, tubes, upward, at, placed, recorded)


def usual_sign(design: Design, tube: NotchedTube) -> float:
    """Return +1 for an outer tube, whose configured curvature is against gravity, -1 for a middle one."""
    return 1.0 if any(tube.name == other.name for other in design.outer) else -1.0


def arc_length(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the arc length from the clamp, at the origin and along +x, to each point, [n] m.

    Noise lengthens the chord from point to point; where points are many it is measured along a polynomial through them.
    Up to the first point the tube is an arc of a circle.
    """
    chord = _unseen_arc(float(x[0]), float(y[0])) + np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    if len(x) < _POINTS_A_COEFFICIENT * _SMOOTH_DEGREE:
        return np.asarray(chord)
    slopes = [np.polynomial.Chebyshev.fit(chord, values, _SMOOTH_DEGREE).deriv() for values in (x, y)]
    fine = np.linspace(chord[0], chord[-1], 8 * len(x))
    speed = np.hypot(slopes[0](fine), slopes[1](fine))
    along = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))))
    length: FloatArray = chord[0] + np.interp(chord, fine, along)
    return length


def _unseen_arc(x: float, y: float) -> float:
    """Return the length of the arc from the origin, along +x there, to a point."""
    half = float(np.arctan2(y, max(x, 1e-12)))
    return max(x, 0.0) / float(np.cos(half) * np.sinc(half / np.pi))


def _ring_middles(tubes: tuple[tuple[int, NotchedTube], ...], count: int) -> FloatArray | None:
    """Return the clamp and the middle of each ring, m, where there are as many points."""
    if len(tubes) != 1 or count != tubes[0][1].count + 1:
        return None
    tube = tubes[0][1]
    before = np.concatenate(([0.0], np.cumsum(tube.pitch)[:-1]))
    return np.concatenate(([0.0], before + tube.uncut / 2.0))


def _on_rings(arc: FloatArray, rings: FloatArray, length: float) -> bool:
    """Return whether points are spaced as evenly as rings and end on the last one rather than at the tip."""
    spacing = np.diff(arc[1:]) / np.diff(rings[1:])
    even = bool(np.std(spacing) < _RING_SPACING) and abs(float(np.mean(spacing)) - 1.0) < _RING_SPACING
    return even and abs(arc[-1] - rings[-1]) < abs(arc[-1] - length)


def _check(run: ShapeRun, length: float) -> None:
    """Refuse points that cannot be a tube from its clamp to its tip."""
    x, y = run.x, run.y
    if len(x) < _FEWEST:
        raise _refusal(run, -1, f"too few points for a shape, {len(x)}", f"{_FEWEST} or more, better 40")
    again = np.flatnonzero((np.diff(x) == 0.0) & (np.diff(y) == 0.0)) + 1
    if again.size > _DOUBLED * len(x):
        raise _refusal(run, int(again[0]), f"{again.size} points stand twice, one after the other", "each point once")
    first, last = float(np.hypot(x[0], y[0])), float(np.hypot(x[-1], y[-1]))
    if first > _LATEST_START * length:
        if last < first:
            raise _refusal(run, -1, "the points run from the tip to the clamp", "points ordered from the clamp")
        raise _refusal(run, 0, "the first point is not at the clamp", "the clamp at the origin, points from there on")
    step = np.hypot(np.diff(x), np.diff(y))
    usual = float(np.median(step))
    backward = _turned_back(x, y, usual)
    if backward is None and step.max() > max(_WIDEST_GAP * length, 3.0 * usual):
        row = int(np.argmax(step)) + 1
        raise _refusal(
            run, row, f"a gap of {step.max() / MILLIMETRE:.3g} mm between points", "points all along the tube"
        )
    if backward is not None:
        raise _refusal(
            run,
            backward,
            "the points go back and forth: out of order, or the line crosses itself",
            "points in order from the clamp to the tip",
        )
    early = max(3, int(np.searchsorted(np.cumsum(step), 0.1 * length)) + 1)
    rise = abs(float(np.mean(y[1:early]))), abs(float(np.mean(x[1:early])))
    if rise[0] > 2.5 * rise[1] and rise[0] > 0.01 * length:
        raise _refusal(
            run,
            1,
            "the shape leaves the clamp along y: x and y seem to be swapped",
            "x along the clamped tube, gravity along -y",
        )
    if x[early - 1] < 0.0 and abs(x[early - 1]) > 0.02 * length:
        raise _refusal(run, 1, "the shape leaves the clamp towards -x", "x along the clamped tube")


def _turned_back(x: FloatArray, y: FloatArray, usual: float) -> int | None:
    """Return the first point that lies behind the one before, or where an earlier one was, beyond what noise does."""
    count = len(x)
    if count < 6:
        return None
    window = max(2, count // 40)
    kernel = np.ones(2 * window + 1) / (2 * window + 1)
    padded = [np.pad(values, window, mode="reflect", reflect_type="odd") for values in (x, y)]
    smooth = [np.convolve(values, kernel, mode="valid") for values in padded]
    along = [np.gradient(values) for values in smooth]
    size = np.maximum(np.hypot(*along), 1e-300)
    noise = float(np.hypot(np.median(np.abs(x - smooth[0])), np.median(np.abs(y - smooth[1]))))
    forward = (np.diff(x) * along[0][:-1] + np.diff(y) * along[1][:-1]) / size[:-1]
    behind = np.flatnonzero(forward < -(_BACKWARD * noise + 0.5 * usual)) + 1
    apart = int(np.ceil(6.0 + (usual + _BACKWARD * noise) / max(float(np.median(size)), 1e-12)))
    distance = np.hypot(x[:, np.newaxis] - x, y[:, np.newaxis] - y)
    again = np.flatnonzero(np.any(np.tril(distance < usual, -apart), axis=1))
    first = [int(found[0]) for found in (behind, again) if found.size]
    return min(first) if first else None


def _check_length(run: ShapeRun, length: float, recorded: float) -> None:
    if not _LENGTHS[0] * length < recorded < _LENGTHS[1] * length:
        raise BadInput(
            f"the points of shape {run.name!r} are {recorded / MILLIMETRE:.4g} mm long and {run.pair} is "
            f"{length / MILLIMETRE:.4g} mm: another tube's shape, another unit, or not up to the tip",
            file=run.source,
            line=int(run.line[-1]),
            found=f"{recorded / length:.2f} of its length",
            allowed=f"{_LENGTHS[0]:g} to {_LENGTHS[1]:g}",
        )


def _refusal(run: ShapeRun, row: int, message: str, allowed: str) -> BadInput:
    found = f"({run.x[row] / MILLIMETRE:.4g}, {run.y[row] / MILLIMETRE:.4g}) mm"
    return BadInput(
        f"shape {run.name!r}: {message}", file=run.source, line=int(run.line[row]), found=found, allowed=allowed
    )
