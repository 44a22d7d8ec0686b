"""Figures over many judgements: shares with their intervals, reliability, errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from examples.concealed.judge import FACTS, Judgement
from examples.concealed.points import OPEN

BINS = np.linspace(0.0, 1.0, 11)


@dataclass(frozen=True)
class Rate:
    """A share of cases with its Wilson 95 % interval."""

    hits: int
    cases: int

    @property
    def value(self) -> float:
        """The share, NaN without cases."""
        return self.hits / self.cases if self.cases else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval."""
        if not self.cases:
            return math.nan, math.nan
        z, n, p = 1.959964, self.cases, self.value
        centre = (p + z * z / 2 / n) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / 4 / n / n)
        return max(centre - half, 0.0), min(centre + half, 1.0)

    def text(self) -> tuple[str, str, str]:
        """Return share, number of cases and interval as words; a figure without cases is a dash, never a pass."""
        if not self.cases:
            return "-", "0", "-"
        low, high = self.interval
        return f"{100 * self.value:.1f} %", str(self.cases), f"{100 * low:.1f} to {100 * high:.1f} %"


@dataclass
class Scores:
    """All judgements of a run, those of other answers on some of the same cases, and where they came from.

    `others` holds, by the name of an answer, its judgements; `about` the digests of seal, laws and code.
    """

    judgements: list[Judgement]
    others: dict[str, list[Judgement]] = field(default_factory=dict)
    about: dict[str, str] = field(default_factory=dict)

    @property
    def unanswered(self) -> int:
        """Cases without an answer."""
        return sum(j.said_class == "failed" for j in self.judgements)

    def rate(self, pick: Callable[[Judgement], bool | None], levels: Iterable[str] = ()) -> Rate:
        """Share of the cases (of these levels) for which `pick` holds; None leaves a case out."""
        return rate(self.judgements, pick, levels)

    @property
    def false_alarms(self) -> Rate:
        """Share of clean records on which something was named."""
        return self.rate(lambda j: j.alarm, ("L0",))

    @property
    def named_first(self) -> Rate:
        """Share of single effects named first."""
        return self.rate(lambda j: j.first, ("L1",))

    @property
    def told_apart(self) -> Rate:
        """None, parameter, physics, sensor and unknown told apart."""
        return self.rate(lambda j: j.told)

    def called(self, true: str, said: str) -> Rate:
        """Share of effects of one class that were called the other."""
        return self.rate(lambda j: j.said_class == said if j.truth_class == true else None, ("L1", "L5"))

    def fact(self, name: str) -> Rate:
        """Share of laws outside the catalogue whose stage, variable, memory or rate was given right."""
        at = FACTS.index(name)
        return self.rate(lambda j: None if j.facts is None else j.facts[at], OPEN)

    @property
    def mean_score(self) -> float:
        """Mean score over all cases."""
        return mean_score(self.judgements)

    def worst(self, count: int, level: str) -> list[Judgement]:
        """Lowest scores of a level first; among equals the most confident."""
        mine = [j for j in self.judgements if j.level == level and j.score < 0.25]
        return sorted(mine, key=lambda j: (j.score, -(j.confidence or 0), j.case))[:count]

    def ratios(self, levels: Iterable[str] = ()) -> list[float]:
        """Held-out errors over those of the true form refitted, where both are known."""
        wanted, true = set(levels), {j.case: j for j in self.others.get(TRUE_FORM, ())}
        return [
            j.figures["recorded"] / true[j.case].figures["recorded"]
            for j in self.judgements
            if (not wanted or j.level in wanted) and j.case in true and "recorded" in j.figures
        ]

    def intervals(self, name: str) -> Rate:
        """Share of base parameters inside their 90 % interval, over all cases."""
        hits = [hit for j in self.judgements for parameter, hit, _ in j.intervals if parameter == name]
        return Rate(sum(hits), len(hits))

    def biases(self, name: str) -> list[float]:
        """Size of the bias (%) of a base parameter, over all cases."""
        return [abs(bias) for j in self.judgements for parameter, _, bias in j.intervals if parameter == name]


TRUE_FORM = "true form refitted"


def rate(judgements: Iterable[Judgement], pick: Callable[[Judgement], bool | None], levels: Iterable[str] = ()) -> Rate:
    """Share of the judgements (of these levels) for which `pick` holds; None leaves a case out."""
    wanted = set(levels)
    found = [bool(value) for j in judgements if (not wanted or j.level in wanted) and (value := pick(j)) is not None]
    return Rate(sum(found), len(found))


def mean_score(judgements: list[Judgement]) -> float:
    """Mean score, NaN without cases."""
    return float(np.mean([j.score for j in judgements])) if judgements else math.nan


def reliability(judgements: Iterable[Judgement]) -> list[tuple[float, float, int]]:
    """Return (mean probability stated, share that came true, number) of each of ten bins that holds any."""
    stated = [belief for j in judgements for belief in j.beliefs]
    if not stated:
        return []
    said, came = (np.array(column, float) for column in zip(*stated, strict=True))
    at = np.clip(np.digitize(said, BINS) - 1, 0, 9)
    held = [at == k for k in range(10) if np.any(at == k)]
    return [(float(said[mine].mean()), float(came[mine].mean()), int(mine.sum())) for mine in held]


def calibration_error(judgements: Iterable[Judgement]) -> float:
    """Return the mean distance of the probability stated and the share that came true, each bin by its number."""
    bins = reliability(judgements)
    total = sum(count for _, _, count in bins)
    return sum(abs(said - came) * count for said, came, count in bins) / total if total else math.nan
