"""The generalised play: a state that stays where it is until a bound pushes it.

Dry friction, play and snap-through all reduce to it: on a loading branch the state follows the lower bound, on release
the upper one, and in between it waits (Krasnosel'skii and Pokrovskii, Systems with Hysteresis, 1989, ch. 2).
"""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from coast_cli.mechanics.section import FloatArray

_PARTS = np.array([NormalDist().inv_cdf((place + 0.5) / 4) for place in range(4)])
_AT_ONCE = 1e-9  # s, far under any frame


def follow(low: FloatArray, high: FloatArray, rest: FloatArray | float | None = None) -> FloatArray:
    """Return the state s_t = min(max(s_(t-1), low_t), high_t).

    Args:
        low, high: bounds at each row, shape (n,) or (n, m), low <= high.
        rest: state before the first row, shape () or (m,); on the lower bound where not given, as if loaded to it.
    """
    if low.ndim == 2:
        starts = low[:1].reshape(-1) if rest is None else np.broadcast_to(rest, low.shape[1:])
        return np.stack([follow(low[:, j], high[:, j], starts[j]) for j in range(low.shape[1])], axis=1)
    state = -np.inf if rest is None else float(rest)
    states = []
    for below, above in zip(low.tolist(), high.tolist(), strict=True):
        state = below if state < below else state  # noqa: FURB136 -- half the time of max and min on this hot path
        state = above if state > above else state  # noqa: FURB136
        states.append(state)
    return np.array(states)


def waiting_parts(rounding: float) -> tuple[float, ...]:
    """Return the widths, mean 1, of parts of the path that wait for more and for less, side by side (Prandtl and Ishlinskii).

    Args:
        rounding: standard deviation of ln of the width along the path; without any there is one part.
    """
    if rounding == 0.0:
        return (1.0,)
    width = np.exp(rounding * _PARTS)
    return tuple((width / width.mean()).tolist())


def relax(target: FloatArray, time: FloatArray, time_constant: float, start: FloatArray | float) -> FloatArray:
    """Return y with dy/dt = (target - y)/time_constant, the target linear between rows (exact step).

    Args:
        target: shape (n,) or (n, m). time: s, shape (n,). time_constant: s. start: value at the first row.
    """
    if time_constant <= _AT_ONCE:
        return target
    step = np.maximum(np.diff(time), 0.0) / time_constant
    decay = np.exp(-step)
    tiny = step < 1e-8
    ramp = np.where(tiny, step / 2.0, 1.0 + np.expm1(-step) / np.where(tiny, 1.0, step))
    shape = (-1,) + (1,) * (target.ndim - 1)
    drift = (1.0 - decay - ramp).reshape(shape) * target[:-1] + ramp.reshape(shape) * target[1:]
    out = np.empty_like(target)
    if out.shape[0] == 0:
        return out
    out[0] = start
    if target.ndim == 1:
        value, values = float(out[0]), []
        for keep, add in zip(decay.tolist(), drift.tolist(), strict=True):
            value = keep * value + add
            values.append(value)
        out[1:] = values
        return out
    for row in range(1, out.shape[0]):
        out[row] = decay[row - 1] * out[row - 1] + drift[row - 1]
    return out
