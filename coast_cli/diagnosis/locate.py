"""Where the mismatch is, before anything is named: the region outside which the base model would agree.

For every axis the region is sought whose samples, left out of the refit, leave the rest at the noise while they
themselves stand out: the best description of the residual by two variances, base parameters refitted outside. Sums over
a dozen bins of each axis give every interval at once. A region's p-value pays for every region of its axis and for every
axis. Which axes there are is the recording's to say.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.space import Booleans
from coast_cli.diagnosis.thresholds import EVEN_AXIS, FEWEST_IN_REGION, SIGNIFICANT
from coast_cli.mechanics.section import FloatArray

_BINS = 16
_MOST_VALUES = 64
_RIDGE = 1e-9  # of the mean square of how the samples move with a base parameter
_UNSEEN = 1e-12  # of the noise's variance
# Axes that merely go along with others count less where shares are equal.
_INCIDENTAL = {"time": 0.6, "run": 0.6, "cycle": 0.6, "rate": 0.6}


@dataclass(frozen=True, slots=True)
class Region:
    """A part of the recording that holds excess error.

    Attributes:
        axis: as in the contract, e.g. "direction". value: a discrete place, or None. low, high: of an interval.
        share: of the excess error. p_value: of a region that stands out as much by chance, all looks paid for.
        nats: by which two variances describe the residual better than one; breaks ties of the share.
    """

    axis: str
    value: str | None
    low: float | None
    high: float | None
    share: float
    p_value: float
    nats: float = 0.0


@dataclass(frozen=True, slots=True)
class Samples:
    """Residual (n,), how it moves with base parameters in prior widths (n, p), and each axis' value of every sample."""

    residual: FloatArray
    directions: FloatArray
    continuous: Mapping[str, FloatArray]
    discrete: Mapping[str, NDArray[np.str_]]


def locate(samples: Samples, noise: float, correlation: float) -> tuple[Region, ...]:
    """Return the regions that hold the base model's excess error, largest share first; none where it agrees.

    Args:
        noise: level, in the residual's unit. correlation: of it between neighbours, by which evidence is worth less.
    """
    floor = max(noise, 1e-15) ** 2
    known = float(np.clip(correlation, 0.0, 0.95))
    looks = Counter(axis for axis, _ in _groups(samples))
    regions = []
    for axis, inside in _best_by_axis(samples, floor):
        gain, excess_in, excess_out = _two_variances(samples, inside, floor)
        p_value = min(1.0, len(looks) * looks[axis] * np.exp(min(-gain * (1.0 - known) / (1.0 + known), 0.0)))
        if p_value > SIGNIFICANT or np.all(inside):
            continue
        share = excess_in / max(excess_in + excess_out, 1e-300)
        regions.append(_region(samples, axis, inside, _coarse(share), float(p_value), gain))
    return in_order_of_share(regions)


def in_order_of_share(regions: Sequence[Region]) -> tuple[Region, ...]:
    """Return regions by share; equal ones by what stands out more to a tenth of a nat, then as axes are listed."""
    return tuple(sorted(regions, key=lambda r: (-r.share, -round(r.nats * _INCIDENTAL.get(r.axis, 1.0), 1))))


def _coarse(share: float) -> float:
    """Return a share to the 5 % that it is known to, so that near equals are ordered by what stands out more."""
    return float(np.clip(round(20.0 * share) / 20.0, 0.0, 1.0))


def _groups(samples: Samples) -> Iterator[tuple[str, Booleans]]:
    """Yield every region that is looked at, as its axis and its samples."""
    for axis, names in samples.discrete.items():
        distinct = np.unique(names)
        if 1 < distinct.size <= _MOST_VALUES:
            for name in distinct:
                yield axis, names == name
    for axis, values in samples.continuous.items():
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, _BINS + 1)))
        usual = np.quantile(values, (0.1, 0.9))
        if edges.size < 3 or usual[1] - usual[0] < EVEN_AXIS * np.max(np.abs(values)):
            continue
        place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
        for first in range(edges.size - 1):
            for last in range(first, edges.size - 1):
                if (first, last) != (0, edges.size - 2):
                    yield axis, (place >= first) & (place <= last)


def _best_by_axis(samples: Samples, floor: float) -> list[tuple[str, Booleans]]:
    best: dict[str, tuple[float, Booleans]] = {}
    for axis, inside in _groups(samples):
        if int(inside.sum()) < FEWEST_IN_REGION or int((~inside).sum()) < FEWEST_IN_REGION:
            continue
        gain = _two_variances(samples, inside, floor)[0]
        if axis not in best or gain > best[axis][0]:
            best[axis] = gain, inside
    return [(axis, inside) for axis, (_, inside) in best.items()]


def _two_variances(samples: Samples, inside: Booleans, floor: float) -> tuple[float, float, float]:
    """Return the gain (nats) over one variance, and the excess squared error inside and outside a region."""
    outside = ~inside
    directions, residual = samples.directions[outside], samples.residual[outside]
    step = _refitted(directions, residual, samples.directions, floor)
    left = (samples.residual - samples.directions @ step) ** 2
    within, without = left[inside], left[outside]
    before = float(np.mean(samples.residual**2)) + 0.1 * floor
    after_in, after_out = float(np.mean(within)) + 0.1 * floor, float(np.mean(without)) + 0.1 * floor
    gain = 0.5 * (residual.size + within.size) * np.log(before)
    gain -= 0.5 * (within.size * np.log(after_in) + residual.size * np.log(after_out))
    if after_in <= after_out:
        return 0.0, 0.0, 1.0
    noise = min(floor, after_out)
    return float(gain), float(max(np.sum(within - noise), 0.0)), float(max(np.sum(without - noise), 0.0))


def _refitted(directions: FloatArray, residual: FloatArray, everywhere: FloatArray, floor: float) -> FloatArray:
    """Return base parameters refitted to some samples; a ridge scaled by all of them holds what these do not show.

    What moves no sample by a millionth of the noise is rounding, which differs from processor to processor.
    """
    count = directions.shape[1]
    if count == 0:
        return np.zeros(0)
    scale = np.sqrt(np.maximum(np.mean(everywhere**2, axis=0), _UNSEEN * floor))
    unit = directions / scale
    normal = unit.T @ unit + _RIDGE * everywhere.shape[0] * np.eye(count)
    return np.asarray(np.linalg.solve(normal, unit.T @ residual) / scale)


def _region(samples: Samples, axis: str, inside: Booleans, share: float, p_value: float, nats: float) -> Region:
    if axis in samples.discrete:
        return Region(axis, str(samples.discrete[axis][inside][0]), None, None, share, p_value, nats)
    values = samples.continuous[axis][inside]
    return Region(axis, None, float(values.min()), float(values.max()), share, p_value, nats)
