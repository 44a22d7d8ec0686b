"""The leading cells as laws in free run: each sees its own state, is fitted with the base, and is asked of unseen rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.unnamed.screen import Candidate, Screened, noise_colour, screen_laws
from coast_cli.effects.catalogue import in_order
from coast_cli.effects.unnamed import Memory, Place, UnnamedLaw, Variable

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem

# Kinds of cells that are refitted in free run, and how far behind the leader's evidence the last of them may be.
MOST_KINDS = 6
SECOND_KINDS = 3
# Leading laws on which a second one is sought, where noise alone asks for it less often than this.
LEADERS = 2
WANTED = 0.01
LEAST_SHARE = 0.6
_LIMIT = 20.0  # times the amplitude that the screen found
_SETTINGS = 1
_RACE_STEPS = 4
FINISHED = 2


@dataclass(frozen=True, slots=True)
class LawFit:
    """A law in free run, beside what was there already.

    Attributes:
        law: as fitted. fit: of base, effects and law. misfit: mean squared whitened residual of rows that were fitted,
            and ``unseen``: of rows that choose; 1 at the recording's own noise.
        count: of whitened rows that were fitted and that choose.
    """

    law: UnnamedLaw
    fit: Fit
    misfit: float
    unseen: float
    count: tuple[int, int]

    @property
    def kind(self) -> tuple[Place, Variable, Memory]:
        """Stage, variable and memory."""
        return self.law.place, self.law.variable, self.law.memory

    @property
    def surprise(self) -> float:
        """Half the sum of squared whitened residuals over both kinds of rows, and half a log row for each amplitude, nats."""
        fitted, chosen = self.count
        numbers = sum(len(effect.parameters) for effect in self.fit.effects)
        price = 0.5 * numbers * np.log(max(fitted, 1))
        return float(0.5 * (self.misfit * fitted + self.unseen * chosen) + price)


@dataclass(frozen=True, slots=True)
class Searched:
    """What a search found.

    Attributes:
        p_value: how often noise alone asks as loudly for a law as the starting fit does. laws: least surprise first; those
            of the leading place in the model, or pairs where one law leaves a second one wanted.
        left: p-value of a further law on the leading one.
    """

    p_value: float
    laws: tuple[LawFit, ...]
    left: float


def misfit(problem: JointProblem, fitted: Fit) -> tuple[float, int]:
    """Return the mean squared whitened residual of a problem's fitted rows, 1 at the recording's own noise, and their count."""
    response, tension = problem.fitted(problem.predict(fitted.coordinates, fitted.effects))
    level = max(problem.noise_estimate.level, 1e-15)
    white = problem.bank.whiten((problem.observed - response) / level, noise_colour(problem))
    total, count = float(white @ white), white.size
    if problem.tension_noise is not None and tension.size:
        off = (problem.observed_tension - tension) / max(problem.tension_noise, 1e-15)
        total, count = total + float(off @ off), count + off.size
    return total / max(count, 1), count


def search_laws(
    problem: JointProblem, choosing: JointProblem, fitted: Fit, screened: Screened, *, most_laws: int = 2, seed: int = 0
) -> Searched:
    """Return laws that explain what a fit leaves: one, or two where the leading one leaves a second wanted.

    Args:
        problem: with the rows that are fitted. choosing: the same with the rows that choose.
        fitted: base and effects that are there already. screened: what it asks for.
        most_laws: that are added. seed: of the draws of noise.
    """
    number = 1 + sum(isinstance(effect, UnnamedLaw) for effect in fitted.effects)
    laws = refit_laws(problem, choosing, fitted, screened, number=number)
    if not laws:
        return Searched(screened.p_value, (), screened.p_value)
    leaders = LEADERS if most_laws > 1 else 1
    further = [screen_laws(problem, law.fit, seed=seed) for law in laws[:leaders]]
    left = further[0].p_value
    if left > WANTED or most_laws < 2:
        return Searched(screened.p_value, laws, left)
    pairs = [
        pair
        for law, asked in zip(laws[:LEADERS], further, strict=True)
        for pair in refit_laws(problem, choosing, law.fit, asked, number=2, most=SECOND_KINDS)
    ]
    both = tuple(sorted((*laws, *pairs), key=lambda law: (law.surprise, law.kind)))
    return Searched(screened.p_value, both, screen_laws(problem, both[0].fit, seed=seed).p_value)


def refit_laws(
    problem: JointProblem,
    choosing: JointProblem,
    fitted: Fit,
    screened: Screened,
    *,
    number: int = 1,
    most: int = MOST_KINDS,
) -> tuple[LawFit, ...]:
    """Return the most promising laws as fitted in free run, least surprise first.

    Args:
        problem: with the rows that are fitted. choosing: the same with the rows that choose.
        fitted: base and effects that are there already. screened: what it asks for. number: of the law in its model.
    """
    started = []
    for candidate in _promising(screened, most):
        law = candidate.cell.law(candidate.weights, _LIMIT * candidate.scale(), number)
        effects = in_order((*fitted.effects, law))
        rough = fit(problem, effects, fitted.coordinates, steps=_RACE_STEPS, until="rough")
        started.append(_asked(problem, choosing, rough, number))
    finished = []
    for one in _best_of_each_kind(started)[:FINISHED]:
        whole = fit(problem, one.fit.effects, one.fit.coordinates, until="fine")
        finished.append(_asked(problem, choosing, whole, number))
    return _best_of_each_kind(finished)


def _asked(problem: JointProblem, choosing: JointProblem, whole: Fit, number: int) -> LawFit:
    """Return a fit with a law, asked of the rows that were fitted and of those that choose."""
    mine = next(e for e in whole.effects if isinstance(e, UnnamedLaw) and e.number == number)
    inside, count = misfit(problem, whole)
    outside, unseen = misfit(choosing, whole)
    return LawFit(mine, whole, inside, outside, (count, unseen))


def _best_of_each_kind(found: Sequence[LawFit]) -> tuple[LawFit, ...]:
    best: dict[tuple[Place, Variable, Memory], LawFit] = {}
    for one in sorted(found, key=lambda law: (law.surprise, law.kind)):
        best.setdefault(one.kind, one)
    return tuple(best.values())


def _promising(screened: Screened, most: int) -> list[Candidate]:
    """Return the best settings of the leading kinds; friction must dissipate."""
    kinds: dict[tuple[Place, Variable, Memory], list[Candidate]] = {}
    for candidate in screened.candidates:
        if candidate.evidence < LEAST_SHARE * screened.evidence and len(kinds) >= most // 2:
            break
        if candidate.cell.memory == "friction" and candidate.weights[0] <= 0.0:
            continue
        kept = kinds.setdefault(candidate.cell.kind, [])
        settings = {(one.cell.setting, one.cell.play) for one in kept}
        alike = any(one.cell.count == candidate.cell.count for one in kept)
        if len(kept) < _SETTINGS and (not alike or (candidate.cell.setting, candidate.cell.play) not in settings):
            kept.append(candidate)
        if len(kinds) > most:
            kinds.popitem()
            break
    return [one for kept in kinds.values() for one in kept]
