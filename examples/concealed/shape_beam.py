"""A notched tube or an assembled pair under its own weight: a midpoint box scheme on (angle, moment).

Solved by banded Newton.

theta' = k0(s) - M/EI(s),  M' = -(V + P) cos(theta) - H sin(theta),  theta(0) = tilt, M(L) = 0, with V the weight
beyond s, P a downward and H an outward force at the tip. Second order in the element length; every cut and every
ring has `ELEMENTS` of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ELEMENTS = 2


@dataclass(frozen=True)
class Strand:
    """A beam as the solver sees it, element by element.

    Length (m), rigidity (N m^2), weight (N/m), natural curvature (1/m), and how far the strip's axis is off the tube's
    (m): the recorded line stretches by that times the curvature.
    """

    length: Array
    rigidity: Array
    weight: Array
    natural: Array
    axis_offset: Array


@dataclass(frozen=True)
class Shape:
    """Nodes of the solved line (m, rad) and the elements' curvature (1/m)."""

    s: Array
    x: Array
    y: Array
    angle: Array
    curvature: Array


def solve(
    strand: Strand, *, tilt: float = 0.0, down: float = 0.0, outward: float = 0.0, floor: float | None = None
) -> Shape:
    """Equilibrium followed from the weightless shape; `floor` is the height (m) of a table, met by a stiff spring."""
    h, count = strand.length, strand.length.size
    state = np.zeros((count + 1, 2))
    state[1:, 0] = np.cumsum(strand.natural * h)
    state[:, 0] += tilt
    weight = strand.weight
    done, step = 0.0, 0.25
    extra = np.zeros(count)
    while done < 1.0:
        share = min(done + step, 1.0)
        trial = _newton(strand, state.copy(), weight * share - extra, tilt, down * share, outward * share)
        if trial is None:
            step /= 2
            if step < 1e-3:
                raise ArithmeticError("the beam did not settle")
            continue
        state, done = trial, share
    if floor is not None:
        for _ in range(60):
            height = _line(strand, state).y[1:] - floor
            push = np.clip(-height, 0, None) * 2.0 * float(weight.mean()) / 1e-3
            extra = 0.7 * extra + 0.3 * push
            trial = _newton(strand, state.copy(), weight - extra, tilt, down, outward)
            if trial is None:
                break
            state = trial
    return _line(strand, state)


def _newton(strand: Strand, state: Array, weight: Array, tilt: float, down: float, outward: float) -> Array | None:
    from scipy.linalg import solve_banded

    h, compliance, count = strand.length, 1 / strand.rigidity, strand.length.size
    load = weight * h
    beyond = np.cumsum(load[::-1])[::-1] - load / 2 + down
    scale = float(np.max(strand.rigidity))
    size = 2 * (count + 1)
    for _ in range(25):
        theta, moment = state[:, 0], state[:, 1] * scale
        middle = (theta[1:] + theta[:-1]) / 2
        cosine, sine = np.cos(middle), np.sin(middle)
        bend = theta[1:] - theta[:-1] - h * (strand.natural - compliance * (moment[1:] + moment[:-1]) / 2)
        balance = (moment[1:] - moment[:-1] + h * (beyond * cosine + outward * sine)) / scale
        residual = np.empty(size)
        residual[0], residual[-1] = theta[0] - tilt, moment[-1] / scale
        residual[1:-1:2], residual[2:-1:2] = bend, balance
        worst = float(np.abs(residual).max())
        if not np.isfinite(worst) or worst > 1e3:
            return None
        if worst < 1e-13:
            return state
        slope = h * (-beyond * sine + outward * cosine) / 2 / scale
        soft = h * compliance * scale / 2
        # Rows 2i+1: bend, 2i+2: balance; columns 2i: angle, 2i+1: moment. Band storage ab[2 + row - column, column].
        band = np.zeros((5, size))
        band[2, 0], band[2, -1] = 1.0, 1.0
        at = 2 * np.arange(count)
        band[3, at], band[2, at + 1], band[1, at + 2], band[0, at + 3] = -1.0, soft, 1.0, soft
        band[4, at], band[3, at + 1], band[2, at + 2], band[1, at + 3] = slope, -1.0, slope, 1.0
        change = solve_banded((2, 2), band, -residual)
        largest = float(np.abs(change[0::2]).max())
        state = state + change.reshape(-1, 2) * min(1.0, 0.5 / max(largest, 1e-30))
        if largest < 1e-11:
            return state
    return None


def _line(strand: Strand, state: Array) -> Shape:
    h = strand.length
    theta, moment = state[:, 0], state[:, 1] * float(np.max(strand.rigidity))
    curvature = strand.natural - (moment[1:] + moment[:-1]) / 2 / strand.rigidity
    middle = (theta[1:] + theta[:-1]) / 2
    run = h * (1 - strand.axis_offset * curvature)
    # Chord of an arc: exact for the element's uniform curvature.
    chord = run * np.sinc(h * curvature / 2 / np.pi)
    zero = np.zeros(1)
    return Shape(
        np.concatenate([zero, np.cumsum(h)]),
        np.concatenate([zero, np.cumsum(chord * np.cos(middle))]),
        np.concatenate([zero, np.cumsum(chord * np.sin(middle))]),
        theta,
        curvature,
    )
