"""Where the mismatch is, before anything is named: the region outside which the base model would agree.

For every axis the region is sought whose samples, left out of the refit, leave the rest at the noise while they
themselves stand out: the best description of the residual by two variances, base parameters refitted outside. Sums over
a dozen bins of each axis give every interval at once. A region's p-value pays for every region of its axis and for every axis.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.problem import Problem
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

_BINS = 16
_FEWEST = 8
_EVEN = 0.02  # an axis that spreads less than this is one value with jitter
# Axes that merely go along with others count less where shares are equal.
_INCIDENTAL = {"time": 0.6, "run": 0.6, "cycle": 0.6, "rate": 0.6}
_SIGNIFICANT = 0.01


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
class _Samples:
    """Residual (n,), sensitivity to base parameters (n, p), and each axis' value of every fitted sample."""

    residual: FloatArray
    directions: FloatArray
    continuous: dict[str, FloatArray]
    discrete: dict[str, NDArray[np.str_]]


def locate(problem: Problem, base: Fit) -> tuple[Region, ...]:
    """Return the regions that hold the base model's excess error, largest share first; none where it agrees."""
    samples = _collect(problem, base)
    floor = max(problem.noise, 1e-15) ** 2
    memory = min(base.evidence.memory, problem.noise_estimate.correlation)
    correlation = float(np.clip(memory, 0.0, 0.95))
    looks = Counter(axis for axis, _ in _groups(samples))
    regions = []
    for axis, inside in _best_by_axis(samples, floor):
        outside = ~inside
        gain, excess_in, excess_out = _two_variances(samples, inside, floor)
        p_value = min(1.0, len(looks) * looks[axis] * np.exp(-gain * (1.0 - correlation) / (1.0 + correlation)))
        if p_value > _SIGNIFICANT or not np.any(outside):
            continue
        share = excess_in / max(excess_in + excess_out, 1e-300)
        regions.append(_region(samples, axis, inside, _coarse(share), float(p_value), gain))
    return tuple(sorted(regions, key=lambda region: (-region.share, -region.nats * _INCIDENTAL.get(region.axis, 1.0))))


def _coarse(share: float) -> float:
    """Return a share to the 5 % that it is known to, so that near equals are ordered by what stands out more."""
    return float(np.clip(round(20.0 * share) / 20.0, 0.0, 1.0))


def _collect(problem: Problem, base: Fit) -> _Samples:
    predictions = problem.predict(base.coordinates, base.effects)
    fitted, _ = problem.fitted(predictions)
    columns = []
    for place in range(base.coordinates.size):
        moved = base.coordinates.copy()
        moved[place] += 1e-3
        columns.append((problem.fitted(problem.predict(moved, base.effects))[0] - fitted) / 1e-3)
    continuous: dict[str, list[FloatArray]] = {}
    discrete: dict[str, list[NDArray[np.str_]]] = {}
    for run_index, column, rows in problem.sequences:
        run = problem.runs[run_index]
        values: dict[str, FloatArray] = {"bending_length": run.bending_length / MILLIMETRE}
        if run.stroke is not None:
            values["stroke"] = run.stroke / MILLIMETRE
        if run.tension is not None:
            values["tension"] = run.tension
        curvature = predictions[run_index].response[:, column]
        if run.kind == "bend":
            curvature = curvature / run.bending_length
        elif run.kind == "notch":
            curvature = curvature / float(problem.joints[run.pair].pitch)
        values["curvature"] = curvature
        if run.time is not None:
            values["time"] = run.time
            speed = np.abs(np.gradient(run.drive, np.maximum.accumulate(run.time + 1e-9 * np.arange(len(run)))))
            values["rate"] = speed / (MILLIMETRE if run.stroke is not None else 1.0)
        for axis, value in values.items():
            continuous.setdefault(axis, []).append(value[rows])
        names = {
            "direction": np.where(run.direction < 0, "release", "load"),
            "run": np.full(len(run), run.name),
            "pair": np.full(len(run), run.pair),
            "cycle": run.branches.cycle.astype(str),
            "notch": np.full(len(run), str(column + 1)),
        }
        for axis, name in names.items():
            discrete.setdefault(axis, []).append(name[rows])
    size = problem.observed.size
    return _Samples(
        residual=problem.observed - fitted,
        directions=np.stack(columns, axis=1) if columns else np.zeros((size, 0)),
        continuous={axis: joined for axis, v in continuous.items() if (joined := np.concatenate(v)).size == size},
        discrete={axis: np.concatenate(v) for axis, v in discrete.items()},
    )


def _groups(samples: _Samples) -> Iterator[tuple[str, NDArray[np.bool_]]]:
    """Yield every region that is looked at, as its axis and its samples."""
    for axis, names in samples.discrete.items():
        distinct = np.unique(names)
        if 1 < distinct.size <= 64:
            for name in distinct:
                yield axis, names == name
    for axis, values in samples.continuous.items():
        edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, _BINS + 1)))
        usual = np.quantile(values, (0.1, 0.9))
        if edges.size < 3 or usual[1] - usual[0] < _EVEN * np.max(np.abs(values)):
            continue
        place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
        for first in range(edges.size - 1):
            for last in range(first, edges.size - 1):
                if (first, last) != (0, edges.size - 2):
                    yield axis, (place >= first) & (place <= last)


def _best_by_axis(samples: _Samples, floor: float) -> list[tuple[str, NDArray[np.bool_]]]:
    best: dict[str, tuple[float, NDArray[np.bool_]]] = {}
    for axis, inside in _groups(samples):
        if int(inside.sum()) < _FEWEST or int((~inside).sum()) < _FEWEST:
            continue
        gain = _two_variances(samples, inside, floor)[0]
        if axis not in best or gain > best[axis][0]:
            best[axis] = gain, inside
    return [(axis, inside) for axis, (_, inside) in best.items()]


def _two_variances(samples: _Samples, inside: NDArray[np.bool_], floor: float) -> tuple[float, float, float]:
    """Return the gain (nats) over one variance, and the excess squared error inside and outside a region."""
    outside = ~inside
    directions, residual = samples.directions[outside], samples.residual[outside]
    ridge = 1e-9 * np.trace(directions.T @ directions) / max(directions.shape[1], 1) + 1e-300
    normal = directions.T @ directions + ridge * np.eye(directions.shape[1])
    step = np.linalg.solve(normal, directions.T @ residual) if directions.shape[1] else np.zeros(0)
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


def _region(
    samples: _Samples, axis: str, inside: NDArray[np.bool_], share: float, p_value: float, nats: float
) -> Region:
    if axis in samples.discrete:
        return Region(axis, str(samples.discrete[axis][inside][0]), None, None, share, p_value, nats)
    values = samples.continuous[axis][inside]
    return Region(axis, None, float(values.min()), float(values.max()), share, p_value, nats)
