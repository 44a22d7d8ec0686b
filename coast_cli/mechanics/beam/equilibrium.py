"""Tubes under gravity, solved in arc length: any tip angle, any number of notches, no angle picked by hand.

Source: equations (3)-(7) of P, "Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023), in
arc length instead of projected length: theta' = k0 - M/EI, M' = -V cos(theta), theta(0) = 0, M(L) = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np
from numpy.typing import ArrayLike, NDArray

from coast_cli.mechanics.beam.hanging import MOST_NUMBER
from coast_cli.mechanics.beam.periodic import PeriodicProblem
from coast_cli.mechanics.beam.problem import BeamProblem
from coast_cli.mechanics.beam.solve import solve_plain_turns, solve_problem
from coast_cli.mechanics.plausible import MODULUS, require
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.verdict import Verdict
from coast_cli.rows import short_repr

NO_EQUILIBRIUM = (
    "no equilibrium was reached from zero load: the beam is too soft for its load or its numbers overflow; "
    "give a stiffer, shorter or lighter beam, or less gravity"
)
_WORTH_COMPILING = 1000  # beams; below, loading numba takes longer than it saves


@dataclass(frozen=True)
class BeamSolution:
    """The equilibrium of one beam.

    Attributes:
        s: arc length of the piece ends from clamp to tip, m, shape (n + 1,).
        x, y: their places, m. angle: of the tangent, rad. moment: internal moment, N m. All of the shape of s.
        curvature: mean curvature of each piece, 1/m, shape (n,); times the piece's length it is exactly its turn.
        verdict: whether the solve converged, and what was found on the way.
    """

    __repr__ = short_repr

    s: FloatArray
    x: FloatArray
    y: FloatArray
    angle: FloatArray
    moment: FloatArray
    curvature: FloatArray
    verdict: Verdict

    @property
    def tip_angle(self) -> float:
        """Angle of the tangent at the tip, rad."""
        return float(self.angle[-1])


@dataclass(frozen=True)
class BeamSolutions:
    """The equilibria of m beams of n pieces; attributes as in ``BeamSolution`` with a first axis over beams.

    Attributes:
        converged: shape (m,). residual: what is left of the clamp's angle, rad. iterations: marches over the full beam.
        equilibria: how many equilibria were found under the full load; the one returned is reached from zero load.
        turned_at: share of the load at which the path from zero load turned back, so that the beam snaps; else 1.
        load_number: of the beams that are not converged: integral of compliance times force, 1.3 where a column buckles.
    """

    __repr__ = short_repr

    s: FloatArray
    x: FloatArray
    y: FloatArray
    angle: FloatArray
    moment: FloatArray
    curvature: FloatArray
    converged: NDArray[np.bool_]
    residual: FloatArray
    iterations: NDArray[np.int64]
    equilibria: NDArray[np.int64]
    turned_at: FloatArray
    load_number: FloatArray

    def verdict(self, beam: int) -> Verdict:
        """Return the verdict of one beam in words."""
        return Verdict(
            converged=bool(self.converged[beam]),
            message=_message(
                converged=bool(self.converged[beam]),
                equilibria=int(self.equilibria[beam]),
                turned_at=float(self.turned_at[beam]),
                load_number=float(self.load_number[beam]),
            ),
            iterations=int(self.iterations[beam]),
            residual=float(self.residual[beam]),
        )

    def beam(self, beam: int) -> BeamSolution:
        """Return the solution of one beam."""
        return BeamSolution(
            s=self.s[beam],
            x=self.x[beam],
            y=self.y[beam],
            angle=self.angle[beam],
            moment=self.moment[beam],
            curvature=self.curvature[beam],
            verdict=self.verdict(beam),
        )


@dataclass(frozen=True, slots=True)
class BeamTips:
    """Tips of m beams: angle (rad), x, y (m), whether converged and the clamp's residual (rad), each of shape (m,)."""

    __repr__ = short_repr

    angle: FloatArray
    x: FloatArray
    y: FloatArray
    converged: NDArray[np.bool_]
    residual: FloatArray


@dataclass(frozen=True, slots=True)
class BeamCurvatures:
    """Mean curvature of each piece of m beams, 1/m, shape (m, n), and whether each beam converged, shape (m,)."""

    curvature: FloatArray
    converged: NDArray[np.bool_]


def solve_beam(tube: NotchedTube, gravity: float) -> BeamSolution:
    """Return the equilibrium of a tube clamped along +x under gravity (m/s^2) along -y.

    The start is automatic. The tip agrees with 13-digit references within 1e-13 of the length, past 90 degrees too.

    Raises:
        BadInput: a modulus that is far from any material.

    Example:
        >>> design = coast.build(coast.load_config(coast.REFERENCE))
        >>> shape = coast.solve_beam(design.tube("MT3"), design.gravity)
        >>> round(shape.y[-1].item() * 1e3, 3), shape.verdict.message
        (-35.893, 'converged')
    """
    require(MODULUS, youngs_modulus=tube.youngs_modulus)
    return solve_beams((tube,), gravity).beam(0)


def solve_beams(tubes: Sequence[NotchedTube], gravity: float) -> BeamSolutions:
    """Return the equilibria of many tubes, each clamped along +x under gravity (m/s^2) along -y.

    Tubes with fewer notches are filled up with pieces of no length at the tip, where s, x, y and angle stay constant.
    """
    most = max(tube.segments.length.size for tube in tubes)

    def filled(column: Sequence[FloatArray], filler: float) -> FloatArray:
        table = np.full((len(column), most), filler)
        for row, values in zip(table, column, strict=True):
            row[: values.size] = values
        return table

    pieces = [tube.segments for tube in tubes]
    return solve_segments(
        filled([piece.length for piece in pieces], 0.0),
        filled([piece.rigidity for piece in pieces], 1.0),
        filled([piece.weight for piece in pieces], 0.0),
        np.array([tube.natural_curvature for tube in tubes])[:, None],
        gravity=(0.0, -gravity),
    )


def solve_segments(
    length: ArrayLike,
    rigidity: ArrayLike,
    weight: ArrayLike,
    natural_curvature: ArrayLike,
    *,
    gravity: ArrayLike = (0.0, 0.0),
    tip_force: ArrayLike = (0.0, 0.0),
    tip_moment: ArrayLike = 0.0,
    base_angle: ArrayLike = 0.0,
) -> BeamSolutions:
    """Return the equilibria of m planar inextensible beams of n constant pieces from clamp to tip.

    Args:
        length: of the pieces, m, >= 0. rigidity: flexural, N m^2, > 0. weight: mass per length, kg/m.
            natural_curvature: signed, 1/m, positive turning from x to y. Shapes that broadcast to (m, n).
        gravity: acceleration (x, y), m/s^2. tip_force: dead load at the tip (x, y), N. Shapes (2,) or (m, 2).
        tip_moment: dead moment at the tip, N m, positive from x to y. base_angle: of the clamped tangent from +x, rad.
            Shapes () or (m,).

    Returns:
        The solutions; places have the clamp at the origin. A beam that could not be solved says so in its verdict and
        carries its last trial, or zeros; nothing is raised and nothing is NaN.

    The step is of order 6; pieces are divided so that a step turns by at most 0.04 rad, which leaves 1e-12 of the
    length.

    Example:
        >>> hanging = coast.solve_segments([0.05], [1e-6], [1e-3], [0.0], gravity=(0.0, -9.81))
        >>> round(hanging.y[0, -1].item() * 1e3, 3)
        -7.525
    """
    loads = _loads(gravity, tip_force, tip_moment, base_angle)
    pieces = _broadcast(loads.turned[:, None], length, rigidity, weight, natural_curvature)
    loads = loads.broadcast(pieces[0].shape[0])
    rows = [np.ascontiguousarray(column.T) for column in pieces]
    with np.errstate(all="ignore"):  # what overflows is refused by its verdict
        problem = BeamProblem(
            length=rows[0],
            flexibility=rows[0] / rows[1],
            bend=rows[0] * rows[3],
            load=rows[0] * rows[2] * loads.pull,
            thrust=loads.thrust,
            shear=loads.shear,
            moment=loads.moment,
            base=loads.base,
        )
        solved = solve_problem(problem)
        angle = solved.angle + loads.turned
        x, y = loads.unturned(solved.x, solved.y)
        nodes = np.concatenate((np.zeros((1, rows[0].shape[1])), np.cumsum(rows[0], axis=0)))
        curvature = np.diff(angle, axis=0) / np.where(rows[0] == 0.0, 1.0, rows[0])
    return BeamSolutions(
        s=nodes.T,
        x=x.T,
        y=y.T,
        angle=angle.T,
        moment=solved.moment.T,
        curvature=curvature.T,
        converged=solved.converged,
        residual=solved.residual,
        iterations=solved.steps,
        equilibria=solved.equilibria,
        turned_at=solved.turned_at,
        load_number=solved.load_number,
    )


def solve_tips(
    length: ArrayLike,
    rigidity: ArrayLike,
    weight: ArrayLike,
    natural_curvature: ArrayLike,
    *,
    gravity: ArrayLike = (0.0, 0.0),
    tip_force: ArrayLike = (0.0, 0.0),
    tip_moment: ArrayLike = 0.0,
    base_angle: ArrayLike = 0.0,
    threads: int = 1,
) -> BeamTips:
    """Return only the tips of m beams: angle in rad, x and y in m.

    Args:
        length, rigidity, weight, natural_curvature, gravity, tip_force, tip_moment, base_angle: as of ``solve_segments``.
        threads: of the compiled kernel.

    With numba (the extra ``[fast]``) and many beams, a compiled kernel solves them on ``threads`` threads, at about 20
    times the speed; the beams it leaves, and all without numba, are solved by ``solve_segments``. Both agree to 1e-12.

    Example:
        >>> tips = coast.solve_tips([0.05], [1e-6], [1e-3], [0.0], gravity=(0.0, -9.81))
        >>> round(tips.y[0].item() * 1e3, 3)
        -7.525
    """
    loads = _loads(gravity, tip_force, tip_moment, base_angle)
    pieces = _broadcast(loads.turned[:, None], length, rigidity, weight, natural_curvature)
    count = pieces[0].shape[0]
    loads = loads.broadcast(count)
    tips, solved = np.zeros((4, count)), np.zeros(count, dtype=bool)
    if count >= _WORTH_COMPILING and find_spec("numba") is not None:
        from coast_cli.mechanics.beam.compiled import solve_share

        tips, solved = solve_share(pieces, loads.columns, threads=threads)
        tips[1], tips[2] = loads.unturned(tips[1], tips[2])
        tips[0] += loads.turned
    converged = solved.copy()
    left = np.flatnonzero(~solved)
    if left.size > 0:
        rest = solve_segments(
            *(column[left] for column in pieces),
            gravity=np.broadcast_to(np.asarray(gravity, dtype=float), (count, 2))[left],
            tip_force=np.broadcast_to(np.asarray(tip_force, dtype=float), (count, 2))[left],
            tip_moment=np.broadcast_to(np.asarray(tip_moment, dtype=float), count)[left],
            base_angle=np.broadcast_to(np.asarray(base_angle, dtype=float), count)[left],
        )
        tips[:, left] = rest.angle[:, -1], rest.x[:, -1], rest.y[:, -1], rest.residual
        converged[left] = rest.converged
    return BeamTips(angle=tips[0], x=tips[1], y=tips[2], converged=converged, residual=tips[3])


def solve_curvatures(
    length: FloatArray,
    rigidity: FloatArray,
    weight: FloatArray,
    natural_curvature: ArrayLike,
    *,
    gravity: float,
    compiled: bool = False,
) -> BeamCurvatures:
    """Return only the curvatures of m beams clamped along +x, right to 1e-9 of the largest, at thrice the speed.

    Args:
        length, rigidity, weight, natural_curvature: as for ``solve_segments``. gravity: along -y, m/s^2.
        compiled: use the kernel of ``solve_tips`` where numba is installed; worth its loading for 50,000 beams and more.

    Beams out of the ordinary (several equilibria, very soft, pieces that must be divided) are left to it.
    """
    if compiled and find_spec("numba") is not None:
        from coast_cli.mechanics.beam.compiled import solve_turns

        natural = np.broadcast_to(natural_curvature, length.shape)
        turns, converged = solve_turns((length, rigidity, weight, natural), gravity)
        curvature = turns / np.where(length == 0.0, 1.0, length)
    else:
        curvature, converged = _march_curvatures(length, rigidity, weight, natural_curvature, gravity)
    left = np.flatnonzero(~converged)
    if left.size > 0:
        natural = np.broadcast_to(natural_curvature, length.shape)[left]
        rest = solve_segments(length[left], rigidity[left], weight[left], natural, gravity=(0.0, -gravity))
        curvature[left], converged[left] = rest.curvature, rest.converged
    return BeamCurvatures(curvature, converged)


def solve_alike_curvatures(
    length: FloatArray,
    rigidity: FloatArray,
    weight: FloatArray,
    natural_curvature: FloatArray,
    *,
    count: int,
    gravity: float,
) -> BeamCurvatures:
    """Return what ``solve_curvatures`` does for beams of ``count`` alike pitches of two pieces, at less cost.

    Args:
        length, rigidity, weight: of the pieces of one pitch, shape (m, 2). natural_curvature: of each beam, (m,).
    """
    nothing = np.zeros(len(length))
    rows = [np.ascontiguousarray(column.T) for column in (length, rigidity, weight)]
    with np.errstate(all="ignore"):  # what overflows is left to solve_segments
        pitch = BeamProblem(
            length=rows[0],
            flexibility=rows[0] / rows[1],
            bend=rows[0] * natural_curvature,
            load=rows[0] * rows[2] * gravity,
            thrust=nothing,
            shear=nothing,
            moment=nothing,
            base=nothing,
        )
        turns, converged = solve_plain_turns(PeriodicProblem(pitch, count))
        turns.reshape(count, 2, -1)[:] /= rows[0]
    curvature = turns.T
    left = np.flatnonzero(~converged)
    if left.size > 0:
        one, two, three = (np.tile(column[left], (1, count)) for column in (length, rigidity, weight))
        rest = solve_segments(one, two, three, natural_curvature[left, None], gravity=(0.0, -gravity))
        curvature[left], converged[left] = rest.curvature, rest.converged
    return BeamCurvatures(curvature, converged)


def _march_curvatures(
    length: FloatArray, rigidity: FloatArray, weight: FloatArray, natural_curvature: ArrayLike, gravity: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    nothing = np.zeros(len(length))
    rows = [np.ascontiguousarray(column.T) for column in (length, rigidity, weight)]
    with np.errstate(all="ignore"):  # what overflows is left to solve_segments
        problem = BeamProblem(
            length=rows[0],
            flexibility=rows[0] / rows[1],
            bend=rows[0] * np.broadcast_to(natural_curvature, length.shape).T,
            load=rows[0] * rows[2] * gravity,
            thrust=nothing,
            shear=nothing,
            moment=nothing,
            base=nothing,
        )
        turns, converged = solve_plain_turns(problem)
        return (turns / np.where(rows[0] == 0.0, 1.0, rows[0])).T, converged


@dataclass(frozen=True, slots=True)
class _Loads:
    """Loads of m beams in frames turned so that gravity is -y: size of gravity, tip loads, base angle, the turn."""

    pull: FloatArray
    thrust: FloatArray
    shear: FloatArray
    moment: FloatArray
    base: FloatArray
    turned: FloatArray

    @property
    def columns(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        return self.pull, self.thrust, self.shear, self.moment, self.base

    def broadcast(self, count: int) -> _Loads:
        """Return the same loads for every beam."""
        return _Loads(*(np.array(np.broadcast_to(value, count)) for value in (*self.columns, self.turned)))

    def unturned(self, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return places in the frame of the caller."""
        if not np.any(self.turned):
            return x, y
        cosine, sine = np.cos(self.turned), np.sin(self.turned)
        return cosine * x - sine * y, sine * x + cosine * y


def _broadcast(beams: FloatArray, *columns: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the columns with the shape (m, n) that they and ``beams``, shape (m, 1), have together."""
    arrays = [np.atleast_2d(np.asarray(column, dtype=float)) for column in columns]
    shape = np.broadcast_shapes(beams.shape, *(array.shape for array in arrays))
    length, rigidity, weight, curvature = (np.broadcast_to(array, shape) for array in arrays)
    return length, rigidity, weight, curvature


def _loads(gravity: ArrayLike, tip_force: ArrayLike, tip_moment: ArrayLike, base_angle: ArrayLike) -> _Loads:
    pull, force = (np.atleast_2d(np.asarray(vector, dtype=float)) for vector in (gravity, tip_force))
    moment, base = (np.atleast_1d(np.asarray(value, dtype=float)) for value in (tip_moment, base_angle))
    size = np.hypot(pull[:, 0], pull[:, 1])
    turned = np.where(size > 0.0, np.arctan2(pull[:, 0], -pull[:, 1]), 0.0)
    cosine, sine = np.cos(turned), np.sin(turned)
    across, along = cosine * force[:, 0] + sine * force[:, 1], sine * force[:, 0] - cosine * force[:, 1]
    return _Loads(*np.broadcast_arrays(size, across, along, moment, base - turned, turned))


def _message(*, converged: bool, equilibria: int, turned_at: float, load_number: float) -> str:
    if not converged and load_number > MOST_NUMBER:
        return f"{NO_EQUILIBRIUM} (its load number is {load_number:.3g}; beams are followed to {MOST_NUMBER:g})"
    if not converged:
        return NO_EQUILIBRIUM
    if turned_at < 1.0:
        return (
            f"converged, but the path from zero load turned back at {turned_at:.0%} of the load: the beam snaps there"
        )
    if equilibria > 1:
        return f"converged to the one reached from zero load; {equilibria} equilibria were found"
    return "converged"
