"""A disturbance that swings with a period of its own: breathing, a room that shakes, mains hum.

What the drive explains is taken off first, then the strongest line of the rest is looked for among frequencies that the
drive does not have. A line that follows the drive rather than the clock, as of a lead screw, is none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun

    Floats = NDArray[np.float64]

FEWEST_SAMPLES, MOST_SAMPLES = 80, 8192
FEWEST_PERIODS = 4
DEGREE = 5  # of the polynomial in the drive, for each direction
DRIVE_HARMONICS = 16  # a response bends the drive's own frequency into so many
MANY_CYCLES = 5
FEWEST_IN_CYCLE = 8  # swings in a cycle of the drive, where it has few
BY_CHANCE = 1e-9  # of the strongest line, where the rest is noise
LEAST_SHARE = 0.25  # of what the drive leaves
AROUND = 20  # lines on each side that say how strong lines usually are


@dataclass(frozen=True)
class Swing:
    """What swings.

    Attributes:
        period: s. amplitude: of the response (of all notches together), SI.
        share: of what the drive leaves of the response, how much swings, as a share of its variance.
    """

    period: float
    amplitude: float
    share: float


def swing_of(run: JointRun, use: NDArray[np.bool_]) -> Swing | None:
    """Return the swing of a run's response, from the rows of ``use`` [n]; None where there is none, or no clock."""
    if run.time is None:
        return None
    use = use & run.valid & np.append(True, np.diff(run.time) > 0.0)
    if use.sum() < FEWEST_SAMPLES or np.ptp(run.drive) == 0.0:
        return None
    rows = np.flatnonzero(use)[:: max(1, int(use.sum()) // MOST_SAMPLES)]
    time, drive = run.time[rows], run.drive[rows]
    rest = _left_by_drive(drive, run.direction[rows], time, run.response[rows].sum(axis=1))
    frequency, power = _lines(time, rest)
    allowed = _not_of_drive(frequency, time, drive)
    if allowed.sum() < FEWEST_SAMPLES // 4:
        return None
    place = int(np.argmax(np.where(allowed, power, 0.0)))
    around = power[max(place - AROUND, 0) : place + AROUND + 1]
    usual = float(np.median(np.delete(around, np.s_[max(min(place, AROUND) - 2, 0) : min(place, AROUND) + 3])))
    total = float(np.sum((rest - rest.mean()) ** 2))
    if usual <= 0.0 or total <= 0.0 or allowed.sum() * np.exp(-power[place] * np.log(2.0) / usual) > BY_CHANCE:
        return None
    best, taken, amplitude = _tuned(time, rest, float(frequency[place]))
    if taken < LEAST_SHARE * total or _of_drive(drive, rest, time, best) >= taken:
        return None
    return Swing(1.0 / best, amplitude, taken / total)


def _left_by_drive(drive: Floats, direction: NDArray[np.int64], time: Floats, response: Floats) -> Floats:
    at = 2.0 * (drive - drive.min()) / np.ptp(drive) - 1.0
    powers = np.polynomial.chebyshev.chebvander(at, DEGREE)
    released = (direction < 0)[:, None] * powers
    columns = np.column_stack((powers, released, (time - time[0]) / np.ptp(time)))
    rest: Floats = response - columns @ _fitted(columns, response)
    return rest


def _fitted(columns: Floats, values: Floats) -> Floats:
    """Return the least squares of few columns of about unit size, by the normal equations: a tenth of the time."""
    square = columns.T @ columns
    square[np.diag_indices_from(square)] *= 1.0 + 1e-9
    factors = np.linalg.lstsq(square, columns.T @ values, rcond=None)[0]
    return np.asarray(factors, dtype=np.float64)


def _lines(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return frequencies (Hz) and powers of an even sampling with as many samples."""
    even = np.linspace(time[0], time[-1], len(time))
    spectrum = np.fft.rfft(np.interp(even, time, values) * np.hanning(len(time)))
    frequency: Floats = np.arange(len(spectrum)) / (len(time) * float(even[1] - even[0]))
    power: Floats = np.abs(spectrum) ** 2
    return frequency, power


def _not_of_drive(frequency: Floats, time: Floats, drive: Floats) -> NDArray[np.bool_]:
    """Return which lines the drive does not have: not the slowest, and no multiple of its own where it has many cycles.

    Where it has few cycles its multiples are everywhere, and a line counts that is fast beside a branch.
    """
    width = 1.0 / float(time[-1] - time[0])
    own = _lines(time, drive - drive.mean())[1]
    strongest = max(float(frequency[int(np.argmax(own))]), width)
    slowest = FEWEST_PERIODS * width
    if strongest < MANY_CYCLES * width:
        return np.asarray(frequency >= max(slowest, FEWEST_IN_CYCLE * strongest))
    nearest = np.round(frequency / strongest)
    multiple = (np.abs(frequency - nearest * strongest) < 1.5 * width) & (nearest <= DRIVE_HARMONICS)
    return np.asarray(~multiple & (frequency >= slowest))


def _tuned(time: Floats, values: Floats, frequency: float) -> tuple[float, float, float]:
    """Return (frequency, what its sine takes off the sum of squares, amplitude) of the best sine near a line."""
    width = 1.0 / float(np.ptp(time))
    tried = []
    for near in frequency + width * np.linspace(-1.0, 1.0, 21):
        angle = 2.0 * np.pi * near * time
        columns = np.column_stack((np.cos(angle), np.sin(angle), np.ones(len(time))))
        factors = _fitted(columns, values)
        taken = float(np.sum((values - values.mean()) ** 2) - np.sum((values - columns @ factors) ** 2))
        tried.append((taken, float(near), float(np.hypot(*factors[:2]))))
    taken, best, amplitude = max(tried)
    return best, taken, amplitude


def _of_drive(drive: Floats, values: Floats, time: Floats, frequency: float) -> float:
    """Return what the best sine of the drive itself, at the wave length of that frequency, takes off."""
    speed = float(np.median(np.abs(np.diff(drive) / np.diff(time))))
    if speed <= 0.0:
        return 0.0
    return max(_tuned(drive, values, frequency / (speed * stretch))[1] for stretch in (0.9, 1.0, 1.1, 1.3, 1.57))
