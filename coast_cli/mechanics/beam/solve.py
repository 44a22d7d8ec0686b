"""Many beams at once in numpy: a coarse start, then Newton's method on the tip angle with the tangent carried along.

Two marches over the full beam are the rule: the coarse start errs by 1e-5 rad, the first march leaves 1e-8, and the
second is corrected to first order, which leaves 1e-13.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam.continuation import follow_branch
from coast_cli.mechanics.beam.hanging import FIRST_NUMBER, MOST_NUMBER, follow_down
from coast_cli.mechanics.beam.problem import AnyProblem, BeamProblem, BeamTrace, march_shape, march_turns, rotation
from coast_cli.mechanics.beam.start import PLAIN_CELLS, Start, find_start
from coast_cli.mechanics.section import FloatArray

FINE_TURN = 0.04  # rad a step at most: a beam then errs by 1e-12 of its length
SHORT_TURN = 0.01  # rad a step of order 4 at most, which leaves 1e-12
LAST_CHANGE = 1e-7  # rad; a last correction this small is applied to first order
ONLY_CHANGE = 1e-5  # rad; the same where turns to 1e-9 are enough and one march is all
CLAMP_TOLERANCE = 1e-10  # rad
_MOST_STEPS = 30
_SAME_EQUILIBRIUM = 0.3  # rad between the coarse and the full beam
TANGENT_ERROR, ROUNDING = 1e-5, 1e-15  # relative error of the carried tangent; of the angle, rad
_FEW = 12  # beams that plain numbers solve one by one faster than arrays together
_TOGETHER, _NUMBERS = 2048, 1 << 22  # beams at most, and beams times pieces, which bounds the memory


@dataclass(frozen=True, slots=True)
class Equilibria:
    """Solved beams: nodes from clamp to tip, shape (n + 1, m), in the frame of the problem.

    Attributes:
        x, y: m. angle: rad. moment: N m.
        residual: what is left of the clamp's angle, rad, shape (m,). steps: Newton steps, (m,).
        converged: (m,). equilibria: how many were found, (m,).
        turned_at: share of the load where the path from zero load turned back, or 1, (m,).
        load_number: of beams that are not converged, (m,).
    """

    x: FloatArray
    y: FloatArray
    angle: FloatArray
    moment: FloatArray
    residual: FloatArray
    steps: NDArray[np.int64]
    converged: NDArray[np.bool_]
    equilibria: NDArray[np.int64]
    turned_at: FloatArray
    load_number: FloatArray


def solve_problem(problem: BeamProblem) -> Equilibria:
    """Return the equilibria that m beams reach from zero load; each with its own verdict, none raises."""
    nodes, count = problem.length.shape[0] + 1, problem.count
    result = Equilibria(
        x=np.zeros((nodes, count)),
        y=np.zeros((nodes, count)),
        angle=np.zeros((nodes, count)),
        moment=np.zeros((nodes, count)),
        residual=np.zeros(count),
        steps=np.zeros(count, dtype=np.int64),
        converged=np.zeros(count, dtype=bool),
        equilibria=np.ones(count, dtype=np.int64),
        turned_at=np.ones(count),
        load_number=np.zeros(count),
    )
    _solve_into(problem, result)
    for beam in np.flatnonzero(~result.converged).tolist():
        _solve_hanging(problem.picked(np.array([beam])), result, beam)
    lost = ~np.all(
        [np.isfinite(table).all(axis=0) for table in (result.x, result.y, result.angle, result.moment)], axis=0
    )
    result.converged[lost] = False
    for table in (result.x, result.y, result.angle, result.moment):
        table[:, lost] = 0.0
    result.residual[~np.isfinite(result.residual)] = np.pi
    return result


def _solve_hanging(problem: BeamProblem, result: Equilibria, beam: int) -> None:
    """Put the equilibrium of a beam too soft to be marched into the result, where its load can be followed."""
    turned: list[float] = []

    def start(lighter: BeamProblem) -> tuple[FloatArray, FloatArray] | None:
        found = solve_problem(lighter)
        turned.append(float(found.turned_at[0]))
        return (found.angle[:, 0], found.moment[:, 0]) if found.converged[0] else None

    result.load_number[beam] = number = float(problem.load_number[0])
    if not FIRST_NUMBER < number <= MOST_NUMBER:
        return
    found = follow_down(problem, start)
    if found is None:
        return
    for name in ("angle", "moment", "x", "y"):
        getattr(result, name)[:, beam] = getattr(found, name)
    result.residual[beam], result.steps[beam], result.converged[beam] = found.residual, found.steps, True
    if turned[-1] < 1.0:
        result.turned_at[beam] = turned[-1] * FIRST_NUMBER / number


def solve_plain_turns(problem: AnyProblem) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the turn of each piece, rad, shape (n, m), by one march, and for which beams that is enough, (m,).

    Enough are fine pieces, one equilibrium, and a coarse start so near that the turns are right to 1e-9 of the largest.
    """
    start = find_start(problem, PLAIN_CELLS)
    bounds = problem.turn_bounds(start.moment)
    little = (np.max(bounds, axis=1, initial=0.0) <= SHORT_TURN).tolist()
    plain = start.found & (start.equilibria == 1) & (start.turned_at == 1.0) & (_fineness(bounds) == 0)
    if not np.any(plain):
        return np.zeros((problem.piece_count, problem.count)), plain
    turns, change = march_turns(problem, start.tip_angle, little[::-1])
    return turns, plain & (np.abs(change) <= ONLY_CHANGE) & np.isfinite(turns).all(axis=0)


def _solve_into(problem: BeamProblem, result: Equilibria) -> None:
    start = find_start(problem)
    result.equilibria[:], result.turned_at[:] = start.equilibria, start.turned_at
    level = _fineness(problem.turn_bounds(start.moment))
    for fineness in sorted(set(level[start.found].tolist())):
        alike = np.flatnonzero(start.found & (level == fineness))
        together = max(_FEW, min(_TOGETHER, _NUMBERS // problem.length.shape[0]))
        blocks = alike.size if alike.size <= _FEW else -(-alike.size // together)
        for beams in np.array_split(alike, blocks):
            _solve_alike(problem.picked(beams), start.picked(beams), result, beams, divide=bool(fineness > 0))


def _fineness(bounds: FloatArray) -> NDArray[np.int64]:
    """Return the power of two by which the longest turn exceeds one step; beams of one power are cut alike."""
    most = np.max(bounds, axis=0, initial=0.0)
    level: NDArray[np.int64] = np.ceil(np.log2(np.maximum(most / FINE_TURN, 1.0))).astype(np.int64)
    return level


def _solve_alike(
    problem: BeamProblem, start: Start, result: Equilibria, columns: NDArray[np.int64], *, divide: bool
) -> None:
    """Solve beams of one fineness and put them into ``columns`` of the result.

    Where the full beam leads far from the coarse one and there are several equilibria, the coarse start may belong to
    another one: the path from zero load is then followed on the full beam.
    """
    parts = problem.parts(FINE_TURN, start.moment) if divide else np.ones(problem.length.shape[0], dtype=np.int64)
    ends = np.concatenate(([0], np.cumsum(parts)))
    beams = problem.divided(parts)
    _newton(beams, start.tip_angle, ends, result, columns)
    moved = np.abs(result.angle[-1, columns] - start.tip_angle) > _SAME_EQUILIBRIUM
    lost = np.flatnonzero(moved & (start.equilibria > 1))
    if lost.size > 0:
        again = beams.picked(lost)
        path = follow_branch(again)
        _newton(again, path.tip_angle, ends, result, columns[lost])
        result.turned_at[columns[lost]] = path.turned_at
        result.converged[columns[lost]] &= path.arrived


def _newton(
    beams: BeamProblem,
    tip: FloatArray,
    ends: NDArray[np.int64],
    result: Equilibria,
    columns: NDArray[np.int64],
) -> None:
    """Correct the tip angles by Newton's method; of a sharp start one march is enough."""
    for step in range(1, _MOST_STEPS + 1):
        trace = BeamTrace(beams)
        total, slope = march_shape(beams, *rotation(beams, tip), trace)
        change = (tip + total - beams.base) / np.where(slope == 0.0, np.inf, slope)
        residual = np.abs(slope) * (TANGENT_ERROR * np.abs(change) + ROUNDING)
        # A beam that hangs turns its clamp by its tip's change many times over: it may need one correction more.
        late = (residual > CLAMP_TOLERANCE) & (np.abs(change) > ROUNDING * np.maximum(np.abs(tip), 1.0))
        ready = ~((np.abs(change) > LAST_CHANGE) | late) | (step == _MOST_STEPS)
        done = np.flatnonzero(ready)
        _record(tip, change, trace, ends, done, result, columns[done])
        result.residual[columns], result.steps[columns] = residual, step
        result.converged[columns] = residual <= CLAMP_TOLERANCE
        if done.size == ready.size:
            break
        left = np.flatnonzero(~ready)
        beams, columns, tip = beams.picked(left), columns[left], (tip - change)[left]


def _record(
    tip: FloatArray,
    change: FloatArray,
    trace: BeamTrace,
    ends: NDArray[np.int64],
    done: NDArray[np.int64],
    result: Equilibria,
    columns: NDArray[np.int64],
) -> None:
    """Put finished beams into the result, corrected to first order for the last change of the tip's angle."""
    if done.size == 0:
        return
    some = slice(None) if done.size == tip.size else done
    here = slice(columns[0], columns[-1] + 1) if columns[-1] - columns[0] == columns.size - 1 else columns
    node = slice(None) if ends.size == len(trace.turn) else ends
    piece = slice(None) if ends.size == len(trace.turn) else ends[1:] - 1
    turn = trace.slope[:, some] * -change[some]
    along_x, along_y = np.diff(trace.x[:, some], axis=0), np.diff(trace.y[:, some], axis=0)
    turn_between = 0.5 * (turn[1:] + turn[:-1])
    result.angle[:, here] = (trace.turn[:, some] + (tip[some] + turn))[node]
    result.moment[:, here] = trace.moment[:, some][node]
    result.x[1:, here] = np.cumsum(along_x - along_y * turn_between, axis=0)[piece]
    result.y[1:, here] = np.cumsum(along_y + along_x * turn_between, axis=0)[piece]
