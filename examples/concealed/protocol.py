"""How a user might have recorded: bending lengths, sweeps, partial reversals, holds, cycles, rates, columns.

A protocol is drawn first, without looking at what was left out; an effect then asks whether the protocol could show
it (`Needs`), and another one is drawn until it could. A clean record borrows the protocol of a random effect.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RunPlan:
    """One run: tubes by index, bending length (m), drive at every simulated time.

    And which of those times were recorded.
    """

    outer: int | None
    middle: int
    length: float
    kind: str
    time: Array
    fraction: Array
    recorded: NDArray[np.int64]


@dataclass(frozen=True)
class Protocol:
    """All runs of a recording and its columns; `fraction` of a run spans 0 (start) to 1 (largest drive)."""

    runs: tuple[RunPlan, ...]
    response: str
    has_time: bool
    has_tension: bool
    slack_start: bool
    dt: float

    @property
    def lengths(self) -> int:
        """Number of bending lengths."""
        return len({run.length for run in self.runs})

    def kinds(self) -> set[str]:
        """Return the kinds of sweep."""
        return {run.kind for run in self.runs}

    def without(self, run: int) -> Protocol:
        """Return the protocol that is left when a run is held out."""
        return replace(self, runs=self.runs[:run] + self.runs[run + 1 :])

    def has(self, *names: str) -> bool:
        """Return whether any run is of one of these kinds."""
        return bool(self.kinds() & set(names))

    def rates(self) -> float:
        """Fastest over slowest median speed of the runs' moving legs, in fraction of the range per second."""
        speeds: list[float] = []
        for run in self.runs:
            speed = np.abs(np.diff(run.fraction) / np.diff(run.time))
            speeds += list(np.quantile(speed[speed > 1e-9], [0.15, 0.85]))
        return max(speeds) / min(speeds)

    def steps(self) -> float:
        """Largest fraction of the range moved between two recorded rows."""
        return max(float(np.max(np.abs(np.diff(run.fraction[run.recorded])))) for run in self.runs)


RELEASING = ("triangle", "partial", "cycles", "rates", "ladder_down")
Needs = Callable[[Protocol], bool]


def _legs(kind: str, rng: np.random.Generator) -> list[tuple[float, float, float]]:
    """Legs (target fraction, speed, hold) of one run."""
    top = rng.uniform(0.75, 1.0)
    if kind == "load":
        return [(rng.uniform(0.85, 1.0), 1.0, 0.0)]
    if kind == "triangle":
        return [(top, 1.0, 0.0), (rng.choice([0.0, 0.0, 0.2]), 1.0, 0.0)]
    if kind == "partial":
        a, b = rng.uniform(0.4, 0.6), rng.uniform(0.65, 0.85)
        return [
            (a, 1.0, 0.0),
            (a - rng.uniform(0.15, 0.35), 1.0, 0.0),
            (b, 1.0, 0.0),
            (b - rng.uniform(0.2, 0.45), 1.0, 0.0),
            (1.0, 1.0, 0.0),
            (rng.uniform(0.0, 0.4), 1.0, 0.0),
        ]
    if kind in ("ladder", "ladder_down"):
        steps = int(rng.integers(3, 6))
        hold = rng.uniform(0.6, 2.5)
        up = [(float(f), 3.0, hold) for f in np.linspace(0, top, steps + 1)[1:]]
        return up + (
            [(float(f), 3.0, hold) for f in np.linspace(top, 0, steps + 1)[1:]] if kind == "ladder_down" else []
        )
    if kind == "cycles":
        grow = rng.random() < 0.7
        low = rng.choice([0.0, 0.0, 0.15])
        peaks = np.linspace(0.45, 1.0, int(rng.integers(2, 5))) if grow else np.full(int(rng.integers(2, 5)), top)
        return [leg for p in peaks for leg in ((float(p), 1.0, 0.0), (low, 1.0, 0.0))]
    if kind == "rates":
        fast = rng.uniform(3.0, 6.0)
        return [(top, 1.0, 0.0), (0.0, 1.0, 0.0), (top, fast, 0.0), (0.0, fast, 0.0)]
    raise ValueError(kind)


def _run(
    rng: np.random.Generator, kind: str, count: int, dt: float, jitter: float, start: float
) -> tuple[Array, Array, NDArray[np.int64]]:
    legs = _legs(kind, rng)
    corners, drives, here = [0.0], [start], start
    for wanted, speed, hold in legs:
        target = max(float(wanted), start)
        corners.append(corners[-1] + max(abs(target - here), 0.02) / speed)
        drives.append(target)
        here = target
        if hold:
            corners.append(corners[-1] + hold * 0.3)
            drives.append(target)
    duration = (count - 1) * dt
    knots = np.array(corners) / corners[-1] * duration
    sampled = np.arange(count) * dt
    sampled[1:-1] += rng.uniform(-jitter, jitter, count - 2) * dt
    # A knot at a sampled time but for rounding would be a step of no duration.
    near = np.abs(knots[:, None] - sampled).min(axis=1) < 1e-6 * dt
    time = np.union1d(sampled, knots[~near])
    return time, np.interp(time, knots, drives), np.searchsorted(time, sampled).astype(np.int64)


def _as_people_do(rng: np.random.Generator, plan: RunPlan, habit: str) -> RunPlan:
    """Return a run as it is really taken: at uneven speed, interrupted, or recorded from somewhere on the way."""
    if habit == "uneven":
        # The hand that turns the screw is now faster, now slower; drive and rows keep their order.
        share = (plan.time - plan.time[0]) / (plan.time[-1] - plan.time[0])
        a, b, phase = rng.uniform(0.3, 0.8), rng.integers(2, 6), rng.uniform(0, 2 * np.pi)
        warped = share + a * (np.sin(2 * np.pi * b * share + phase) - np.sin(phase)) / (2 * np.pi * b)
        return replace(plan, fraction=np.interp(warped / warped[-1], share, plan.fraction))
    if habit == "stopped":
        keep = plan.time[plan.recorded] <= rng.uniform(0.72, 0.95) * plan.time[-1]
        last = int(plan.recorded[keep][-1]) + 1
        return replace(plan, time=plan.time[:last], fraction=plan.fraction[:last], recorded=plan.recorded[keep])
    if habit == "paused":
        # Somebody came in: the drive waits, the clock and mostly the camera run on.
        at = int(rng.uniform(0.2, 0.8) * plan.recorded.size)
        wait = rng.uniform(0.1, 0.4) * (plan.time[-1] - plan.time[0])
        return replace(plan, time=plan.time + wait * (np.arange(plan.time.size) > plan.recorded[at]))
    # The camera is started when the drive is already under way: what went before is not in the file.
    return replace(plan, recorded=plan.recorded[int(rng.uniform(0.1, 0.3) * plan.recorded.size) :])


HABITS = ("uneven", "stopped", "paused", "late")


def draw_protocol(rng: np.random.Generator, outers: int, middles: int, *, wrist: float | None = None) -> Protocol:
    """Return a random protocol; `wrist` is the full length (m) of a tension-driven tube recorded notch by notch."""
    runs_wanted = int(rng.choice([2, 3, 3, 4, 4, 5, 6]))
    total = int(np.exp(rng.uniform(np.log(120), np.log(800))))
    dt = float(np.exp(rng.uniform(np.log(0.02), np.log(0.5))))
    jitter = float(rng.choice([0.0, 0.0, 0.05, 0.2]))
    if wrist is not None:
        lengths = [wrist]
    else:
        number = int(rng.choice([1, 2, 3, 3, 4], p=[0.2, 0.25, 0.2, 0.2, 0.15]))
        lengths = (
            list(np.round(np.linspace(rng.uniform(10, 20), rng.uniform(28, 40), number), 1) * 1e-3)
            if number > 1
            else [round(rng.uniform(12, 40), 1) * 1e-3]
        )
    style = rng.choice(
        ["mixed", "load", "triangle", "partial", "cycles", "ladder"], p=[0.5, 0.1, 0.12, 0.12, 0.08, 0.08]
    )
    palette = ["load", "triangle", "triangle", "partial", "partial", "ladder", "ladder_down", "cycles", "rates"]
    kinds = [str(rng.choice(palette)) if style == "mixed" else str(style) for _ in range(runs_wanted)]
    several_pairs = wrist is None and outers * middles > 1 and rng.random() < 0.15
    weights = np.array([{"load": 1.0, "triangle": 1.6}.get(kind, 2.4) for kind in kinds])
    counts = np.maximum((total * weights / weights.sum()).astype(int), 25)
    slack = bool(rng.random() < 0.6)
    plans = []
    for index, (kind, count) in enumerate(zip(kinds, counts, strict=True)):
        pace = float(rng.choice([1.0, 1.0, 0.4, 2.5]))
        time, fraction, recorded = _run(rng, kind, int(count), dt * pace, jitter, 0.0)
        outer = None if not outers else (int(rng.integers(outers)) if several_pairs else 0)
        middle = int(rng.integers(middles)) if several_pairs else 0
        plans.append(RunPlan(outer, middle, float(lengths[index % len(lengths)]), kind, time, fraction, recorded))
    if rng.random() < 0.25:
        # The same run once more, as a check.
        plans[-1] = plans[int(rng.integers(len(plans)))]
    if rng.random() < 0.4:
        habit = str(rng.choice(HABITS))
        plans = [_as_people_do(rng, plan, habit) if rng.random() < 0.6 else plan for plan in plans]
    return Protocol(
        tuple(plans),
        "notch" if wrist is not None else str(rng.choice(["curvature", "curvature", "bend"])),
        bool(rng.random() < 0.75),
        bool(wrist is None and rng.random() < 0.35),
        slack,
        dt,
    )


# What a proposal in words asks for, and the runs a laboratory would then record.
REQUESTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "release": (r"releas|unload|revers|return|cycle|hysteres|back down", ("partial", "triangle", "cycles")),
    "holds": (r"hold|dwell|stair|creep", ("ladder_down", "ladder")),
    "lengths": (r"bending length|x2|lengths", ("triangle", "triangle", "triangle")),
    "rates": (r"rate|speed|fast|slow|time", ("rates", "rates")),
    "slack": (
        r"slack|zero tension|at rest|no tension|below the dead|zero stroke",
        ("triangle", "triangle", "triangle"),
    ),
    "tension": (r"tension|force|load cell", ("triangle", "partial")),
}


def requested_protocol(rng: np.random.Generator, request: str, given: Protocol) -> Protocol:
    """Return the protocol of one further recording of the same robot; everything else stays as it was."""
    kinds = REQUESTS[request][1]
    first = given.runs[0]
    # A tube recorded notch by notch has but one length.
    free = request in ("lengths", "slack") and given.response != "notch"
    lengths = [12e-3, 24e-3, 38e-3] if free else sorted({run.length for run in given.runs})
    plans = []
    for index, kind in enumerate(kinds):
        time, fraction, recorded = _run(rng, kind, 110, given.dt, 0.0, 0.0)
        plans.append(RunPlan(first.outer, first.middle, lengths[index % len(lengths)], kind, time, fraction, recorded))
    return replace(
        given,
        runs=tuple(plans),
        has_time=True,
        has_tension=request == "tension" or given.has_tension,
        slack_start=request == "slack" or given.slack_start,
    )
