"""The noise of a recording, from the recording itself: level, colour, quantisation step and outliers, with how sure.

Within a branch or a hold the response is smooth in the sample number (or in the drive, where the drive was sampled
unevenly); what no smooth curve can hold is noise. Slow noise cannot be told from signal: what remembers longer than a
fifth of a stretch counts as signal, and near that the level comes with a wide uncertainty, which is part of the answer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.branches import Branches, difference_noise, find_branches
from coast_cli.recordings.noise_likelihood import Block, noise_posterior

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun

    Floats = NDArray[np.float64]

LONGEST_BLOCK = 96
SHORTEST_BLOCK = 7
MOST_SAMPLES = 4000
LONGEST_GAP = 4
OUTLIER_IN_SIGMAS = 5.5
MEMORY_IN_STRETCH = 0.2
MOST_OUTLIERS = 0.15
SURE = 0.35


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
        if not self.sure:
            return f"{colour}, the level known only within a factor of {np.exp(1.645 * self.log_level_std):.1f} (90 %)"
        return f"{colour}, the level known within {100 * 1.645 * self.log_level_std:.0f} % (90 %)"


@dataclass(frozen=True, eq=False)
class Series:
    """One response with the history of its drive: what noise is estimated from, alone or pooled with others."""

    values: Floats
    branches: Branches | None = None
    drive: Floats | None = None


def estimate_noise(values: Floats, drive: Floats | None = None) -> NoiseEstimate:
    """Return the noise on one smooth series.

    Args:
        values: [n], NaN where a frame was dropped.
        drive: [n], what moved it; its reversals split the series. Without it the series is taken as smooth throughout.
    """
    if drive is None:
        return pooled_noise([Series(np.asarray(values, dtype=np.float64))])
    drive = np.asarray(drive, dtype=np.float64)
    return pooled_noise([Series(np.asarray(values, dtype=np.float64), find_branches(drive), drive)])


def run_noise(run: JointRun, *, most_samples: int = MOST_SAMPLES) -> NoiseEstimate:
    """Return the noise on the response of one run; the notches of a run are pooled."""
    return pooled_noise(_run_series(run), most_samples=most_samples)


def recording_noise(runs: Iterable[JointRun]) -> NoiseEstimate:
    """Return the noise on the response, taken as one for all runs."""
    return pooled_noise([series for run in runs for series in _run_series(run)])


def _run_series(run: JointRun) -> list[Series]:
    return [Series(column, run.branches, run.drive) for column in run.response.T]


def pooled_noise(series: Sequence[Series], *, most_samples: int = MOST_SAMPLES) -> NoiseEstimate:
    """Return the noise that all series share, from about ``most_samples`` samples spread over them."""
    blocks: list[Block] = []
    flagged = total = 0
    for one in series:
        outlier = find_outliers(one.values)
        total += int(np.isfinite(one.values).sum())
        flagged += int(outlier.sum())
        blocks.extend(_blocks(one, outlier))
    quantum = min((step for step in map(_quantum, (one.values for one in series)) if step > 0.0), default=0.0)
    share = flagged / total if total else 0.0
    floor = max(quantum / np.sqrt(12.0), 1e-12 * _spread(series))
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
        )
    blocks = _spread_out(blocks, most_samples)
    rough = [difference_noise(block.values) for block in blocks if len(block.values) >= 8]
    start = max(float(np.median(rough)) if rough else _spread(series), floor)
    longest = MEMORY_IN_STRETCH * _usual_stretch(series)
    posterior = noise_posterior(blocks, start, longest)
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
    )


def _spread_out(blocks: list[Block], most_samples: int) -> list[Block]:
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


def _blocks(series: Series, outlier: NDArray[np.bool_]) -> list[Block]:
    """Cut a series at reversals, at long gaps and at the longest block; samples that are no use are closed up."""
    use = np.isfinite(series.values) & ~outlier
    parts = series.branches.parts if series.branches else ()
    stretches = [(part.start, part.stop, 2 if part.direction else 1) for part in parts] or [(0, len(use), 2)]
    uneven = _uneven(series)
    blocks = []
    for start, stop, degree in stretches:
        index = start + np.flatnonzero(use[start:stop])
        for piece in np.split(index, 1 + np.flatnonzero(np.diff(index) > LONGEST_GAP)):
            blocks.extend(_cut(series, piece, degree, uneven=uneven and degree == 2))
    return blocks


def _cut(series: Series, index: NDArray[np.int64], degree: int, *, uneven: bool) -> list[Block]:
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
        blocks.append(Block(values, coordinate, degree))
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


SPIKE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
ALIKE = (
    np.array([0.0, 1.0, -2.0, 1.0, 0.0]),
    np.array([0.0, 1.0, -1.0, -1.0, 1.0]),
    np.array([1.0, -1.0, -1.0, 1.0, 0.0]),
    np.array([0.0, 1.0, -3.0, 3.0, -1.0]),
    np.array([1.0, -3.0, 3.0, -1.0, 0.0]),
)


def find_outliers(values: Floats) -> NDArray[np.bool_]:
    """Return which samples stand alone, far from what their neighbours on both sides say, [n].

    Fourth differences show a lone sample as 1 -4 6 -4 1; a change of slope or a jump shows otherwise and is kept.
    """
    outlier = np.zeros(len(values), dtype=bool)
    index = np.flatnonzero(np.isfinite(values))
    if len(index) < 12:
        return outlier
    fourth = np.diff(values[index], 4)
    scale = float(np.median(np.abs(fourth))) / 0.6744897501960817
    if scale == 0.0:
        return outlier
    threshold = OUTLIER_IN_SIGMAS * scale * np.sqrt(SPIKE @ SPIKE) / np.sqrt(1.0 + 16 + 36 + 16 + 1)
    padded = np.concatenate((np.zeros(2), fourth, np.zeros(2)))
    for _ in range(int(MOST_OUTLIERS * len(index))):
        windows = np.lib.stride_tricks.sliding_window_view(padded, 5)
        best = int(np.argmax(np.abs(windows @ SPIKE)))
        size = float(windows[best] @ SPIKE) / float(SPIKE @ SPIKE)
        if abs(size) * 6.0 < threshold:
            break
        energy = size**2 * float(SPIKE @ SPIKE)
        rivals = max(float(windows[best] @ other) ** 2 / float(other @ other) for other in ALIKE)
        if rivals >= energy:
            padded[best : best + 5] = 0.0
            continue
        padded[best : best + 5] -= size * SPIKE
        outlier[index[best + 2]] = True
    return outlier


def _quantum(values: Floats) -> float:
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
