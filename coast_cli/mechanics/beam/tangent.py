"""The tip of a tube to first order in any of its inputs: complex numbers carried through the march of the beam.

The equilibrium is known from ``solve_beam``; two Newton steps bring the tip's angle onto the equation of the complex
beam, whose imaginary parts are then exact derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam.equilibrium import BeamSolution
from coast_cli.mechanics.beam.problem import BeamProblem, march
from coast_cli.mechanics.beam.solve import FINE_TURN
from coast_cli.mechanics.beam.step import segment_displacement, segment_turn
from coast_cli.mechanics.tube import NotchedTube

_STEPS = 3


@dataclass(frozen=True, slots=True)
class ComplexShape:
    """Angles of the piece ends from clamp to tip, rad, shape (n + 1,), and the tip's place, m; all complex."""

    angle: NDArray[np.complex128]
    x: complex
    y: complex


def complex_shape(tube: NotchedTube, gravity: complex, solution: BeamSolution) -> ComplexShape:
    """Return the shape of a tube some of whose inputs have a small imaginary part.

    Args:
        tube: with complex numbers where derivatives are wanted. gravity: m/s^2 along -y.
        solution: the real equilibrium.
    """
    pieces = tube.segments
    columns = (
        pieces.length,
        pieces.length / pieces.rigidity,
        pieces.length * tube.natural_curvature,
        pieces.length * pieces.weight * gravity,
    )
    parts = _problem([np.real(column) for column in columns]).parts(FINE_TURN, np.max(np.abs(solution.moment)))
    problem = _problem(list(columns)).divided(parts)
    tip = complex(solution.tip_angle)
    for _ in range(_STEPS):
        total, slope = march(problem, np.cos(tip), np.sin(tip))
        tip -= (tip + total) / slope
    return _shape(problem.pieces, tip, np.concatenate(([0], np.cumsum(parts))))


def _problem(columns: list[Any]) -> BeamProblem:
    length, flexibility, bend, load = (column[:, None] for column in columns)
    zero = np.zeros(1)
    return BeamProblem(length, flexibility, bend, load, thrust=zero, shear=zero, moment=zero, base=zero)


def _shape(pieces: Sequence[tuple[Any, ...]], tip: complex, ends: NDArray[np.int64]) -> ComplexShape:
    cosine, sine = complex(np.cos(tip)), complex(np.sin(tip))
    moment, shear, angle, x, y = 0j, 0j, [tip], 0j, 0j
    for length, flexibility, bend, load in pieces:
        turn, next_cosine, next_sine, moment, _, series = segment_turn(
            length, flexibility, bend, load, 0.0, cosine, sine, moment, shear
        )
        along_x, along_y = segment_displacement(length, cosine, sine, series)
        x, y, shear = x + along_x, y + along_y, shear + load
        cosine, sine = next_cosine, next_sine
        angle.append(angle[-1] + turn)
    return ComplexShape(np.array(angle[::-1])[ends], x, y)
