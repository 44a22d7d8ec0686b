"""Very soft beams, which hang: the angle and moment of every piece end are unknowns, so that no end must tell the other.

Marched from its tip, a beam of load number N loses a factor of about exp(sqrt(2 N)) at its clamp. Newton's method on all
pieces at once loses nothing: the linear equations are eliminated from the tip, where the moment is known, to the clamp,
where the angle is (the Riccati transformation of a two-point boundary problem). A positive pivot everywhere tells that
the equilibrium is stable, so the one that grows from zero load is followed as the load grows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, isfinite, sin

import numpy as np

from coast_cli.mechanics.beam.problem import BeamProblem
from coast_cli.mechanics.beam.step import segment_displacement, segment_tangent, segment_turn
from coast_cli.mechanics.section import FloatArray

MOST_NUMBER = 10_000.0  # load number that is followed
FIRST_NUMBER = 25.0  # load number up to which the tip still tells the clamp
_CELLS = 64
_COARSE_TURN, _FINE_TURN = 0.5, 0.04  # rad a step
_GROWTH, _LEAST_GROWTH = 1.6, 1.001  # of the load from step to step
_MOST_STEPS, _LARGEST_CHANGE, _ENOUGH = 40, 0.5, 1e-13


@dataclass(frozen=True, slots=True)
class Hanging:
    """Angle (rad), moment (N m) and places (m) of the piece ends of one beam from clamp to tip, shape (n + 1,)."""

    angle: FloatArray
    moment: FloatArray
    x: FloatArray
    y: FloatArray
    residual: float
    steps: int


Start = Callable[[BeamProblem], tuple[FloatArray, FloatArray] | None]


def follow_down(problem: BeamProblem, start: Start) -> Hanging | None:
    """Return the equilibrium of one soft beam that its load reaches growing from zero; None where it is lost.

    Args:
        start: finds angles and moments of the piece ends of a beam of less load, or nothing.
    """
    share = min(1.0, FIRST_NUMBER / float(problem.load_number[0]))
    coarse = problem.coarse(_CELLS)
    coarse = coarse.divided(coarse.parts(_COARSE_TURN, np.zeros(1)))
    known = start(coarse.scaled(share))
    growth = _GROWTH
    while known is not None and share < 1.0 and growth > _LEAST_GROWTH:
        further = min(1.0, share * growth)
        found = _settled(coarse.scaled(further), *known)
        if found is None:
            growth = 1.0 + (growth - 1.0) / 2.0
        else:
            known, share, growth = found[:2], further, min(_GROWTH, 1.0 + 2.0 * (growth - 1.0))
    return None if known is None or share < 1.0 else _sharpened(problem, coarse, known)


def _sharpened(problem: BeamProblem, coarse: BeamProblem, known: tuple[FloatArray, FloatArray]) -> Hanging | None:
    """Return the equilibrium of the full beam from that of the homogenised one."""
    parts = problem.parts(_FINE_TURN, np.max(np.abs(known[1])))
    fine, ends = problem.divided(parts), np.concatenate(([0], np.cumsum(parts)))
    places = [np.append(0.0, np.cumsum(beam.length[:, 0])) for beam in (fine, coarse)]
    found = _settled(fine, *(np.interp(places[0], places[1], column) for column in known))
    if found is None:
        return None
    angle, moment, residual, steps = found
    x, y = _places(fine, angle, moment)
    return Hanging(angle[ends], moment[ends], x[ends], y[ends], residual, steps)


def _settled(
    problem: BeamProblem, angle: FloatArray, moment: FloatArray
) -> tuple[FloatArray, FloatArray, float, int] | None:
    """Return angles and moments in stable equilibrium by Newton's method, the last change and the steps, or None."""
    theta, pull = angle[::-1].tolist(), moment[::-1].tolist()
    for step in range(1, _MOST_STEPS + 1):
        changes = _changes(problem, theta, pull)
        if changes is None:
            return None
        size = max(abs(change) for change, _ in changes)
        scale = min(1.0, _LARGEST_CHANGE / size) if size > 0.0 else 1.0
        theta = [value + scale * change for value, (change, _) in zip(theta, changes, strict=True)]
        pull = [value + scale * change for value, (_, change) in zip(pull, changes, strict=True)]
        if not isfinite(size):
            return None
        if size <= _ENOUGH * max(1.0, *map(abs, theta)):
            return np.array(theta[::-1]), np.array(pull[::-1]), size, step
    return None


def _changes(problem: BeamProblem, theta: list[float], pull: list[float]) -> list[tuple[float, float]] | None:
    """Return the Newton changes of angle and moment from tip to clamp; None where the equilibrium is not stable."""
    thrust, shear, tip_moment = problem.tip_loads
    gain, offset = 0.0, tip_moment - pull[0]  # the change of the moment is gain * change of the angle + offset
    pivots: list[tuple[float, float, float, float]] = []
    for i, (length, flexibility, bend, load) in enumerate(problem.pieces):
        turn, _, _, moment, forces, series = segment_turn(
            length, flexibility, bend, load, thrust, cos(theta[i]), sin(theta[i]), pull[i], shear
        )
        by_angle = segment_tangent(length, flexibility, forces, series, 1.0, 0.0)
        by_moment = segment_tangent(length, flexibility, forces, series, 0.0, 1.0)
        pivot = by_angle[0] + by_moment[0] * gain
        if not pivot > 0.0:
            return None
        missed = by_moment[0] * offset + theta[i] + turn - theta[i + 1]
        pivots.append((gain, offset, pivot, missed))
        next_gain = (by_angle[1] + by_moment[1] * gain) / pivot
        offset = by_moment[1] * offset + moment - pull[i + 1] - next_gain * missed
        gain, shear = next_gain, shear + load
    change = float(problem.base[0]) - theta[-1]
    changes = [(change, gain * change + offset)]
    for gain, offset, pivot, missed in reversed(pivots):
        change = (change - missed) / pivot
        changes.append((change, gain * change + offset))
    return changes[::-1]


def _places(problem: BeamProblem, angle: FloatArray, moment: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where the piece ends are, from the clamp, m."""
    thrust, _, _ = problem.tip_loads
    load = np.append(np.cumsum(problem.load[::-1, 0])[::-1], 0.0)
    tip = slice(1, None)
    length = problem.length[:, 0]
    cosine, sine = np.cos(angle[tip]), np.sin(angle[tip])
    columns = (problem.flexibility[:, 0], problem.bend[:, 0], problem.load[:, 0])
    *_, series = segment_turn(length, *columns, thrust, cosine, sine, moment[tip], load[tip] + problem.shear[0])
    along, across = segment_displacement(length, cosine, sine, series)
    return np.append(0.0, np.cumsum(along)), np.append(0.0, np.cumsum(across))
