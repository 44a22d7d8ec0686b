"""What recordings of other benches get wrong: frames that repeat, views that end, clocks that stand, swings, noisy drives.

Nothing is left out in silence: each fault is a sentence with its share, and rows that hold no news of the response
(`frozen`, `clipped`) can be asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.branches import difference_noise

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Booleans = NDArray[np.bool_]
    Floats = NDArray[np.float64]

CHANCE_OF_A_REPEAT = 0.05  # above it rounding makes neighbours equal often enough
MORE_THAN_CHANCE = 3.0
FEWEST_REPEATS = 3
CATCH_UP = 2.5  # usual steps: what a frame that stood makes up for when it moves again
FEWEST_CLIPPED = 5
CLIPPED_OF_NEXT = 4.0  # samples on the last level, to those a step below it


def quantum_of(values: Floats) -> float:
    """Return the step that all differences are whole multiples of, or 0 where there is none."""
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < 3:
        return 0.0
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * (levels[-1] - levels[0])]
    step = float(gaps.min())
    for _ in range(2):
        step = float(gaps.sum() / np.round(gaps / step).sum())
    off = np.abs(gaps / step - np.round(gaps / step))
    return step if float(off.max()) < 0.05 else 0.0


def frozen_rows(response: Floats, drive: Floats | None = None) -> Booleans:
    """Return which rows repeat the frame before them though the drive moves, [n].

    Args:
        response: [n] or [n, k]; a row repeats where all its values do. NaN repeats nothing.
        drive: [n]; where it stays, a response may stay too. None where it always moves.

    Where rounding makes neighbours equal anyway, only rows count after which the response makes up for what it missed:
    a device that rests in its play moves on in small steps, a frozen one jumps.
    """
    rows = response[:, None] if response.ndim == 1 else response
    frozen = np.zeros(len(rows), dtype=bool)
    if len(rows) < 8:
        return frozen
    same = np.append(False, (rows[1:] == rows[:-1]).all(axis=1))
    if drive is not None:
        same[1:] &= np.diff(drive) != 0.0
    count = int(same.sum())
    if count < FEWEST_REPEATS:
        return frozen
    moved = rows[~same & np.isfinite(rows).all(axis=1)]
    by_chance = 1.0
    for column in moved.T:
        noise, step = difference_noise(column), quantum_of(column)
        by_chance *= min(0.5 * step / (np.sqrt(np.pi) * noise), 1.0) if noise > 1e-9 * float(np.ptp(column)) else 1.0
    if by_chance < CHANCE_OF_A_REPEAT:
        return same if count > MORE_THAN_CHANCE * (by_chance * len(rows) + 1.0) else frozen
    return _made_up_for(rows, same)


def _made_up_for(rows: Floats, same: Booleans) -> Booleans:
    """Return which repeats end in a jump that steps elsewhere do not make."""
    frozen = np.zeros(len(rows), dtype=bool)
    step = np.abs(np.diff(rows, axis=0)).max(axis=1)
    usual = step[~same[1:] & ~same[:-1] & np.isfinite(step)]
    if len(usual) < 8:
        return frozen
    limit = CATCH_UP * float(np.quantile(usual, 0.9))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], same.astype(np.int8), [0]))))
    jumps = [
        (start, stop)
        for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        if stop < len(rows) and step[stop - 1] > limit
    ]
    if len(jumps) >= FEWEST_REPEATS:
        for start, stop in jumps:
            frozen[start:stop] = True
    return frozen


def clipped_rows(values: Floats, drive: Floats) -> Booleans:
    """Return which samples of one response stand at the level that its view ends at, [n].

    The level is the largest or smallest of the run, met while the drive still moves on towards it: a device that rests
    in its play only does so after the drive has turned.
    """
    clipped = np.zeros(len(values), dtype=bool)
    finite = np.isfinite(values)
    if finite.sum() < 4 * FEWEST_CLIPPED or np.ptp(values[finite]) == 0.0:
        return clipped
    rows = np.flatnonzero(finite)
    seen, pulled = values[rows], drive[rows]
    follows = float(np.sign(np.cov(pulled, seen)[0, 1])) if np.ptp(pulled) > 0.0 else 0.0
    moving = np.append(0.0, np.sign(np.diff(pulled)))
    step = quantum_of(seen)
    for side in (1.0, -1.0):
        level = float((side * seen).max())
        at = side * seen >= level - 1e-9 * max(abs(level), float(np.ptp(seen)))
        towards = at & np.append(False, at[:-1]) & (moving * follows == side)
        beside = np.abs(side * seen - (level - step)) < 0.25 * step
        if towards.sum() >= FEWEST_CLIPPED and at.sum() > CLIPPED_OF_NEXT * (beside.sum() if step > 0.0 else 0.0):
            clipped[rows[at]] = True
    return clipped


@dataclass(frozen=True)
class Swing:
    """A disturbance that swings with a period of its own.

    Attributes:
        period: s. amplitude: of the response, in its unit.
        share: of what the drive does not explain, how much swings.
    """

    period: float
    amplitude: float
    share: float
