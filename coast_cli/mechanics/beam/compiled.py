"""Many tips at once, compiled: the plain-Python step of ``step`` made into vector instructions by numba.

The optional extra ``[fast]``; import this module only where numba is installed. Sixteen beams go side by side through
every march, which fills the vector registers; loops go upward, or the compiler's overlap checks spoil that. Beams out
of the ordinary (several equilibria, very soft, pieces that must be divided) are left to the numpy solver. Both agree
to 1e-12.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from math import cos, sin, sqrt
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam import step as beam_step
from coast_cli.mechanics.beam.solve import FINE_TURN, LAST_CHANGE, ROUNDING, TANGENT_ERROR
from coast_cli.mechanics.beam.start import COARSE_CELLS, COARSE_TURN, LEAST_SLOPE, SHARES, SMOOTH, SURELY_ONE, SURVEY
from coast_cli.mechanics.section import FloatArray

LANES = 16
_ROWS = 8  # laid out at a time, so that they stay in the first cache
_LIGHT_STEPS = 12
_options: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"contract", "nsz", "arcp"},
    "nogil": True,
    "cache": True,
}
_turn = numba.njit(**_options, inline="always")(beam_step.segment_turn)
_tangent = numba.njit(**_options, inline="always")(beam_step.segment_tangent)
_displacement = numba.njit(**_options, inline="always")(beam_step.segment_displacement)


def solve_share(
    pieces: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    loads: tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray],
    *,
    threads: int,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return tip angle (rad), x, y (m) and residual (rad), shape (4, m), and which beams are solved.

    Args:
        pieces: length, rigidity, weight and natural curvature, each (m, n), broadcast views allowed.
        loads: size of gravity, thrust, shear and moment at the tip, base angle, each (m,).
        threads: how many to use.
    """
    turns = np.zeros((0, 0))
    tips, solved = _solved(pieces, loads, turns, threads=threads)
    return tips, solved


def solve_turns(
    pieces: tuple[FloatArray, FloatArray, FloatArray, FloatArray], gravity: float, *, threads: int = 1
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the turn of every piece under gravity (m/s^2) alone, rad, shape (m, n), and which beams are solved."""
    nothing = np.zeros(len(pieces[0]))
    turns = np.zeros(pieces[0].shape)
    loads = (nothing + gravity, nothing, nothing, nothing, nothing)
    _, solved = _solved(pieces, loads, turns, threads=threads)
    return turns, solved


def _solved(
    pieces: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    loads: tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray],
    turns: FloatArray,
    *,
    threads: int,
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Solve for the tips, and for the turn of every piece where ``turns`` has room for them."""
    count, nodes = pieces[0].shape
    tips, solved = np.zeros((4, count)), np.zeros(count, dtype=np.bool_)
    chosen = np.unique(np.linspace(0, (nodes - 1) // 2, COARSE_CELLS).round().astype(np.int64)) * 2
    if nodes <= 2 * COARSE_CELLS:
        return tips, solved
    chosen = (nodes - 1 - chosen)[::-1].copy()
    bounds = np.linspace(0, count, threads + 1).astype(int).tolist()

    kernel: Any = _solve_lanes

    def run(low: int, high: int) -> None:
        part = slice(low, high)
        columns = [p[part] for p in pieces]
        kernel(*columns, np.stack([v[part] for v in loads]), chosen, tips[:, part], solved[part], turns[part])

    if threads == 1:
        run(0, count)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(run, bounds[:-1], bounds[1:]))
    return tips, solved


@numba.njit(**_options)
def _march(pieces, loads, share, state):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """March with tangent; state rows: angle, cosine, sine, moment, shear, slope, moment slope."""
    for j in range(LANES):
        state[1, j], state[2, j] = cos(state[0, j]), sin(state[0, j])
        state[3, j], state[4, j] = loads[3, j], loads[2, j] * share
        state[5, j], state[6, j] = 1.0, 0.0
    for i in range(pieces.shape[0]):
        for j in range(LANES):
            length, flexibility, load = pieces[i, 0, j], pieces[i, 1, j], pieces[i, 3, j] * share
            turn, cosine, sine, moment, forces, series = _turn(
                length,
                flexibility,
                pieces[i, 2, j],
                load,
                loads[1, j] * share,
                state[1, j],
                state[2, j],
                state[3, j],
                state[4, j],
            )
            state[5, j], state[6, j] = _tangent(length, flexibility, forces, series, state[5, j], state[6, j])
            state[0, j] += turn
            state[1, j], state[2, j], state[3, j] = cosine, sine, moment
            state[4, j] += load


@numba.njit(**_options)
def _march_tip(pieces, loads, state):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """March with tangent and places; further state rows: x, y of the tip and their derivatives by its angle."""
    for j in range(LANES):
        state[1, j], state[2, j] = cos(state[0, j]), sin(state[0, j])
        state[3, j], state[4, j] = loads[3, j], loads[2, j]
        state[5, j], state[6, j] = 1.0, 0.0
        state[7, j], state[8, j], state[9, j], state[10, j] = 0.0, 0.0, 0.0, 0.0
    for i in range(pieces.shape[0]):
        for j in range(LANES):
            length, flexibility = pieces[i, 0, j], pieces[i, 1, j]
            turn, cosine, sine, moment, forces, series = _turn(
                length,
                flexibility,
                pieces[i, 2, j],
                pieces[i, 3, j],
                loads[1, j],
                state[1, j],
                state[2, j],
                state[3, j],
                state[4, j],
            )
            along_x, along_y = _displacement(length, state[1, j], state[2, j], series)
            slope, moment_slope = _tangent(length, flexibility, forces, series, state[5, j], state[6, j])
            mean_slope = 0.5 * (slope + state[5, j])
            state[7, j] += along_x
            state[8, j] += along_y
            state[9, j] -= along_y * mean_slope
            state[10, j] += along_x * mean_slope
            state[0, j] += turn
            state[1, j], state[2, j], state[3, j] = cosine, sine, moment
            state[4, j] += pieces[i, 3, j]
            state[5, j], state[6, j] = slope, moment_slope


@numba.njit(**_options)
def _march_nodes(pieces, loads, state, trace):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """March with tangent; trace takes the turn of each piece and the derivative at its clamp side."""
    for j in range(LANES):
        state[1, j], state[2, j] = cos(state[0, j]), sin(state[0, j])
        state[3, j], state[4, j] = loads[3, j], loads[2, j]
        state[5, j], state[6, j] = 1.0, 0.0
    for i in range(pieces.shape[0]):
        for j in range(LANES):
            length, flexibility = pieces[i, 0, j], pieces[i, 1, j]
            turn, cosine, sine, moment, forces, series = _turn(
                length,
                flexibility,
                pieces[i, 2, j],
                pieces[i, 3, j],
                loads[1, j],
                state[1, j],
                state[2, j],
                state[3, j],
                state[4, j],
            )
            state[5, j], state[6, j] = _tangent(length, flexibility, forces, series, state[5, j], state[6, j])
            state[0, j] += turn
            state[1, j], state[2, j], state[3, j] = cosine, sine, moment
            state[4, j] += pieces[i, 3, j]
            trace[i, 0, j], trace[i, 1, j] = turn, state[5, j]


@numba.njit(**_options)
def _put_turns(trace, change, first, turns):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Correct the turns of the beams side by side for the last change of the tip, and lay them out from the clamp."""
    nodes = trace.shape[0]
    for low in range(0, nodes, _ROWS):
        high = min(low + _ROWS, nodes)
        for j in range(min(LANES, turns.shape[0] - first)):
            for i in range(low, high):
                before = trace[i - 1, 1, j] if i > 0 else 1.0
                turns[first + j, nodes - 1 - i] = (trace[i, 1, j] - before) * change[j] - trace[i, 0, j]


@numba.njit(**_options)
def _prepare(length, rigidity, weight, curvature, first, gravity, pieces):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Lay the pieces out from tip to clamp: length, flexibility, bend, load of the beams side by side."""
    last, nodes = length.shape[0] - 1, length.shape[1]
    for low in range(0, nodes, _ROWS):
        high = min(low + _ROWS, nodes)
        for j in range(LANES):
            t = min(first + j, last)
            for i in range(low, high):
                pieces[nodes - 1 - i, 0, j] = length[t, i]
                pieces[nodes - 1 - i, 1, j] = rigidity[t, i]
                pieces[nodes - 1 - i, 2, j] = curvature[t, i]
                pieces[nodes - 1 - i, 3, j] = weight[t, i]
        for i in range(nodes - high, nodes - low):
            for j in range(LANES):
                h = pieces[i, 0, j]
                pieces[i, 1, j] = h / pieces[i, 1, j]
                pieces[i, 2, j] *= h
                pieces[i, 3, j] *= h * gravity[j]


@numba.njit(**_options)
def _merge(pieces, chosen, cells):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Homogenise as ``BeamProblem.coarse`` does: cells end in the middle of the chosen pieces."""
    source, target = pieces.reshape(pieces.shape[0], 4 * LANES), cells.reshape(cells.shape[0], 4 * LANES)
    target[:] = 0.0
    first = 0
    for c in range(chosen.size):
        for i in range(first, chosen[c]):
            for j in range(4 * LANES):
                target[c, j] += source[i, j]
        for j in range(4 * LANES):
            half = 0.5 * source[chosen[c], j]
            target[c, j] += half
            target[c + 1, j] += half
        first = chosen[c] + 1


@numba.njit(**_options)
def _load_numbers(cells, loads, number, plain):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Find the load numbers; plain where no cell can turn by more than the coarse step allows."""
    for j in range(LANES):
        number[j], plain[j], compliance = 0.0, True, 0.0
        for i in range(cells.shape[0]):
            compliance += cells[i, 1, j]
        shear, moment = loads[2, j], abs(loads[3, j])
        for i in range(cells.shape[0]):
            force = sqrt(loads[1, j] ** 2 + max(abs(shear), abs(shear + cells[i, 3, j])) ** 2)
            shear += cells[i, 3, j]
            number[j] += (compliance - 0.5 * cells[i, 1, j]) * cells[i, 0, j] * force
            compliance -= cells[i, 1, j]
            moment += cells[i, 0, j] * force
            by_force = 2.0 * sqrt(cells[i, 0, j] * cells[i, 1, j] * force)
            plain[j] &= max(abs(cells[i, 2, j]) + cells[i, 1, j] * moment, by_force) <= COARSE_TURN


@numba.njit(**_options)
def _fine_enough(pieces, loads, state, largest, plain):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    state[:4] = 0.0
    for i in range(pieces.shape[0]):
        for j in range(LANES):
            state[0, j] = max(state[0, j], pieces[i, 0, j])
            state[1, j] = max(state[1, j], pieces[i, 1, j])
            state[2, j] = max(state[2, j], abs(pieces[i, 2, j]))
            state[3, j] += abs(pieces[i, 3, j])
    for j in range(LANES):
        force = state[3, j] + sqrt(loads[1, j] ** 2 + loads[2, j] ** 2)
        most = max(state[2, j] + state[1, j] * largest[j], 2.0 * sqrt(state[0, j] * state[1, j] * force))
        plain[j] &= most <= FINE_TURN


@numba.njit(**_options)
def _survey(cells, loads, unloaded, number, state, plain):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Keep a beam plain where the clamp's error surely crosses zero once, as in ``start``."""
    error, slope = np.zeros(LANES), np.zeros(LANES)
    crossings = np.zeros(LANES)
    for k in range(SURVEY.size):
        for j in range(LANES):
            state[0, j] = unloaded[j] + SURVEY[k] * number[j]
        _march(cells, loads, 1.0, state)
        for j in range(LANES):
            new_error, new_slope = state[0, j] - loads[4, j], state[5, j]
            if k > 0:
                half = number[j] * (SURVEY[1] - SURVEY[0]) / 2.0
                far = min(abs(new_error), abs(error[j])) > half * max(abs(new_slope), abs(slope[j]))
                same_side = new_error * error[j] > 0.0
                crossings[j] += 0.0 if same_side else 1.0
                plain[j] &= min(new_slope, slope[j]) > 0.0 or (far and same_side)
            error[j], slope[j] = new_error, new_slope
    for j in range(LANES):
        plain[j] &= crossings[j] == 1.0


@numba.njit(**_options)
def _start(cells, loads, number, state, tip, slope, plain):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Solve the coarse beams: light ones by Newton's method, others by growing the load."""
    unloaded, before, predicted = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    heavy = False
    for j in range(LANES):
        total = loads[4, j]
        for i in range(cells.shape[0]):
            total += cells[i, 2, j] + cells[i, 1, j] * loads[3, j]
        unloaded[j], before[j], tip[j] = total, total, total
        heavy |= number[j] >= SURELY_ONE
    if heavy:
        _survey(cells, loads, unloaded, number, state, plain)
    last, now = -1.0, 0.0
    for k in range(SHARES.size):
        share = SHARES[k]
        if not heavy and share < 1.0:
            continue
        final = share == 1.0
        for j in range(LANES):
            predicted[j] = tip[j] + (tip[j] - before[j]) * (share - now) / (now - last)
            before[j], tip[j] = tip[j], predicted[j]
        last, now = now, share
        enough = 1e-4 if final else 0.03
        for _ in range(_LIGHT_STEPS if final else 4):
            state[0, :] = tip
            _march(cells, loads, share, state)
            largest = 0.0
            for j in range(LANES):
                slope[j] = state[5, j]
                change = (state[0, j] - loads[4, j]) / max(slope[j], LEAST_SLOPE)
                tip[j] -= change
                light = number[j] < SURELY_ONE
                plain[j] &= light or slope[j] > LEAST_SLOPE
                largest = max(largest, abs(change))
            if largest < enough:
                break
        for j in range(LANES):
            plain[j] &= number[j] < SURELY_ONE or abs(tip[j] - predicted[j]) < SMOOTH
    return largest


@numba.njit(**_options)
def _largest_moment(cells, loads, state, tip, largest):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return the largest internal moment of the coarse beam."""
    state[0, :] = tip
    for j in range(LANES):
        state[1, j], state[2, j] = cos(state[0, j]), sin(state[0, j])
        state[3, j], state[4, j] = loads[3, j], loads[2, j]
        largest[j] = abs(loads[3, j])
    for i in range(cells.shape[0]):
        for j in range(LANES):
            _, state[1, j], state[2, j], state[3, j], _, _ = _turn(
                cells[i, 0, j],
                cells[i, 1, j],
                cells[i, 2, j],
                cells[i, 3, j],
                loads[1, j],
                state[1, j],
                state[2, j],
                state[3, j],
                state[4, j],
            )
            state[4, j] += cells[i, 3, j]
            largest[j] = max(largest[j], abs(state[3, j]))


_Columns = numba.types.Array(numba.float64, 2, "A", readonly=True)  # one signature for all layouts: compiled once
_Table = numba.types.Array(numba.float64, 2, "A")


@numba.njit(
    numba.void(*[_Columns] * 4, numba.float64[:, ::1], numba.int64[::1], _Table, numba.boolean[::1], _Table), **_options
)
def _solve_lanes(length, rigidity, weight, curvature, all_loads, chosen, tips, solved, turns):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    count, nodes = length.shape
    trace, wanted, changes = np.empty((nodes, 2, LANES)), turns.shape[0] > 0, np.empty(LANES)
    pieces, cells = np.empty((nodes, 4, LANES)), np.empty((chosen.size + 1, 4, LANES))
    state, loads = np.empty((11, LANES)), np.empty((5, LANES))
    number, tip, slope, largest = np.empty(LANES), np.empty(LANES), np.empty(LANES), np.empty(LANES)
    plain = np.empty(LANES, dtype=np.bool_)
    for first in range(0, count, LANES):
        for j in range(LANES):
            loads[:, j] = all_loads[:, min(first + j, count - 1)]
        _prepare(length, rigidity, weight, curvature, first, loads[0], pieces)
        _merge(pieces, chosen, cells)
        _load_numbers(cells, loads, number, plain)
        _start(cells, loads, number, state, tip, slope, plain)
        _largest_moment(cells, loads, state, tip, largest)
        _fine_enough(pieces, loads, state, largest, plain)
        state[0, :] = tip
        _march(pieces, loads, 1.0, state)
        for j in range(LANES):
            tip[j] -= (state[0, j] - loads[4, j]) / state[5, j]
        state[0, :] = tip
        if wanted:
            _march_nodes(pieces, loads, state, trace)
        else:
            _march_tip(pieces, loads, state)
        for j in range(LANES):
            changes[j] = (state[0, j] - loads[4, j]) / state[5, j]
        if wanted:
            _put_turns(trace, changes, first, turns)
        for j in range(min(LANES, count - first)):
            t, change = first + j, changes[j]
            tips[0, t] = tip[j] - change
            tips[1, t] = state[7, j] - change * state[9, j]
            tips[2, t] = state[8, j] - change * state[10, j]
            tips[3, t] = abs(state[5, j]) * (TANGENT_ERROR * abs(change) + ROUNDING)
            solved[t] = plain[j] and abs(change) <= LAST_CHANGE
