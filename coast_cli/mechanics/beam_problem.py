"""A planar beam ready to be solved: pieces, loads and clamp in a frame whose downward direction is gravity's.

One beam has arrays of shape (n,), many beams (n, m), pieces from clamp to tip. The only unknown is the angle of the tip:
there the moment is known, so the march to the clamp needs nothing else, and the clamp's angle is the one equation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from coast_cli.mechanics.beam_step import Number, segment_step, tangent_step
from coast_cli.mechanics.section import FloatArray

Piece = tuple[Number, Number, Number, Number]


@dataclass(frozen=True)
class BeamProblem:
    """Pieces and loads of one beam, shape (n,), or of many, shape (n, m).

    Attributes:
        length: of each piece, m. flexibility: length/B, 1/(N m). bend: natural turn, rad. load: weight of each piece, N.
        thrust: tip force across gravity, N. shear: tip force along gravity, N. moment: at the tip, N m.
        base: angle of the clamp from the horizontal of this frame, rad.
    """

    length: FloatArray
    flexibility: FloatArray
    bend: FloatArray
    load: FloatArray
    thrust: Number = 0.0
    shear: Number = 0.0
    moment: Number = 0.0
    base: Number = 0.0

    @cached_property
    def pieces(self) -> Sequence[Piece]:
        """The pieces from tip to clamp: of Python floats for one beam, of rows over beams for many."""
        columns = (self.length, self.flexibility, self.bend, self.load)
        if self.length.ndim == 1:
            columns = tuple(column.tolist() for column in columns)  # type: ignore[misc]
        return list(zip(*columns, strict=True))[::-1]

    @cached_property
    def natural_tip_angle(self) -> Number:
        """Angle of the tip without any load, rad: where the continuation starts."""
        return self.base + self.bend.sum(axis=0)

    @cached_property
    def load_number(self) -> Number:
        """Integral of s P/B over the beam, P the size of the internal force: below 1 there is one equilibrium only.

        Two equilibria would make d'' + p d = 0, d(0) = d'(L) = 0 solvable with |p| <= P/B; its Green's function
        min(s, sigma) forbids that (the self-weight column buckles at 7.84 where this says 6).
        """
        beyond = self.shear + np.cumsum(self.load[::-1], axis=0)[::-1]
        largest = np.maximum(np.abs(beyond), np.abs(beyond - self.load))
        ends = np.cumsum(self.length, axis=0)
        return np.sum((ends - self.length / 2.0) * self.flexibility * np.hypot(self.thrust, largest), axis=0)

    def scaled(self, factor: Number) -> BeamProblem:
        """Return the same beam with every load times ``factor``."""
        return replace(
            self,
            load=self.load * factor,
            thrust=self.thrust * factor,
            shear=self.shear * factor,
            moment=self.moment * factor,
        )

    def coarse(self, cells: int) -> BeamProblem:
        """Return a beam of about ``cells`` homogenised pieces, which bends alike.

        The new ends lie in the middle of every 2k-th piece, so that each cell of a periodic tube is symmetric; a tip
        angle of it errs by 1e-5 to 1e-4 rad on the reference tubes.
        """
        count = self.length.shape[0]
        if count <= 2 * cells:
            return self
        chosen = np.unique(np.linspace(0, (count - 1) // 2, cells + 1).round().astype(int)) * 2

        def merged(column: FloatArray) -> FloatArray:
            total = np.concatenate((np.zeros_like(column[:1]), np.cumsum(column, axis=0)))
            middle = 0.5 * (total[chosen] + total[chosen + 1])
            return np.diff(np.concatenate((total[:1], middle, total[-1:])), axis=0)

        return replace(
            self,
            length=merged(self.length),
            flexibility=merged(self.flexibility),
            bend=merged(self.bend),
            load=merged(self.load),
        )


@dataclass(slots=True)
class Trace:
    """What a march passes, one entry a node from tip to clamp, steps one shorter."""

    turn: list[Number]
    moment: list[Number]
    along_x: list[Number]
    along_y: list[Number]


def march(problem: BeamProblem, cosine: Number, sine: Number, trace: Trace | None = None) -> tuple[Number, Number]:
    """March from the tip, whose tangent is (cosine, sine), to the clamp.

    Returns:
        The turn from tip to clamp, rad, and the derivative of the clamp's angle by the tip's. The derivative is good to
        about 1e-4, which Newton's method needs; the turn has the order of the step.
    """
    thrust, shear, moment = problem.thrust, problem.shear, problem.moment
    total = 0.0 * cosine
    slope, moment_slope = total + 1.0, total
    for length, flexibility, bend, load in problem.pieces:
        turn, cosine, sine, moment, along_x, along_y, stiffness, stiffness_slope = segment_step(
            length, flexibility, bend, load, thrust, cosine, sine, moment, shear
        )
        shear = shear + load
        total = total + turn
        slope, moment_slope = tangent_step(length, flexibility, stiffness, stiffness_slope, slope, moment_slope)
        if trace is not None:
            trace.turn.append(turn)
            trace.moment.append(moment)
            trace.along_x.append(along_x)
            trace.along_y.append(along_y)
    return total, slope
