"""Roots of one equation in one unknown, for many independent cases at once: Newton's method kept inside a bracket."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from coast_cli.mechanics.section import FloatArray

Evaluation = tuple[FloatArray, FloatArray]


def increasing_root(
    function: Callable[[FloatArray], Evaluation], start: FloatArray, *, tolerance: float, most_steps: int = 60
) -> tuple[FloatArray, FloatArray, int]:
    """Solve f(x) = 0 for functions that increase, element by element.

    Args:
        function: x to (f, f'), arrays of the shape of ``start``.
        start: any finite values; the bracket is found on the way.
        tolerance: on the last step, absolute.
        most_steps: after which the last step tells how far it came.

    Returns:
        The root, the size of the last step and the number of evaluations.
    """
    x = np.array(start, dtype=float)
    low, high = np.full_like(x, -np.inf), np.full_like(x, np.inf)
    change = np.full_like(x, np.inf)
    for evaluations in range(1, most_steps + 1):
        value, slope = function(x)
        low, high = np.where(value <= 0.0, x, low), np.where(value >= 0.0, x, high)
        newton = x - value / np.where(slope > 0.0, slope, 1.0)
        bracketed = np.isfinite(low) & np.isfinite(high)
        inside = (newton > low) & (newton < high)
        halved = 0.5 * (np.where(bracketed, low, x) + np.where(bracketed, high, x))
        new = np.where(inside | ~bracketed | (value == 0.0), newton, halved)
        new = np.where(np.isfinite(new), new, x)
        change = np.abs(new - x)
        x = new
        if not np.any(change > tolerance):
            return x, change, evaluations
    return x, change, most_steps
