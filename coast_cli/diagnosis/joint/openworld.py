"""Names against the nameless: whether a law without a name, at another stage, explains more than the names do.

Every explanation is asked of the same rows under the recording's own noise: rows that were fitted and rows that choose.
A name is refused where the data ask for more (noise alone would ask as loudly only rarely) and a law that stands elsewhere gives
it; what a name leaves at its own place is its form, and is told beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from coast_cli.diagnosis.contest import Contest, Hypothesis
from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.thresholds import (
    LACK_OF_FIT,
    LAW_NATS,
    LAW_TIE,
    LAW_UNSEEN,
    MAX_UNEXPLAINED_NOISE,
    MAX_UNEXPLAINED_SHARE,
    REFUSING_NATS,
)
from coast_cli.diagnosis.unnamed.screen import Screened, screen_laws
from coast_cli.diagnosis.unnamed.search import LawFit, Searched, misfit, search_laws
from coast_cli.effects.grammar import stands_at
from coast_cli.effects.unnamed import UnnamedLaw


@dataclass(frozen=True)
class OpenWorld:
    """The contest's leader beside laws without a name.

    Attributes:
        problem: with the rows that are fitted. choosing: the same with the rows that choose.
        contest: of names.
    """

    problem: JointProblem
    choosing: JointProblem
    contest: Contest

    @cached_property
    def asked(self) -> Screened:
        """What the leading names leave to be explained."""
        return screen_laws(self.problem, self.contest.leading.fit)

    @property
    def is_complete(self) -> bool:
        """Whether the leading names leave no more than noise: in size, or as loudly as noise alone would ask for more."""
        leading = self.contest.leading
        small = bool(leading.ids) and self.left_over(leading.fit) < MAX_UNEXPLAINED_NOISE
        return small or self.asked.p_value > LACK_OF_FIT

    @cached_property
    def instead(self) -> Searched:
        """Laws in place of any name."""
        base = self.contest.base.fit
        asked = screen_laws(self.problem, base) if self.contest.leading.ids else self.asked
        return search_laws(self.problem, self.choosing, base, asked)

    @cached_property
    def beside(self) -> Searched:
        """Laws beside the leading names."""
        if not self.contest.leading.ids:
            return self.instead
        return search_laws(self.problem, self.choosing, self.contest.leading.fit, self.asked, most_laws=1)

    @cached_property
    def scale(self) -> float:
        """Variance that even the closest explanation leaves, in the noise's: nats count by it."""
        return max(1.0, min((law.misfit for law in self.instead.laws[:1]), default=1.0))

    def surprise(self, fitted: Fit) -> float:
        """Return what the fitted and the choosing rows say against a fit, and what its numbers cost, nats."""
        inside, count = misfit(self.problem, fitted)
        outside, unseen = misfit(self.choosing, fitted)
        price = 0.5 * sum(len(effect.parameters) for effect in fitted.effects) * np.log(max(count, 1))
        return float(0.5 * (inside * count + outside * unseen) + price)

    def left_over(self, fitted: Fit) -> float:
        """Return what a fit leaves beyond the noise, in noise widths: on the choosing rows, or on all where none choose."""
        outside, count = misfit(self.choosing, fitted)
        left = outside if count else misfit(self.problem, fitted)[0]
        return float(np.sqrt(max(left - 1.0, 0.0)))

    def gain(self, law: LawFit, fitted: Fit) -> float:
        """Return by how many nats a law is ahead of a fit, counted by what even the law leaves."""
        return (self.surprise(fitted) - law.surprise) / self.scale

    def carries_over(self, law: LawFit, before: Fit) -> bool:
        """Return whether the choosing rows too are foretold better with a law."""
        outside, count = misfit(self.choosing, before)
        if count == 0:
            return True
        return 0.5 * (outside - law.unseen) * count / self.scale > LAW_UNSEEN

    @cached_property
    def preferred(self) -> LawFit | None:
        """The law that stands in place of the leading names, or None where they stand."""
        leading = self.contest.leading
        if self.is_complete or not self.instead.laws:
            return None
        best = self.instead.laws[0]
        if not self.carries_over(best, leading.fit if leading.ids else self.contest.base.fit):
            return None
        if not leading.ids:
            return best if self.gain(best, leading.fit) > LAW_NATS else None
        if self.gain(best, leading.fit) <= REFUSING_NATS or self.left_over(leading.fit) < MAX_UNEXPLAINED_NOISE:
            return None
        if self._stands_with(best, leading):
            too_much = MAX_UNEXPLAINED_SHARE * self.left_over(self.contest.base.fit)
            return best if self.left_over(leading.fit) > too_much and not self._completed(best) else None
        own = [law for law in self.instead.laws if self._stands_with(law, leading)]
        if own and self.gain(best, own[0].fit) <= REFUSING_NATS:
            return None
        return None if self._completed(best) else best

    def _completed(self, best: LawFit) -> bool:
        """Return whether the names with one law beside them say more than laws alone; of as many terms, as much."""
        laws = self.beside.laws
        if not laws or not self.carries_over(laws[0], self.contest.leading.fit):
            return False
        fewer = len(best.fit.effects) < len(laws[0].fit.effects)
        margin = -REFUSING_NATS if fewer else REFUSING_NATS
        return laws[0].surprise <= best.surprise + margin * self.scale

    def _stands_with(self, law: LawFit, leading: Hypothesis) -> bool:
        mine = [effect for effect in law.fit.effects if isinstance(effect, UnnamedLaw)]
        return all(any(stands_at(effect, one) for effect in leading.fit.effects) for one in mine)

    @cached_property
    def added(self) -> LawFit | None:
        """A law beside the leading names that takes what they leave, or None where that is no more than noise."""
        leading = self.contest.leading
        if not leading.ids or self.is_complete or self.preferred is not None or not self.beside.laws:
            return None
        best = self.beside.laws[0]
        enough = self.gain(best, leading.fit) > LAW_NATS and self.left_over(leading.fit) > MAX_UNEXPLAINED_NOISE
        return best if enough and self.carries_over(best, leading.fit) else None

    def alike(self, law: LawFit) -> tuple[LawFit, ...]:
        """Return a law as fitted, and others that the recording cannot tell from it: of one law each, or of two."""
        searched = self.instead if not self.contest.leading.ids or law in self.instead.laws else self.beside
        terms = len(law.fit.effects)
        found = [
            one
            for one in searched.laws
            if len(one.fit.effects) == terms and one.surprise <= law.surprise + LAW_TIE * self.scale
        ]
        kinds = {_kinds(one): one for one in reversed([law, *found])}
        return law, *(one for one in reversed(kinds.values()) if one is not law)

    @cached_property
    def nearest(self) -> tuple[tuple[str, float], ...]:
        """Single names by what each leaves on the choosing rows, in noise widths, least first."""
        singles = [h for h in self.contest.tried if len(h.ids) == 1]
        found = {h.ids[0]: round(self.left_over(h.fit), 3) for h in singles}
        return tuple(sorted(found.items(), key=lambda one: (one[1], one[0]))[:3])


def _kinds(law: LawFit) -> frozenset[tuple[str, str, str]]:
    return frozenset((e.place, e.variable, e.memory) for e in law.fit.effects if isinstance(e, UnnamedLaw))
