"""Planar beams ready to be solved: pieces, loads and clamps in frames whose downward direction is gravity's.

The only unknown of a beam is the angle of its tip: the moment there is known, so the march to the clamp needs nothing
else, and the clamp's angle is the one equation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, sin
from typing import TYPE_CHECKING, TypeAlias, Union

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam.step import (
    Number,
    segment_displacement,
    segment_tangent,
    segment_turn,
    segment_turn_short,
)
from coast_cli.mechanics.section import FloatArray

if TYPE_CHECKING:
    from coast_cli.mechanics.beam.periodic import PeriodicProblem

AnyProblem: TypeAlias = Union["BeamProblem", "PeriodicProblem"]
Piece = tuple[Number, Number, Number, Number]

Column = tuple[FloatArray, FloatArray, FloatArray]
_MOST_PARTS = 20_000  # of one piece
_FEW_TRIALS = 16


@dataclass(frozen=True)
class BeamProblem:
    """Pieces, shape (n, m), and loads, shape (m,), of m beams; pieces go from clamp to tip.

    Attributes:
        length: of each piece, m. flexibility: length/B, 1/(N m). bend: natural turn, rad. load: weight, N.
        thrust: tip force across gravity, N. shear: tip force along gravity, N. moment: at the tip, N m.
        base: angle of the clamp from the horizontal of this frame, rad.
    """

    length: FloatArray
    flexibility: FloatArray
    bend: FloatArray
    load: FloatArray
    thrust: FloatArray
    shear: FloatArray
    moment: FloatArray
    base: FloatArray

    @property
    def count(self) -> int:
        """Number of beams."""
        return int(self.length.shape[1])

    @cached_property
    def pieces(self) -> Sequence[Piece]:
        """The pieces from tip to clamp: rows over the beams, or plain numbers if there is one beam."""
        columns = [self.length, self.flexibility, self.bend, self.load]
        rows = [column.ravel().tolist() if self.count == 1 else column for column in columns]
        return list(zip(*rows, strict=True))[::-1]

    @cached_property
    def tip_loads(self) -> tuple[Number, Number, Number]:
        """Thrust, shear and moment at the tip, plain numbers if there is one beam."""
        loads = (self.thrust, self.shear, self.moment)
        return tuple(load.item() for load in loads) if self.count == 1 else loads  # type: ignore[return-value]

    @cached_property
    def unloaded_tip_angle(self) -> FloatArray:
        """Angle of the tip without any force, rad: where the continuation starts."""
        angle: FloatArray = self.base + np.sum(self.bend + self.flexibility * self.moment, axis=0)
        return angle

    @cached_property
    def force_bound(self) -> FloatArray:
        """Largest size of the internal force on each piece, N: all that hangs beyond its clamp side."""
        beyond = self.shear + np.cumsum(self.load[::-1], axis=0)[::-1]
        bound: FloatArray = np.hypot(self.thrust, np.maximum(np.abs(beyond), np.abs(beyond - self.load)))
        return bound

    @cached_property
    def moment_bound(self) -> FloatArray:
        """No equilibrium has a larger internal moment than this on a piece, N m."""
        return np.abs(self.moment) + np.cumsum((self.length * self.force_bound)[::-1], axis=0)[::-1]

    @cached_property
    def load_number(self) -> FloatArray:
        """Integral of C P over the beam, C the compliance from the clamp, P the size of the internal force.

        Below 1 there is one equilibrium only: two would differ by a d with (B d')' + p d = 0, d(0) = d'(L) = 0 and
        |p| <= P, which the Green's function C(min(s, sigma)) then forbids. (A uniform column under its own weight
        buckles at 7.84/6 = 1.31.) Nor does any equilibrium turn the tip by more than this, rad, from the unloaded one.
        """
        compliance = np.cumsum(self.flexibility, axis=0) - self.flexibility / 2.0
        number: FloatArray = np.sum(compliance * self.length * self.force_bound, axis=0)
        return number

    def scaled(self, factor: Number) -> BeamProblem:
        """Return the same beam with every force times ``factor``; a moment at the tip stays."""
        return replace(self, load=self.load * factor, thrust=self.thrust * factor, shear=self.shear * factor)

    def parts(self, turn: float, moment: FloatArray) -> NDArray[np.int64]:
        """Return into how many equal pieces to cut each piece so that none turns by more than ``turn`` (rad).

        ``moment`` bounds the internal moment, N m, and broadcasts to the pieces. The force counts too, since a step's
        series runs in its square root: 2 sqrt(h^2 P/B).
        """
        by_force = 2.0 * np.sqrt(self.length * self.flexibility * self.force_bound)
        most = np.maximum(np.abs(self.bend) + self.flexibility * moment, by_force)
        parts: NDArray[np.int64] = np.ceil(np.max(most, axis=1, initial=0.0) / turn).astype(np.int64)
        return np.clip(parts, 1, _MOST_PARTS)

    @cached_property
    def whole_load(self) -> FloatArray:
        """Size of all forces, N."""
        force: FloatArray = np.hypot(self.thrust, self.shear) + np.sum(np.abs(self.load), axis=0)
        return force

    @property
    def piece_count(self) -> int:
        """Number of pieces."""
        return len(self.length)

    def turn_bounds(self, moment: FloatArray, force: FloatArray | None = None) -> FloatArray:
        """Return for each piece and beam what bounds its turn, as ``parts`` has it, shape (n, m), rad.

        Args:
            moment: bounds the internal moment, N m. force: the internal force, N; that of ``whole_load`` if left out.
        """
        by_force = 2.0 * np.sqrt(self.length * self.flexibility * (self.whole_load if force is None else force))
        bounds: FloatArray = np.maximum(np.abs(self.bend) + self.flexibility * moment, by_force)
        return bounds

    def divided(self, parts: NDArray[np.int64]) -> BeamProblem:
        """Return the same beams with piece i cut into ``parts[i]`` equal pieces."""
        if np.all(parts == 1):
            return self
        return self.changed(lambda column: np.repeat(column / parts[:, None], parts, axis=0))

    def picked(self, beams: NDArray[np.int64]) -> BeamProblem:
        """Return some of many beams."""
        return replace(
            self.changed(lambda column: column[:, beams]),
            **{name: getattr(self, name)[beams] for name in ("thrust", "shear", "moment", "base")},
        )

    def coarse(self, cells: int) -> BeamProblem:
        """Return a beam of about ``cells`` homogenised pieces, which bends alike.

        The new ends lie in the middle of every 2k-th piece, so that each cell of a periodic tube is symmetric; a tip
        angle of it errs by 1e-5 to 1e-4 rad on the reference tubes.
        """
        chosen = cell_ends(self.piece_count, cells)
        if chosen.size == 0:
            return self

        def merged(column: FloatArray) -> FloatArray:
            half, last = column[chosen] / 2.0, chosen[-1]
            cells = np.add.reduceat(column[:last], chosen[:-1], axis=0)
            return np.concatenate((half[:1], cells - half[:-1] + half[1:], half[-1:], column[last + 1 :]))

        return self.changed(merged)

    def ripple(self, cells: int) -> Ripple:
        """Return what homogenising into ``cells`` leaves out, for each piece of ``coarse``.

        The first pitch of a cell stands for its others: half a piece, the next, and half the one after.
        """
        chosen = cell_ends(self.piece_count, cells)
        if chosen.size == 0:
            return Ripple(*np.zeros((4, *self.length.shape)))
        found = Ripple(*np.zeros((4, self.piece_count - chosen[-1] + chosen.size, self.count)))
        first = chosen[:-1]
        columns = self.length, self.flexibility, self.load
        found.fill(
            slice(1, chosen.size),
            *((column[first] / 2.0, column[first + 1], column[first + 2] / 2.0) for column in columns),
        )
        return found

    def changed(self, change: Callable[[FloatArray], FloatArray]) -> BeamProblem:
        """Return the same loads on other pieces: ``change`` is applied to length, flexibility, bend and load."""
        names = ("length", "flexibility", "bend", "load")
        return replace(self, **{name: change(getattr(self, name)) for name in names})


@dataclass(frozen=True, slots=True)
class Ripple:
    """What varies within a pitch, shape (pieces, m), to second order in the pitch.

    The tangent of a notched tube waves about that of the homogenised one by the internal moment times a function F of
    the place, the shear force by a function W.

    Attributes:
        square: mean of F^2, 1/(N m)^2. product: mean of F W, 1/m.
        turned, pulled: the integrals of F (1/N) and W (N m) where cells end, less their means over a pitch.
    """

    square: FloatArray
    product: FloatArray
    turned: FloatArray
    pulled: FloatArray

    def fill(self, cells: slice, length: Column, turn: Column, weight: Column) -> None:
        """Find what varies from piece to piece of symmetric pitches, given by a half piece, a piece and a half piece."""
        whole = length[0] + length[1] + length[2]
        # From end to end both go up and down by as much, so that they are straight lines through zero in between.
        excess = turn[0] - (turn[0] + turn[1] + turn[2]) / whole * length[0]
        heavier = weight[0] - (weight[0] + weight[1] + weight[2]) / whole * length[0]
        inside = (length[0] * (length[0] / 3.0 + length[1] / 2.0) + length[1] * length[1] / 6.0) / whole
        self.square[cells], self.product[cells] = excess * excess / 3.0, excess * heavier / 3.0
        self.turned[cells], self.pulled[cells] = -excess * inside, -heavier * inside

    @property
    def pieces(self) -> Sequence[Piece]:
        """The rows from tip to clamp, plain numbers if there is one beam."""
        columns = [getattr(self, name) for name in self.__slots__]
        rows = [column.ravel().tolist() if column.shape[1] == 1 else column for column in columns]
        return list(zip(*rows, strict=True))[::-1]

    def picked(self, beams: NDArray[np.int64]) -> Ripple:
        """Return that of some of many beams."""
        return Ripple(*(getattr(self, name)[:, beams] for name in self.__slots__))

    def divided(self, parts: NDArray[np.int64]) -> Ripple:
        """Return the same where piece i is cut into ``parts[i]`` equal pieces."""
        return Ripple(*(np.repeat(getattr(self, name), parts, axis=0) for name in self.__slots__))


class BeamTrace:
    """What a march passes: rows over the nodes from clamp to tip, shape (n + 1, m).

    Attributes:
        turn: angle at the node less the tip's, rad. moment: N m. x, y: places from the tip, m.
        slope: derivative of the angle by the tip's.
    """

    def __init__(self, problem: BeamProblem) -> None:
        shape = (problem.length.shape[0] + 1, problem.count)
        self.turn, self.moment, self.x, self.y, self.slope = (np.zeros(shape) for _ in range(5))
        self.moment[-1], self.slope[-1] = problem.moment, 1.0


def march(problem: BeamProblem, cosine: Number, sine: Number) -> tuple[Number, Number]:
    """March from the tip, whose tangent is (cosine, sine), to the clamp.

    Returns:
        The turn from tip to clamp, rad, and the derivative of the clamp's angle by the tip's. The turn has the order of
        the step; the derivative serves Newton's method and is good to about 1e-6.
    """
    thrust, shear, moment = problem.tip_loads
    total = 0.0 * cosine
    slope, moment_slope = total + 1.0, total
    for length, flexibility, bend, load in problem.pieces:
        turn, cosine, sine, moment, forces, series = segment_turn(
            length, flexibility, bend, load, thrust, cosine, sine, moment, shear
        )
        slope, moment_slope = segment_tangent(length, flexibility, forces, series, slope, moment_slope)
        shear = shear + load
        total = total + turn
    return total, slope


def march_turn(problem: BeamProblem, cosine: Number, sine: Number) -> Number:
    """Return only the turn from tip to clamp, rad: a march without the derivative."""
    thrust, shear, moment = problem.tip_loads
    total = 0.0 * cosine
    for length, flexibility, bend, load in problem.pieces:
        turn, cosine, sine, moment, _, _ = segment_turn(
            length, flexibility, bend, load, thrust, cosine, sine, moment, shear
        )
        shear = shear + load
        total = total + turn
    return total


def march_rippled(
    problem: BeamProblem, ripple: Ripple, tip_angle: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """March a homogenised beam from its tip angles (rad), with what homogenising left out to first order.

    With s from clamp to tip, m' = g = v cos(theta) + f sin(theta) and g' its derivative by theta, means over a pitch add
    -g' m <F^2> + cos(theta) <F W> to theta' and -g m^2 <F^2>/2 + sin(theta) m <F W> to m'. Where cells end, the means
    differ from angle and moment by g G and g' m G + cos(theta) H, with G and H the integrals of F and W.

    Returns:
        By how much the clamp is missed, rad, the derivative by the tip's angle, and the largest internal moment, N m.
    """
    thrust, shear, moment = problem.tip_loads
    cosine, sine = rotation(problem, tip_angle)
    total, moments = 0.0 * cosine, [moment]
    slope, moment_slope, off, moment_off = total + 1.0, total, total, total

    def waves(
        half_length: Number, square: Number, product: Number, turned: Number, pulled: Number
    ) -> tuple[Number, Number]:
        """Return what a half piece adds to angle and moment on the way to its middle."""
        along, across = shear * cosine + thrust * sine, thrust * cosine - shear * sine
        bent = product * cosine - across * moment * square
        lifted = moment * (product * sine - along * moment * square / 2.0)
        return along * turned - half_length * bent, moment * across * turned + cosine * pulled - half_length * lifted

    for (length, flexibility, bend, load), wave in zip(problem.pieces, ripple.pieces, strict=True):
        change, pull = waves(0.5 * length, *wave)
        off, moment_off = off + change, moment_off + pull
        turn, cosine, sine, moment, forces, series = segment_turn(
            length, flexibility, bend, load, thrust, cosine, sine, moment, shear
        )
        slope, moment_slope = segment_tangent(length, flexibility, forces, series, slope, moment_slope)
        off, moment_off = segment_tangent(length, flexibility, forces, series, off, moment_off)
        shear, total = shear + load, total + turn
        change, pull = waves(-0.5 * length, *wave)
        off, moment_off = off - change, moment_off - pull
        moments.append(moment)
    largest: FloatArray = np.max(np.abs(np.array(moments).reshape(len(moments), -1)), axis=0)
    return tip_angle + total + off - problem.base, np.atleast_1d(slope), largest


def cell_ends(count: int, cells: int) -> NDArray[np.int64]:
    """Return in the middle of which of ``count`` pieces cells end; none where there are too few pieces for cells."""
    if count <= 2 * cells:
        return np.zeros(0, dtype=np.int64)
    return np.array(sorted(set(np.linspace(0, (count - 1) // 2, cells).round().astype(int).tolist()))) * 2


def march_turns(
    problem: AnyProblem, tip_angle: FloatArray, turns_little: Sequence[bool]
) -> tuple[FloatArray, FloatArray]:
    """March from tip angles (rad), shape (m,), and correct to first order.

    Args:
        turns_little: pieces, from tip to clamp, for which a step of order 4 is enough.

    Returns:
        The turn of each piece from clamp to tip, rad, shape (n, m), and the correction of the tip angle, rad.
    """
    thrust, shear, moment = problem.tip_loads
    cosine, sine = rotation(problem, tip_angle)
    node = problem.piece_count
    turns, slopes = np.empty((node, problem.count)), np.ones((node + 1, problem.count))
    total = 0.0 * tip_angle
    slope, moment_slope = total + 1.0, total
    for (length, flexibility, bend, load), little in zip(problem.pieces, turns_little, strict=True):
        node -= 1
        step = segment_turn_short if little else segment_turn
        turns[node], cosine, sine, moment, forces, series = step(
            length, flexibility, bend, load, thrust, cosine, sine, moment, shear
        )
        slope, moment_slope = segment_tangent(length, flexibility, forces, series, slope, moment_slope)
        shear = shear + load
        total = total + turns[node]
        slopes[node] = slope
    change = (tip_angle + total - problem.base) / np.where(slope == 0.0, np.inf, slope)
    return np.diff(slopes, axis=0) * -change - turns, change


def march_shape(problem: BeamProblem, cosine: Number, sine: Number, trace: BeamTrace) -> tuple[Number, Number]:
    """March as ``march`` does and write every node into ``trace``."""
    thrust, shear, moment = problem.tip_loads
    total, x, y = 0.0 * cosine, 0.0, 0.0
    slope, moment_slope = total + 1.0, total
    node = problem.length.shape[0]
    for length, flexibility, bend, load in problem.pieces:
        turn, next_cosine, next_sine, moment, forces, series = segment_turn(
            length, flexibility, bend, load, thrust, cosine, sine, moment, shear
        )
        along_x, along_y = segment_displacement(length, cosine, sine, series)
        slope, moment_slope = segment_tangent(length, flexibility, forces, series, slope, moment_slope)
        cosine, sine, shear = next_cosine, next_sine, shear + load
        total, x, y = total + turn, x - along_x, y - along_y
        node -= 1
        trace.turn[node], trace.moment[node], trace.slope[node] = total, moment, slope
        trace.x[node], trace.y[node] = x, y
    return total, slope


def rotation(problem: AnyProblem, angle: FloatArray) -> tuple[Number, Number]:
    """Return cosine and sine of the beams' tip angles, as a march takes them."""
    if problem.count == 1 and angle.size == 1:
        return cos(angle.item()), sin(angle.item())
    return np.cos(angle), np.sin(angle)


def clamp_error(problem: BeamProblem, tip_angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return by how much a tip angle (rad) misses the clamp, rad, and the derivative: the one equation of a beam.

    ``tip_angle`` has the shape (..., m). A few trials of one beam go one by one: plain numbers are then faster.
    """
    if problem.count > 1 or tip_angle.size > _FEW_TRIALS:
        total, slope = march(problem, np.cos(tip_angle), np.sin(tip_angle))
    else:
        results = [march(problem, cos(angle), sin(angle)) for angle in tip_angle.ravel().tolist()]
        total, slope = np.reshape(np.transpose(results), (2, *tip_angle.shape))
    return tip_angle + total - problem.base, slope
