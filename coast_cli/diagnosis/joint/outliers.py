"""Which samples count, and how noisy neighbours are: read before any model, from the response and its drive alone.

An outlier lies off whatever its neighbours foretell, by the sample or by the drive; a turning point or the foot of a
stair lies off only one of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.thresholds import FEWEST_TO_SCREEN, OUTLIER_MOVED, OUTLIER_NOISE, OUTLIER_SPREAD
from coast_cli.mechanics.section import FloatArray


def screened(
    columns: Sequence[FloatArray], drives: Sequence[FloatArray], fitted: Sequence[bool]
) -> tuple[list[NDArray[np.bool_]], float]:
    """Return which samples count (finite, and no lone outlier) and the rough noise level of the runs that are fitted."""
    seen = [pair for pair, use in zip(zip(columns, drives, strict=True), fitted, strict=True) if use]
    level = _difference_level(seen or list(zip(columns, drives, strict=True)))
    usable = []
    for values, drive in zip(columns, drives, strict=True):
        good = np.isfinite(values)
        for column in range(values.shape[1]):
            rows = np.flatnonzero(good[:, column])
            if rows.size < FEWEST_TO_SCREEN:
                continue
            series, behind = values[rows, column], drive[rows]
            moved = float(np.ptp(series)) / max(float(np.ptp(behind)), 1e-300) * _alone(behind)
            spread = float(np.median(np.abs(np.diff(series))))
            lonely = np.minimum(_alone(series), _beside(series, behind))
            good[rows[lonely > OUTLIER_NOISE * level + OUTLIER_SPREAD * spread + OUTLIER_MOVED * moved], column] = False
        usable.append(good)
    return usable, level


def _alone(series: FloatArray) -> FloatArray:
    """Return how far each sample (n,) lies from what the two before, the two after, or one of each foretell, at least."""
    inside = np.full(series.size, np.inf)
    inside[1:-1] = np.abs(series[1:-1] - 0.5 * (series[:-2] + series[2:]))
    before, after = np.full(series.size, np.inf), np.full(series.size, np.inf)
    before[2:] = np.abs(series[2:] - 2.0 * series[1:-1] + series[:-2])
    after[:-2] = np.abs(series[:-2] - 2.0 * series[1:-1] + series[2:])
    return np.asarray(np.minimum(inside, np.minimum(before, after)))


def _beside(series: FloatArray, drive: FloatArray) -> FloatArray:
    """Return how far each sample (n,) lies from the line of its neighbours over the drive, at unit noise; inf at turns."""
    before, here, after = drive[:-2], drive[1:-1], drive[2:]
    span = after - before
    held = np.abs(span) <= 1e-12 * max(float(np.ptp(drive)), 1e-300)
    part = np.where(held, 0.5, (here - before) / np.where(held, 1.0, span))
    off = np.abs(series[1:-1] - series[:-2] - part * (series[2:] - series[:-2])) / np.sqrt(
        1.0 + part**2 + (1.0 - part) ** 2
    )
    found = np.full(series.size, np.inf)
    found[1:-1] = np.where((part < 0.0) | (part > 1.0), np.inf, off)
    return found


def _difference_level(columns: Sequence[tuple[FloatArray, FloatArray]]) -> float:
    """Return the noise that neighbours show, whether the response runs evenly with the sample or with the drive."""
    differences, beside = [], []
    for values, drive in columns:
        for column in range(values.shape[1]):
            good = np.isfinite(values[:, column])
            series = values[good, column]
            if series.size >= 3:
                differences.append(np.abs(np.diff(series, 2)))
                beside.append(_beside(series, drive[good])[1:-1])
    if not differences:
        return 1e-9
    spread, over_drive = np.concatenate(differences), np.concatenate(beside)
    level = float(np.median(spread) / 0.6745 / np.sqrt(6.0))
    straight = over_drive[np.isfinite(over_drive)]
    if straight.size > 0.5 * spread.size:
        level = min(level, float(np.median(straight) / 0.6745))
    if level <= 0.0:  # most neighbours read the same: the readings are coarse, and their steps are the noise
        level = float(np.mean(spread) / np.sqrt(6.0))
    return max(level, 1e-9)
