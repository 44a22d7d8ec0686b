"""Tubes under gravity, solved in arc length: any tip angle, any number of notches, no angle picked by hand.

Source: equations (3)-(7) of P, "Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023), in
arc length instead of projected length: theta' = k0 - M/EI, M' = -V cos(theta), theta(0) = 0, M(L) = 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from coast_cli.mechanics.beam_problem import BeamProblem
from coast_cli.mechanics.beam_solve import solve_problem
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.verdict import Verdict


@dataclass(frozen=True)
class BeamSolution:
    """The equilibrium of one beam.

    Attributes:
        s: arc length of the piece ends from clamp to tip, m, shape (n + 1,).
        x, y: their places, m. angle: of the tangent, rad. moment: internal moment, N m. All of the shape of s.
        curvature: mean curvature of each piece, 1/m, shape (n,); times the piece's length it is exactly its turn.
        verdict: whether the solve converged, and what was found on the way.
    """

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
    """

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

    def verdict(self, beam: int) -> Verdict:
        """Return the verdict of one beam in words."""
        return Verdict(
            converged=bool(self.converged[beam]),
            message=_message(
                converged=bool(self.converged[beam]),
                equilibria=int(self.equilibria[beam]),
                turned_at=float(self.turned_at[beam]),
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


def solve_beam(tube: NotchedTube, gravity: float) -> BeamSolution:
    """Return the equilibrium of a tube clamped along +x under gravity (m/s^2) along -y.

    The start is automatic. The tip agrees with 13-digit references within 1e-13 of the length, past 90 degrees too.
    """
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

    The step is of order 6; pieces are divided so that a step turns by at most 0.05 rad, which leaves 1e-12 of the
    length.
    """
    columns = np.broadcast_arrays(
        *(np.atleast_2d(np.asarray(column, dtype=float)) for column in (length, rigidity, weight, natural_curvature))
    )
    pieces = [np.ascontiguousarray(column.T) for column in columns]
    count = pieces[0].shape[1]
    pull, force = (np.broadcast_to(np.asarray(vector, dtype=float), (count, 2)) for vector in (gravity, tip_force))
    moment, base = (
        np.array(np.broadcast_to(np.asarray(value, dtype=float), count)) for value in (tip_moment, base_angle)
    )
    size = np.hypot(pull[:, 0], pull[:, 1])
    # The frame of the problem is turned by this, so that gravity is its -y.
    turned = np.where(size > 0.0, np.arctan2(pull[:, 0], -pull[:, 1]), 0.0)
    cosine, sine = np.cos(turned), np.sin(turned)
    problem = BeamProblem(
        length=pieces[0],
        flexibility=pieces[0] / pieces[1],
        bend=pieces[0] * pieces[3],
        load=pieces[0] * pieces[2] * size,
        thrust=cosine * force[:, 0] + sine * force[:, 1],
        shear=sine * force[:, 0] - cosine * force[:, 1],
        moment=moment,
        base=base - turned,
    )
    solved = solve_problem(problem)
    angle = solved.angle + turned
    nodes = np.concatenate((np.zeros((1, count)), np.cumsum(pieces[0], axis=0)))
    straight = pieces[0] == 0.0
    return BeamSolutions(
        s=nodes.T,
        x=(cosine * solved.x - sine * solved.y).T,
        y=(sine * solved.x + cosine * solved.y).T,
        angle=angle.T,
        moment=solved.moment.T,
        curvature=(np.diff(angle, axis=0) / np.where(straight, 1.0, pieces[0])).T,
        converged=solved.converged,
        residual=solved.residual,
        iterations=solved.steps,
        equilibria=solved.equilibria,
        turned_at=solved.turned_at,
    )


def _message(*, converged: bool, equilibria: int, turned_at: float) -> str:
    if not converged:
        return (
            "no equilibrium was reached from zero load: the beam is too soft for its load or its numbers overflow; "
            "give a stiffer, shorter or lighter beam, or less gravity"
        )
    if turned_at < 1.0:
        return (
            f"converged, but the path from zero load turned back at {turned_at:.0%} of the load: the beam snaps there"
        )
    if equilibria > 1:
        return f"converged to the one reached from zero load; {equilibria} equilibria were found"
    return "converged"
