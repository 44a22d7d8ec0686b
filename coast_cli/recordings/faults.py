"""What recordings of other benches get wrong: frames that repeat, views that end, clocks that stand, swings, noisy drives.

Nothing is left out in silence: each fault is a sentence with its share, and rows that hold no news of the response
(`frozen`, `clipped`) can be asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.branches import difference_noise

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun
    from coast_cli.recordings.swing import Swing

    Booleans = NDArray[np.bool_]
    Floats = NDArray[np.float64]

OFF_STEP = 0.05  # of a step: a multiple of it is no further off
MANY_GAPS, ON_STEP = 12, 0.7  # of so many gaps, the share that must be multiples; an outlier makes two that are not
CHANCE_OF_A_REPEAT = 0.05  # above it rounding makes neighbours equal often enough
MORE_THAN_CHANCE = 3.0
FEWEST_REPEATS = 3
LIKE_OTHERS, MOSTLY = 0.3, 0.6  # of the usual step; of the repeats
NOISY = 0.02  # of the usual step: the noise of a camera; a simulation without noise repeats itself where it rests
STEPS_AROUND = 10  # of those nearest to a burst: what one frame moves by there
MADE_UP = 0.6  # of what was missed in a burst: the jump after it
CATCH_UP = 2.5  # usual steps: what a frame that stood makes up for when it moves again
FEWEST_CLIPPED = 5
CLIPPED_OF_STEP = 4.0  # of the drive's travel on the last level, to that on the steps below it
ALL_OF = 0.95  # of the samples that are driven further than half of those on the level
BELOW_END = 0.1  # of the range: a sample that is clearly below the end
FLAT = 0.4  # of the usual slope, which the end of a response that is cut off has at most
AT_ZERO = 0.1  # of the range: a level as near to zero is of a device at rest
NOISY_DRIVE = 1e-3  # of its travel
AGAINST = 0.05  # of the steps of a moving drive, that go back
FOLLOWS = 0.1  # correlation of drive and response below which nothing follows
ROUGH = 1e-4  # of its range: a commanded stroke is smoother
ROUGHER = 5.0  # times: a camera is hardly that much smoother than a drive
AHEAD = 0.03  # of the range: by more the loop runs the wrong way round
MOST_NAMED = 3  # runs in one sentence


def quantum_of(values: Floats) -> float:
    """Return the step that differences are whole multiples of, or 0 where there is none; a few outliers may be off it."""
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < 3:
        return 0.0
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * (levels[-1] - levels[0])]
    # The largest step that fits: outliers make smaller ones fit by chance.
    for smallest in (*(float(np.quantile(gaps, share, method="nearest")) for share in (0.5, 0.1)), float(gaps.min())):
        step = smallest
        for _ in range(2):
            step = float(np.median(gaps / np.maximum(np.round(gaps / step), 1.0)))
        off = np.abs(gaps / step - np.round(gaps / step))
        if float(off.max()) < OFF_STEP or (len(gaps) >= MANY_GAPS and (off < OFF_STEP).mean() > ON_STEP):
            return step
    return 0.0


def frozen_rows(response: Floats, drive: Floats | None = None) -> Booleans:
    """Return which rows repeat the frame before them though the drive moves, [n].

    Args:
        response: [n] or [n, k]; a row repeats where all its values do. NaN repeats nothing.
        drive: [n]; where it stays, a rounded response may stay too. None where it always moves.

    Noise makes each frame another, also in a hold. Where rounding hides it, only rows count after which the response
    makes up for what it missed: a device that rests in its play moves on in small steps, a frozen one jumps.
    """
    rows = response[:, None] if response.ndim == 1 else response
    frozen = np.zeros(len(rows), dtype=bool)
    if len(rows) < 8:
        return frozen
    same = np.append(False, (rows[1:] == rows[:-1]).all(axis=1))
    count = int(same.sum())
    if count < FEWEST_REPEATS:
        return frozen
    moved = rows[~same & np.isfinite(rows).all(axis=1)]
    by_chance = 1.0
    for column in moved.T:
        noise, step = difference_noise(column), quantum_of(column) or _step_of_two(column)
        is_fine = noise > max(step, 1e-9 * float(np.ptp(column)))
        by_chance *= 0.5 * step / (np.sqrt(np.pi) * noise) if is_fine else 1.0
    if by_chance < CHANCE_OF_A_REPEAT and (_is_noisy(moved) or _goes_on(rows, same)):
        return same if count > MORE_THAN_CHANCE * (by_chance * len(rows) + 1.0) else frozen
    if drive is not None:
        same[1:] &= np.diff(drive) != 0.0
    return _made_up_for(rows, same)


def _step_of_two(values: Floats) -> float:
    """Return the step between two levels, where there are no more."""
    levels = np.unique(values)
    return float(np.ptp(levels)) if len(levels) < 3 else 0.0


def _is_noisy(moved: Floats) -> bool:
    """Whether every frame that moved has noise of its own, so that none repeats another by itself."""
    return all(difference_noise(column) > NOISY * float(np.median(np.abs(np.diff(column)))) for column in moved.T)


def _goes_on(rows: Floats, same: Booleans) -> bool:
    """Whether steps after repeats are like others: a device that rests, without noise, goes on in small ones."""
    step = np.abs(np.diff(rows, axis=0)).max(axis=1)
    ends = same[:-1] & ~same[1:]
    after, usual = step[ends & np.isfinite(step)], step[~same[1:] & ~same[:-1] & np.isfinite(step)]
    if not len(after) or not len(usual):
        return False
    return bool((after > LIKE_OTHERS * np.median(usual)).mean() > MOSTLY)


def repeating_rows(run: JointRun) -> Booleans:
    """Return every row that shows what the row before it shows, be it by rounding, [n]."""
    return np.append(False, (run.response[1:] == run.response[:-1]).all(axis=1))


def copied_rows(run: JointRun) -> Booleans:
    """Return which rows repeat the row before in everything, clock and drive too, [n].

    A clock goes on, whatever a camera shows; without one only what cannot repeat by chance is a copy.
    """
    shown_again = frozen_rows(run.response, run.drive) if run.time is None else repeating_rows(run)
    others = [one for one in (run.time, run.drive, run.tension) if one is not None]
    return np.asarray(shown_again & np.append(False, np.all([np.diff(one) == 0.0 for one in others], axis=0)))


def _made_up_for(rows: Floats, same: Booleans) -> Booleans:
    """Return which repeats end in a jump that makes up for as many steps as were missed, or that no step elsewhere is like."""
    frozen = np.zeros(len(rows), dtype=bool)
    step = np.abs(np.diff(rows, axis=0)).max(axis=1)
    moved = np.flatnonzero(~same[1:] & ~same[:-1] & np.isfinite(step))
    if len(moved) < 8:
        return frozen
    limit = CATCH_UP * float(np.quantile(step[moved], 0.9))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], same.astype(np.int8), [0]))))
    jumps = []
    for start, stop in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if stop == len(rows):
            continue
        around = step[moved[np.argsort(np.abs(moved - start), kind="stable")[:STEPS_AROUND]]]
        missed = MADE_UP * (stop - start + 1) * float(np.median(around))
        is_long = stop - start >= FEWEST_REPEATS and missed > float(np.quantile(around, 0.9))
        if step[stop - 1] > (min(limit, missed) if is_long else limit):
            jumps.append((start, stop))
    if sum(stop - start for start, stop in jumps) >= 2 * FEWEST_REPEATS:
        for start, stop in jumps:
            frozen[start:stop] = True
    return frozen


def clipped_rows(values: Floats, drive: Floats) -> Booleans:
    """Return which samples of one response stand at the level that its view ends at, [n].

    The level is the largest or smallest of the run, met while the drive still moves on towards it: a device that rests
    in its play only does so after the drive has turned.
    """
    clipped = np.zeros(len(values), dtype=bool)
    finite = np.isfinite(values)
    if finite.sum() < 4 * FEWEST_CLIPPED or np.ptp(values[finite]) == 0.0:
        return clipped
    rows = np.flatnonzero(finite)
    seen, pulled = values[rows], drive[rows]
    follows = float(np.sign(np.cov(pulled, seen)[0, 1])) if np.ptp(pulled) > 0.0 else 0.0
    moving = np.append(0.0, np.sign(np.diff(pulled)))
    step = quantum_of(seen)
    for side in (1.0, -1.0):
        level = float((side * seen).max())
        at = side * seen >= level - 1e-9 * max(abs(level), float(np.ptp(seen)))
        towards = at & np.append(False, at[:-1]) & (moving * follows == side)
        if towards.sum() < FEWEST_CLIPPED or abs(level) < AT_ZERO * float(np.ptp(seen)):
            continue
        below = (side * seen < level - 0.5 * step) & (side * seen > level - 2.5 * step) & (moving * follows == side)
        each = 0.5 * float(np.ptp(pulled[below])) if step > 0.0 and below.any() else 0.0
        further = side * follows * pulled
        beyond = further >= float(np.median(further[towards]))
        if float(np.ptp(pulled[towards])) > CLIPPED_OF_STEP * each and at[beyond].mean() > ALL_OF:
            clipped[rows[at]] = True
    return clipped


def has_flat_end(values: Floats, drive: Floats) -> bool:
    """Return whether one response hardly rises any more over the last of the drive, be the end sharp, soft or noisy."""
    finite = np.isfinite(values)
    seen, pulled = values[finite], drive[finite]
    if len(seen) < 4 * FEWEST_CLIPPED or np.ptp(pulled) == 0.0 or np.ptp(seen) == 0.0:
        return False
    follows = float(np.sign(np.cov(pulled, seen)[0, 1])) or 1.0
    order = np.argsort(follows * pulled, kind="stable")
    seen, pulled = seen[order], follows * pulled[order]
    level = float(np.median(seen[-FEWEST_CLIPPED:]))
    rising = seen < level - BELOW_END * float(np.ptp(seen))
    if rising.sum() < FEWEST_CLIPPED:
        return False
    # What stands behind the last sample that is still clearly below the end.
    last = max(int(np.flatnonzero(rising)[-1]) + 1, 0)
    first = min(last, len(seen) - FEWEST_CLIPPED)
    end = slice(first, None)
    if np.ptp(pulled[end]) == 0.0:
        return False
    usual = float(np.ptp(seen[:first])) / max(float(np.ptp(pulled[:first])), 1e-300)
    return bool(float(np.polyfit(pulled[end], seen[end], 1)[0]) < FLAT * usual)


@dataclass(frozen=True, eq=False)
class Faults:
    """What is wrong with one run; nothing of it is left out for it.

    Attributes:
        run: its name. samples: how many it has.
        missing: samples without a whole response.
        frozen: rows that repeat the frame before, [n], though the clock or the drive goes on.
        duplicated: rows that repeat the row before in everything, clock and drive too, [n].
        clipped: rows at which a response stands where its view ends, [n].
        flat_end: whether a response hardly rises any more at the end of its drive.
        same_time: samples whose clock stands.
        drive_noise: noise of the drive, as a share of its travel, where it goes back and forth; else 0.
        is_still: whether the drive stays.
        is_deaf: whether the response does not follow the drive.
        leads: whether the response runs before the drive, as it does where the two are exchanged.
        swing: what swings with a period of its own, or None.
    """

    run: str
    samples: int
    missing: int
    frozen: Booleans
    duplicated: Booleans
    clipped: Booleans
    flat_end: bool
    same_time: int
    drive_noise: float
    is_still: bool
    is_deaf: bool
    leads: bool
    swing: Swing | None

    @property
    def useless(self) -> Booleans:
        """Rows that hold no news of the response, [n]."""
        return self.frozen | self.duplicated | self.clipped


def faults_of(run: JointRun) -> Faults:
    """Return what is wrong with a run."""
    from coast_cli.recordings.swing import swing_of

    repeated = frozen_rows(run.response, run.drive)
    duplicated = copied_rows(run)
    clipped: Booleans = np.any([clipped_rows(column, run.drive) for column in run.response.T], axis=0)
    is_still = not run.branches.moves
    return Faults(
        run=run.name,
        samples=len(run),
        missing=int((~run.valid).sum()),
        frozen=repeated & ~duplicated & ~clipped,
        duplicated=duplicated,
        clipped=clipped,
        flat_end=any(has_flat_end(column, run.drive) for column in run.response.T),
        same_time=0 if run.time is None else int((np.diff(run.time) == 0.0).sum()),
        drive_noise=0.0 if is_still else _drive_noise(run),
        is_still=is_still,
        is_deaf=not is_still and _is_deaf(run),
        leads=not is_still and _leads(run),
        swing=None if is_still else swing_of(run, ~(repeated | clipped)),
    )


def _drive_noise(run: JointRun) -> float:
    step = np.diff(run.drive)
    moving = run.direction[1:] != 0
    back = float((step[moving] * run.direction[1:][moving] < 0.0).mean()) if moving.any() else 0.0
    share = run.branches.drive_noise / float(np.ptp(run.drive))
    return share if share > NOISY_DRIVE and back > AGAINST else 0.0


def _is_deaf(run: JointRun) -> bool:
    response = run.response[run.valid].sum(axis=1)
    drive = run.drive[run.valid]
    if len(drive) < 8 or np.ptp(response) == 0.0 or np.ptp(drive) == 0.0:
        return len(drive) >= 8
    return bool(abs(np.corrcoef(drive, response)[0, 1]) < FOLLOWS)


def _leads(run: JointRun) -> bool:
    """Whether a stroke is rougher than the response, or rough and behind it: then the two may be exchanged."""
    valid = run.valid
    if run.stroke is None or valid.sum() < 4 * FEWEST_CLIPPED:
        return False
    drive, response = run.drive[valid], run.response[valid].sum(axis=1)
    if np.ptp(response) == 0.0 or np.ptp(drive) == 0.0:
        return False
    rough, smooth = (difference_noise(values) / float(np.ptp(values)) for values in (drive, response))
    if rough < ROUGH:
        return False
    return rough > ROUGHER * smooth or (rough > smooth and _ahead(run, drive, response) > AHEAD)


def _ahead(run: JointRun, drive: Floats, response: Floats) -> float:
    """Return by how much the response is further on load than on release, as a share of its range; below 0 it waits."""
    load, release = (run.direction[run.valid] == sign for sign in (1, -1))
    if min(load.sum(), release.sum()) < FEWEST_CLIPPED:
        return 0.0
    low = max(float(drive[part].min()) for part in (load, release))
    high = min(float(drive[part].max()) for part in (load, release))
    level = np.linspace(low, high, 12)[1:-1]
    going, coming = (np.interp(level, *_by_drive(drive[part], response[part])) for part in (load, release))
    follows = float(np.sign(np.cov(drive, response)[0, 1]))
    return float(np.median(follows * (going - coming))) / float(np.ptp(response))


def _by_drive(drive: Floats, response: Floats) -> tuple[Floats, Floats]:
    order = np.argsort(drive, kind="stable")
    return drive[order], response[order]


def fault_notes(runs: Sequence[JointRun]) -> tuple[str, ...]:
    """Return what is wrong with runs, a sentence for each kind of fault, with the share of the samples."""
    found = [(run, faults_of(run)) for run in runs]
    shares: tuple[tuple[str, Callable[[Faults], int], str], ...] = (
        ("responses are missing", lambda one: one.missing, "they are taken for dropped frames"),
        ("time stamps repeat", lambda one: one.same_time, "what depends on rate is uncertain there"),
        ("rows are duplicates of the row before", lambda one: int(one.duplicated.sum()), "the noise counts them once"),
        ("frames repeat the frame before", lambda one: int(one.frozen.sum()), "the noise leaves them out"),
        ("responses stand where their view ends", lambda one: int(one.clipped.sum()), "the noise leaves them out"),
    )
    said = []
    for what, count, then in shares:
        named = [f"{_share(count(one), one.samples)} in run {one.run}" for _, one in found if count(one)]
        if named:
            said.append(f"{what}: {_listed(named)}; {then}.")
    noisy = [f"{100 * one.drive_noise:.2g} % of its travel in run {one.run}" for _, one in found if one.drive_noise]
    if noisy:
        said.append(f"the drive is noisy: {_listed(noisy)}; small reversals are not told from it.")
    flags: tuple[tuple[str, Callable[[Faults], bool]], ...] = (
        ("the drive never moves in run {}: only creep, drift and noise can show.", lambda one: one.is_still),
        ("the response does not follow the drive in run {}.", lambda one: one.is_deaf),
        ("the drive is rougher than the response in run {}: are the two exchanged?", lambda one: one.leads),
    )
    for sentence, is_so in flags:
        named = [one.run for _, one in found if is_so(one)]
        if named:
            said.append(sentence.format(_listed(named)))
    swings = [
        f"{one.swing.period:.3g} s in run {one.run} ({100 * one.swing.share:.0f} % of what the drive leaves)"
        for _, one in found
        if one.swing is not None
    ]
    if swings:
        said.append(f"the response swings with a period of its own: {_listed(swings)}.")
    return tuple(said)


def _share(count: int, total: int) -> str:
    share = 100.0 * count / total
    return f"{share:.0f} %" if share >= 1.0 else f"{share:.1g} %"


def _listed(named: Sequence[str]) -> str:
    more = len(named) - MOST_NAMED
    return ", ".join(named[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
