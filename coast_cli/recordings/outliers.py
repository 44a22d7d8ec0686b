"""Samples that stand alone: far from what the samples before them and the samples after them lead to.

Two looks are taken in turn. Fourth differences see a lone sample as 1 -4 6 -4 1 on however curved a signal, but not one
that has another close by; lines through the medians of both sides see those, where the signal is hardly curved.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SIDE = 5  # neighbours on each side that a line is put through
BLOCK = 32  # samples that share a scale, as a device that sticks and slips is quiet where it sticks
FAR = 5.5  # standard deviations of what neighbours usually miss by
MOST = 0.15  # of all samples: more are no outliers
PASSES = 4  # outliers close together hide one another, so the rest is looked at again
FEWEST = 12
ALONE = 0.2  # of how far a sample is off: a neighbour that is closer to it is in the same place
SPIKE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
ALIKE = (  # what a change of slope, a jump or a kink between samples look like instead
    np.array([0.0, 1.0, -2.0, 1.0, 0.0]),
    np.array([0.0, 1.0, -1.0, -1.0, 1.0]),
    np.array([1.0, -1.0, -1.0, 1.0, 0.0]),
    np.array([0.0, 1.0, -3.0, 3.0, -1.0]),
    np.array([1.0, -3.0, 3.0, -1.0, 0.0]),
)
_FIRST, _SECOND = np.triu_indices(SIDE, 1)


def find_outliers(values: Floats) -> NDArray[np.bool_]:
    """Return which samples stand alone, [n]; NaN never does.

    A change of slope and a jump agree with the neighbours on one of their sides, and are kept.
    """
    outlier = np.zeros(len(values), dtype=bool)
    index = np.flatnonzero(np.isfinite(values))
    most = MOST * len(index)
    for _ in range(PASSES):
        found = index[np.union1d(_spikes(values[index]), _beside_both(values[index]))]
        if not len(found) or outlier.sum() + len(found) > most:
            break
        outlier[found] = True
        index = index[~outlier[index]]
    return outlier


def _spikes(values: Floats) -> NDArray[np.int64]:
    """Return the places of lone samples by fourth differences."""
    if len(values) < FEWEST:
        return np.zeros(0, dtype=np.int64)
    fourth = np.diff(values, 4)
    windows = np.lib.stride_tricks.sliding_window_view(np.concatenate((np.zeros(2), fourth, np.zeros(2))), 5)
    along = windows @ SPIKE
    size = np.abs(along) / float(SPIKE @ SPIKE)
    rivals = np.max([(windows @ other) ** 2 / float(other @ other) for other in ALIKE], axis=0)
    peak = size >= np.maximum.reduce([np.roll(size, shift) for shift in (-2, -1, 1, 2)])
    far = size * 6.0 > FAR * _scale(np.abs(fourth))
    return 2 + np.flatnonzero(peak & far & (along**2 / float(SPIKE @ SPIKE) > rivals))


def _beside_both(values: Floats) -> NDArray[np.int64]:
    """Return the places of samples that lie to one side of what both their sides lead to."""
    count = len(values)
    if count < FEWEST:
        return np.zeros(0, dtype=np.int64)
    before, after = np.full(count, np.nan), np.full(count, np.nan)
    before[SIDE:] = values[SIDE:] - _next_of(values)
    after[: count - SIDE] = values[: count - SIDE] - _next_of(values[::-1])[::-1]
    before[:SIDE], after[count - SIDE :] = after[:SIDE], before[count - SIDE :]
    beside = np.where(np.sign(before) == np.sign(after), np.minimum(np.abs(before), np.abs(after)), 0.0)
    beside[:SIDE] = beside[count - SIDE :] = 0.0  # which have one side only
    step = np.abs(np.diff(values, prepend=values[0], append=values[-1]))
    beside[np.minimum(step[1:], step[:-1]) < ALONE * beside] = 0.0  # a short plateau between two slopes
    return np.flatnonzero(beside > FAR * _scale(0.5 * (np.abs(before) + np.abs(after))))


def _next_of(values: Floats) -> Floats:
    """Return where the line through each `SIDE` samples leads, by medians, so that one of them may be wrong."""
    window = np.lib.stride_tricks.sliding_window_view(values, SIDE)[:-1]
    slope = np.median((window[:, _SECOND] - window[:, _FIRST]) / (_SECOND - _FIRST), axis=1)
    led: Floats = np.median(window - slope[:, None] * (np.arange(SIDE) - SIDE), axis=1)
    return led


def _scale(missed: Floats) -> Floats:
    """Return the usual size of what neighbours miss by: of the blocks around a sample, and at least that of all."""
    size = min(BLOCK, len(missed))
    count = len(missed) // size
    usual = np.median(missed[: count * size].reshape(count, size), axis=1)
    around = np.maximum(usual, np.maximum(np.append(usual[1:], 0.0), np.append(0.0, usual[:-1])))
    each = np.repeat(around, np.append(np.full(count - 1, size), len(missed) - (count - 1) * size))
    scale: Floats = np.maximum(each, float(np.median(missed))) / 0.6744897501960817
    return scale
