"""The equilibrium that a beam reaches when its load grows from zero, followed around folds.

Without force a beam has one equilibrium. The pairs (tip angle, share of the load) that are in equilibrium form curves
in a plane; the one through zero load is followed by arc length, so it may turn back where the beam would snap, and it
must leave through the full load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam.problem import BeamProblem, clamp_error
from coast_cli.mechanics.section import FloatArray

_COMPLEX_STEP = 1e-30
_FIRST_STRIDE, _LONGEST_STRIDE, _SHORTEST_STRIDE = 0.1, 0.4, 1e-6
_MOST_STRIDES = 600
_CORRECTIONS = 3


@dataclass(frozen=True, slots=True)
class EquilibriumPath:
    """Where the paths of m beams from zero load arrive.

    Attributes:
        tip_angle: at full load, rad. slope: derivative of the clamp's angle by it. arrived: whether the path got there.
        turned_at: largest share of the load before the path turned back; 1 where it never did.
    """

    tip_angle: FloatArray
    slope: FloatArray
    arrived: NDArray[np.bool_]
    turned_at: FloatArray


def follow_branch(problem: BeamProblem) -> EquilibriumPath:
    """Follow the equilibria of m beams, arrays of shape (n, m), from zero to full load."""
    count = problem.length.shape[1]
    tip = np.array(np.broadcast_to(problem.unloaded_tip_angle, count), dtype=float)
    share, turned_at = np.zeros(count), np.ones(count)
    arrived = np.zeros(count, dtype=bool)
    _, by_tip, by_share = _equation(problem, tip, share)
    direction = _unit(-by_share, by_tip)
    stride = np.full(count, _FIRST_STRIDE)
    going = np.arange(count)
    for _ in range(_MOST_STRIDES):
        beams = problem.picked(going)
        new_tip, new_share, new_direction, fine = _stride(
            beams, tip[going], share[going], direction[:, going], stride[going]
        )
        done = going[fine]
        crossed = fine & (new_share >= 1.0)
        turns_back = fine & (direction[1, going] > 0.0) & (new_direction[1] < 0.0) & ~crossed
        turned_at[going[turns_back]] = np.minimum(
            turned_at[going[turns_back]], np.maximum(share, 0.0)[going[turns_back]]
        )
        if np.any(crossed):
            weight = (1.0 - share[going]) / np.where(crossed, new_share - share[going], 1.0)
            between = tip[going] + weight * (new_tip - tip[going])
            tip[going[crossed]], arrived[going[crossed]] = _land(beams, between, crossed)
        moved = going[fine & ~crossed]
        tip[moved], share[moved] = new_tip[fine & ~crossed], new_share[fine & ~crossed]
        direction[:, done] = new_direction[:, fine]
        stride[going] = np.where(fine, np.minimum(stride[going] * 1.5, _LONGEST_STRIDE), stride[going] / 3.0)
        going = going[~crossed & (stride[going] > _SHORTEST_STRIDE)]
        if going.size == 0:
            break
    slope = clamp_error(problem, tip)[1]
    return EquilibriumPath(tip, np.where(slope == 0.0, 1.0, slope), arrived, turned_at)


def _equation(problem: BeamProblem, tip: FloatArray, share: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the clamp's error and its derivatives by tip angle and by share of the load (complex step)."""
    error, slope = clamp_error(problem.scaled(share + 1j * _COMPLEX_STEP), tip)
    return np.real(error), np.real(slope), np.imag(error) / _COMPLEX_STEP


def _stride(
    problem: BeamProblem, tip: FloatArray, share: FloatArray, direction: FloatArray, stride: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
    """Step along the path and come back to it; fine where that converged and the path bent little."""
    guess_tip, guess_share = tip + stride * direction[0], share + stride * direction[1]
    new_tip, new_share = guess_tip, guess_share
    size = np.full_like(tip, np.inf)
    for _ in range(_CORRECTIONS):
        error, by_tip, by_share = _equation(problem, new_tip, new_share)
        off = direction[0] * (new_tip - guess_tip) + direction[1] * (new_share - guess_share)
        determinant = by_tip * direction[1] - by_share * direction[0]
        safe = np.where(determinant == 0.0, np.inf, determinant)
        change_tip = (by_share * off - error * direction[1]) / safe
        change_share = (error * direction[0] - by_tip * off) / safe
        size = np.hypot(change_tip, change_share)
        new_tip, new_share = new_tip + change_tip, new_share + change_share
    new_direction = _unit(-by_share, by_tip)
    same_way = np.sum(new_direction * direction, axis=0)
    new_direction = new_direction * np.where(same_way < 0.0, -1.0, 1.0)
    return new_tip, new_share, new_direction, (size < 1e-6 * stride) & (np.abs(same_way) > 0.9)


def _land(
    problem: BeamProblem, between: FloatArray, crossed: NDArray[np.bool_]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Solve at full load from the place where the path crosses it."""
    chosen = problem.picked(np.flatnonzero(crossed))
    start = between[crossed]
    tip, change = start, np.full_like(start, np.inf)
    for _ in range(8):
        error, slope = clamp_error(chosen, tip)
        change = error / np.where(slope == 0.0, np.inf, slope)
        tip = tip - change
    return tip, (np.abs(change) < 1e-9) & (np.abs(tip - start) < 2.0 * _LONGEST_STRIDE)


def _unit(x: FloatArray, y: FloatArray) -> FloatArray:
    size = np.hypot(x, y)
    return np.stack((x / size, y / size))
