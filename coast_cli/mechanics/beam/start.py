"""Where to start: the tip angle of a coarse homogenised beam, and what is known about other equilibria.

Below a load number of 1 there is one equilibrium, and a bracketed Newton method finds it from anywhere. Above, a survey
over the tip's angle counts the equilibria while the load is grown from zero in 8 steps; where that is not smooth, the
path is followed by arc length.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam.continuation import follow_branch
from coast_cli.mechanics.beam.problem import AnyProblem, BeamProblem, Ripple, clamp_error, march_rippled
from coast_cli.mechanics.roots import increasing_root
from coast_cli.mechanics.section import FloatArray

COARSE_CELLS, LIGHT_CELLS = 12, 6
SHARP_CELLS, PLAIN_CELLS = 64, 14  # of the last start, where one march is all: to the last digit, or to 1e-9
LIGHT_TURN = 2.0  # rad a step at most where there is one equilibrium: the sharp beam then corrects 1e-4 rad
COARSE_TURN = 1.0  # rad a step at most, by a bound that is twice too large: it then errs by 1e-5 of its length
SOFTEST = 100.0  # load number past which a beam hangs like a string and its tip no longer tells its clamp
_MOST_CORRECTED = 1e-2  # rad, by which what homogenising left out may move the tip
SURELY_ONE = 0.95  # load number; the coarse beam knows it to a few per cent
_NUMBERS = (SURELY_ONE, 2.0, 4.0, 8.0, 16.0, 32.0, SOFTEST)  # beams of like softness are cut alike
SURVEY, _FINE_SURVEY = np.linspace(-1.0, 1.0, 17), np.linspace(-1.0, 1.0, 129)
_FURTHEST_TURN = 4.0 * np.pi  # rad, searched for other equilibria
SHARES = np.linspace(0.125, 1.0, 8) ** 2  # of the load, closer at first, where the tip moves fastest
LEAST_SLOPE = 0.1  # of the clamp's angle by the tip's; zero at a fold
_MOST_TURN = 300.0  # rad, of a beam without force
SMOOTH = 0.4  # rad by which a step of the load may miss its prediction


@dataclass(frozen=True, slots=True)
class Start:
    """Starting tip angles of m beams.

    Attributes:
        tip_angle: rad. slope: derivative of the clamp's angle by it. moment: largest internal moment, N m.
        found: whether the start is an equilibrium of the coarse beam.
        equilibria: how many the coarse beam has.
        turned_at: share of the load where the path from zero turned back, or 1.
    """

    tip_angle: FloatArray
    slope: FloatArray
    moment: FloatArray
    found: NDArray[np.bool_]
    equilibria: NDArray[np.int64]
    turned_at: FloatArray

    def picked(self, beams: NDArray[np.int64]) -> Start:
        """Return some of many starts."""
        return Start(*(getattr(self, item.name)[beams] for item in fields(self)))


def find_start(problem: AnyProblem, cells: int = SHARP_CELLS) -> Start:
    """Return where to start each of m beams; ``cells`` are of the homogenised beam that corrects the start last."""
    coarse = problem.coarse(COARSE_CELLS)
    natural = np.sum(np.abs(coarse.bend) + coarse.flexibility * np.abs(coarse.moment), axis=0)
    number = np.where(natural <= _MOST_TURN, coarse.load_number, np.inf)
    start = Start(
        tip_angle=np.array(coarse.unloaded_tip_angle),
        slope=np.ones(coarse.count),
        moment=np.zeros(coarse.count),
        found=np.zeros(coarse.count, dtype=bool),
        equilibria=np.ones(coarse.count, dtype=np.int64),
        turned_at=np.ones(coarse.count),
    )
    sharp = problem.coarse(cells), problem.ripple(cells)
    light = np.flatnonzero(number < SURELY_ONE)
    _solve_light(problem.coarse(LIGHT_CELLS), sharp, light, start)
    for low, high in pairwise(_NUMBERS):
        _solve_heavy(coarse, sharp, np.flatnonzero((number >= low) & (number < high)), start)
    return start


def _solve_light(
    coarse: BeamProblem, sharp: tuple[BeamProblem, Ripple], light: NDArray[np.int64], start: Start
) -> None:
    if light.size > 0:
        beams = _resolved(coarse.picked(light), LIGHT_TURN)
        tip, change, _ = increasing_root(
            lambda angle: clamp_error(beams, angle), start.tip_angle[light], tolerance=1e-4
        )
        _finish(start, sharp, light, tip, change < 1e-3)


def _solve_heavy(
    coarse: BeamProblem, sharp: tuple[BeamProblem, Ripple], heavy: NDArray[np.int64], start: Start
) -> None:
    if heavy.size == 0:
        return
    beams = _resolved(coarse.picked(heavy))
    tip, found = _grown(beams)
    winding = np.flatnonzero(~found)
    if winding.size > 0:
        path = follow_branch(beams.picked(winding))
        tip[winding], found[winding], start.turned_at[heavy[winding]] = path.tip_angle, path.arrived, path.turned_at
    several = np.flatnonzero(~_survey(beams, SURVEY)[0])
    if several.size > 0:
        start.equilibria[heavy[several]] = _survey(beams.picked(several), _FINE_SURVEY)[1]
    _finish(start, sharp, heavy, tip, found)


def _resolved(coarse: BeamProblem, turn: float = COARSE_TURN) -> BeamProblem:
    return coarse.divided(coarse.parts(turn, coarse.moment_bound))


def _finish(
    start: Start,
    sharp: tuple[BeamProblem, Ripple],
    columns: NDArray[np.int64],
    tip: FloatArray,
    found: NDArray[np.bool_],
) -> None:
    """Correct the tips once with a sharper homogenised beam and what homogenising leaves out."""
    beams, ripple = sharp[0].picked(columns), sharp[1].picked(columns)
    parts = beams.parts(COARSE_TURN, beams.moment_bound)
    error, slope, start.moment[columns] = march_rippled(beams.divided(parts), ripple.divided(parts), tip)
    change = np.where(np.abs(slope) > LEAST_SLOPE, error, 0.0) / np.where(slope == 0.0, 1.0, slope)
    start.tip_angle[columns] = tip - np.where(np.abs(change) < _MOST_CORRECTED, change, 0.0)
    start.found[columns], start.slope[columns] = found, slope


def _survey(problem: BeamProblem, grid: FloatArray) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Try tip angles over the whole range in which equilibria can lie.

    Returns:
        Whether the clamp's error surely crosses zero once only, and how many crossings are seen. An interval cannot
        hide a crossing if the error increases at both ends, or is further from zero at both than the steeper slope
        could bring it by the middle.
    """
    reach = np.minimum(problem.load_number, _FURTHEST_TURN)
    error, slope = clamp_error(problem, problem.unloaded_tip_angle + np.multiply.outer(grid, reach))
    increases = np.minimum(slope[1:], slope[:-1]) > 0.0
    half = reach * (grid[1] - grid[0]) / 2.0
    far = np.minimum(np.abs(error[1:]), np.abs(error[:-1])) > half * np.maximum(np.abs(slope[1:]), np.abs(slope[:-1]))
    same_side = error[1:] * error[:-1] > 0.0
    crossings = np.count_nonzero(~same_side, axis=0)
    return np.all(increases | (far & same_side), axis=0) & (crossings == 1), np.maximum(crossings, 1)


def _grown(problem: BeamProblem) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Grow the load in few steps; smooth where every step landed near its prediction and no fold was near."""
    before, tip = problem.unloaded_tip_angle, problem.unloaded_tip_angle
    smooth = np.ones(problem.count, dtype=bool)
    last, now = -1.0, 0.0
    for share in SHARES.tolist():
        predicted = tip + (tip - before) * (share - now) / (now - last)
        last, now = now, share
        before, tip = tip, predicted
        beams = problem.scaled(share)
        change = np.full_like(tip, np.inf)
        enough = 1e-4 if share == 1.0 else 0.03
        for _ in range(4):
            error, slope = clamp_error(beams, tip)
            smooth &= slope > LEAST_SLOPE
            change = error / np.where(slope > LEAST_SLOPE, slope, 1.0)
            tip = tip - change
            if np.all(np.abs(change) < enough):
                break
        smooth &= (np.abs(change) < 10.0 * enough) & (np.abs(tip - predicted) < SMOOTH)
    return tip, smooth
