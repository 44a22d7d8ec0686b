"""The noise of a recording, from the recording itself: level, colour, quantisation step and outliers, with how sure.

Within a branch or a hold the response is smooth in the sample number (or in the drive, where the drive was sampled
unevenly); what no smooth curve can hold is noise. Slow noise cannot be told from signal: what remembers longer than a
fifth of a stretch counts as signal, and near that the level comes with a wide uncertainty, which is part of the answer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.branches import Branches, difference_noise, find_branches
from coast_cli.recordings.faults import clipped_rows, copied_rows, frozen_rows, quantum_of
from coast_cli.recordings.noise_likelihood import NoiseBlock, Posterior, noise_posterior
from coast_cli.recordings.outliers import find_outliers

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun

    Floats = NDArray[np.float64]

LONGEST_BLOCK = 96
SHORTEST_BLOCK = 7
MOST_SAMPLES = 4000
LONGEST = 500_000  # samples of a run, whose noise is that of its beginning: memory, not time, is what bounds it
LONGEST_GAP = 4
MEMORY_IN_STRETCH = 0.2
SURE = 0.35
MOST_IN_RUNS, FEWEST_IN_RUN = 40_000, 400  # samples over all runs, and in one
SLOW_UNSEEN = 0.5  # of the logarithm: what the slowest noise that counts as noise may lose to the signal
MODEL_ERROR = 0.02  # of the logarithm: noise is not exactly what it is taken for
SLOW = 0.8  # AR(1) coefficient from which longer blocks, of fewer samples, are looked at besides


@dataclass(frozen=True)
class NoiseEstimate:
    """Noise on a response, in its unit: an AR(1) part and a white part, rounded to steps, with some outliers besides.

    Attributes:
        level: standard deviation of the whole noise, outliers left out; an upper bound where ``determined`` is False.
        log_level_std: standard deviation of the estimate's natural logarithm, so ``level_std = level log_level_std``.
        correlation: of the noise between neighbouring samples.
        memory: coefficient of the AR(1) part; noise slower than a branch shows as a memory near 1, poorly determined.
        memory_std: standard deviation of that coefficient.
        longest_memory: in samples; slower noise would have counted as signal.
        white_share: share of the noise variance that is white (1 for white noise).
        unevenness: how unlike the level is from one stretch to another, standard deviation of its logarithm.
        quantum: step to which the response is rounded, 0 where none is seen.
        outlier_share: share of samples that stand alone, far from their neighbours.
        samples: how many samples were used.
        interval: what holds the level with a probability of 90 %.
        determined: False where the runs are too short for any noise to be told from the signal.
    """

    level: float
    log_level_std: float
    correlation: float
    memory: float
    memory_std: float
    longest_memory: float
    white_share: float
    unevenness: float
    quantum: float
    outlier_share: float
    samples: int
    determined: bool = True
    interval: tuple[float, float] = (0.0, 0.0)

    @property
    def level_std(self) -> float:
        """Standard deviation of ``level``, in the unit of the response."""
        return self.level * self.log_level_std

    @property
    def sure(self) -> bool:
        """Whether the level is known to about a third; slow noise on short runs is not."""
        return self.determined and self.log_level_std < SURE

    @property
    def words(self) -> str:
        """What was determined, in a sentence."""
        if not self.determined:
            return "the runs are too short to tell noise from signal; the level is an upper bound"
        colour = "white" if self.correlation < 0.1 else f"correlated {self.correlation:.2f} from sample to sample"
        if self.log_level_std == 0.0:
            return f"{colour}, the level as given"
        if not self.sure:
            return f"{colour}, the level known only within a factor of {self._factor:.1f} (90 %)"
        return f"{colour}, the level known within {100 * (self._factor - 1.0):.0f} % (90 %)"

    @property
    def _factor(self) -> float:
        """By how much the level may be off, 90 %."""
        low, high = self.interval
        return max(high / self.level, self.level / low)


@dataclass(frozen=True, eq=False)
class Series:
    """One response with the history of its drive: what noise is estimated from, alone or pooled with others."""

    values: Floats
    branches: Branches | None = None
    drive: Floats | None = None


def estimate_noise(values: Floats, drive: Floats | None = None) -> NoiseEstimate:
    """Return the noise on one smooth series.

    Args:
        values: [n], in whatever unit, which is that of the answer too; NaN where a frame was dropped.
        drive: [n], what moved it; its reversals split the series. Without it the series is taken as smooth throughout.

    Example:
        >>> noise = np.random.default_rng(1).normal(0.0, 0.2, 400)
        >>> estimate = coast.estimate_noise(np.linspace(0.0, 40.0, 400) + noise)
        >>> round(estimate.level, 1)
        0.2
    """
    if drive is None:
        return pooled_noise([Series(np.asarray(values, dtype=np.float64))])
    drive = np.asarray(drive, dtype=np.float64)
    return pooled_noise([Series(np.asarray(values, dtype=np.float64), find_branches(drive), drive)])


def run_noise(run: JointRun, *, most_samples: int = MOST_SAMPLES) -> NoiseEstimate:
    """Return the noise on the response of one run; the notches of a run are pooled."""
    return pooled_noise(_run_series(run), most_samples=most_samples)


def run_noises(runs: Sequence[JointRun], known: float | None = None) -> list[NoiseEstimate]:
    """Return the noise of each run, from fewer samples of each where there are many; ``known`` as `recording_noise`."""
    most = min(MOST_SAMPLES, max(FEWEST_IN_RUN, MOST_IN_RUNS // max(len(runs), 1)))
    return [_as_known(run_noise(run, most_samples=most), known) for run in runs]


def recording_noise(runs: Iterable[JointRun], known: float | None = None) -> NoiseEstimate:
    """Return the noise on the response, taken as one for all runs: the one figure of every command.

    Args:
        known: the level where the camera's noise is known, SI; colour and rounding are still the recording's own.
    """
    return _as_known(pooled_noise([series for run in runs for series in _run_series(run)]), known)


def _as_known(estimate: NoiseEstimate, known: float | None) -> NoiseEstimate:
    if known is None:
        return estimate
    return replace(estimate, level=known, log_level_std=0.0, interval=(known, known), determined=True)


def _run_series(run: JointRun) -> list[Series]:
    if len(run) > LONGEST:
        run = run.only(slice(LONGEST))
    new = ~copied_rows(run)
    if new.all():
        return [Series(column, run.branches, run.drive) for column in run.response.T]
    drive = run.drive[new]  # a copy between two rows would make the drive look uneven
    return [Series(column, find_branches(drive), drive) for column in run.response[new].T]


def pooled_noise(series: Sequence[Series], *, most_samples: int = MOST_SAMPLES) -> NoiseEstimate:
    """Return the noise that all series share, from about ``most_samples`` samples spread over them."""
    cleaned = [_without_faults(one) for one in series]
    outliers = [find_outliers(one.values) for one in cleaned]
    kept = [
        replace(one, values=np.where(lone, np.nan, one.values)) for one, lone in zip(cleaned, outliers, strict=True)
    ]
    total = sum(int(np.isfinite(one.values).sum()) for one in cleaned)
    share = sum(int(lone.sum()) for lone in outliers) / total if total else 0.0
    quantum = min((step for step in map(quantum_of, (one.values for one in series)) if step > 0.0), default=0.0)
    floor = max(quantum / np.sqrt(12.0), 1e-12 * _spread(series))
    blocks = [block for one in kept for block in _blocks(one)]
    if not blocks or floor == 0.0:
        return NoiseEstimate(
            level=max(_spread(series), floor),
            log_level_std=float("inf"),
            correlation=0.0,
            memory=0.0,
            memory_std=1.0,
            longest_memory=0.0,
            white_share=1.0,
            unevenness=0.0,
            quantum=quantum,
            outlier_share=share,
            samples=total,
            determined=False,
            interval=(floor, max(_spread(series), floor)),
        )
    blocks = _spread_out(blocks, most_samples)
    rough = [difference_noise(block.values) for block in blocks if len(block.values) >= 8]
    start = max(float(np.median(rough)) if rough else _spread(series), floor)
    stretch = _usual_stretch(series)
    longest = MEMORY_IN_STRETCH * stretch
    posterior = noise_posterior(blocks, start, longest, quantum)
    every = int(np.ceil(stretch / LONGEST_BLOCK))
    if every > 1 and posterior.memory > SLOW:
        coarse = [block for one in kept for block in _blocks(_every(one, every))]
        if coarse:
            rough_level = np.exp(posterior.log_level)
            seen = noise_posterior(_spread_out(coarse, most_samples), rough_level, longest / every, quantum)
            posterior = seen.of_every_sample(every)
    return NoiseEstimate(
        level=max(float(np.exp(posterior.log_level)), floor),
        log_level_std=posterior.log_level_std,
        correlation=posterior.lag_one,
        memory=posterior.memory,
        memory_std=posterior.memory_std,
        longest_memory=longest,
        white_share=1.0 - posterior.lag_one / posterior.memory if posterior.memory > 0.0 else 1.0,
        unevenness=posterior.unevenness,
        quantum=quantum,
        outlier_share=share,
        samples=sum(len(block.values) for block in blocks),
        interval=_interval(posterior, longest, floor),
    )


def _interval(posterior: Posterior, longest_memory: float, floor: float) -> tuple[float, float]:
    """Return what holds the level with 90 %: the slower the noise, the more of it may have counted as signal."""
    memory = -1.0 / np.log(posterior.memory) if posterior.memory > 0.0 else 0.0
    unseen = SLOW_UNSEEN * min(memory / longest_memory, 1.0) if longest_memory > 0.0 else SLOW_UNSEEN
    low, high = np.exp(posterior.log_low - MODEL_ERROR), np.exp(posterior.log_high + MODEL_ERROR + unseen)
    return max(float(low), floor), max(float(high), floor)


def _every(series: Series, step: int) -> Series:
    """Return every so-manieth sample of a series: AR(1) noise keeps its level, and is faster by that much."""
    drive = None if series.drive is None else series.drive[::step]
    branches = None if series.branches is None else series.branches.every(step)
    return Series(series.values[::step], branches, drive)


def _without_faults(series: Series) -> Series:
    """Return a series without the frames that repeat or stand at the end of the view: they hold no news of the noise."""
    values = series.values
    useless = frozen_rows(values, series.drive)
    if series.drive is not None:
        useless |= clipped_rows(values, series.drive)
    return replace(series, values=np.where(useless, np.nan, values)) if useless.any() else series


def _spread_out(blocks: list[NoiseBlock], most_samples: int) -> list[NoiseBlock]:
    """Return blocks taken evenly from all until they hold enough samples."""
    total = sum(len(block.values) for block in blocks)
    if total <= most_samples:
        return blocks
    count = max(1, round(len(blocks) * most_samples / total))
    return [blocks[index] for index in np.linspace(0, len(blocks) - 1, count).astype(int)]


def _spread(series: Sequence[Series]) -> float:
    finite = [one.values[np.isfinite(one.values)] for one in series]
    return max((float(np.ptp(values)) for values in finite if len(values)), default=0.0)


def _usual_stretch(series: Sequence[Series]) -> float:
    """Return the length, in samples, of the stretches that most samples stand in."""
    lengths = np.array(
        [part.stop - part.start for one in series for part in (one.branches.parts if one.branches else ())]
        or [len(one.values) for one in series]
    )
    return float(lengths @ lengths / lengths.sum())


def _blocks(series: Series) -> list[NoiseBlock]:
    """Cut a series at reversals, at long gaps and at the longest block; samples that are no use are closed up."""
    use = np.isfinite(series.values)
    parts = series.branches.parts if series.branches else ()
    stretches = [(part.start, part.stop, 2 if part.direction else 1) for part in parts] or [(0, len(use), 2)]
    uneven = _uneven(series)
    blocks = []
    for start, stop, degree in stretches:
        index = start + np.flatnonzero(use[start:stop])
        for piece in np.split(index, 1 + np.flatnonzero(np.diff(index) > LONGEST_GAP)):
            blocks.extend(_cut(series, piece, degree, uneven=uneven and degree == 2))
    return blocks


def _cut(series: Series, index: NDArray[np.int64], degree: int, *, uneven: bool) -> list[NoiseBlock]:
    count = max(int(np.ceil(len(index) / LONGEST_BLOCK)), 2 if len(index) >= 2 * SHORTEST_BLOCK else 1)
    size = len(index) // count
    if size < SHORTEST_BLOCK:
        return []
    if not uneven:
        size -= size % (8 if size > 64 else 4 if size > 32 else 1)
    blocks = []
    for offset in np.linspace(0, len(index) - size, count).round().astype(int):
        rows = index[offset : offset + size]
        coordinate = _coordinate(series.drive[rows]) if uneven and series.drive is not None else None
        values = series.values[rows]
        if coordinate is None and rows[-1] - rows[0] >= size:
            # closing a gap up must not make a jump of the slope: what the block counts as signal goes first
            values = values - np.polynomial.Polynomial.fit(rows, values, degree)(rows)
        blocks.append(NoiseBlock(values, coordinate, degree))
    return blocks


def _uneven(series: Series) -> bool:
    """Whether the drive advances in steps too unlike to take the sample number for the coordinate."""
    if series.drive is None or series.branches is None:
        return False
    steps = [
        np.diff(series.drive[part.start : part.stop]) for part in series.branches.moves if part.stop - part.start > 4
    ]
    if not steps:
        return False
    change = np.concatenate([np.diff(step, 2) for step in steps])
    along = np.concatenate([step * part.direction for step, part in zip(steps, series.branches.moves, strict=False)])
    usual = float(np.median(np.abs(along)))
    return bool(np.median(np.abs(change)) > 0.3 * usual and (along <= 0.0).mean() < 0.1)


def _coordinate(drive: Floats) -> Floats | None:
    """Return the drive scaled to unit mean steps, made strictly monotone; None where it hardly moves."""
    travel = drive[-1] - drive[0]
    if travel == 0.0:
        return None
    scaled = (drive - drive[0]) * (len(drive) - 1) / travel
    least = 0.02
    steps = np.maximum(np.diff(np.maximum.accumulate(scaled)), least)
    return np.concatenate(([0.0], np.cumsum(steps)))
