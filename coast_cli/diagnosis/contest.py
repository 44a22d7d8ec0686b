"""The contest: parameter errors, sensor artefacts and physics compete to explain what the base model leaves over.

Each hypothesis is a set of effects, fitted together with the base parameters. Its score is its likelihood as noise of
unknown level and colour, less the Occam factor of its parameters (Laplace's approximation of the evidence: MacKay,
Neural Computation 4 (1992) 415). Sets grow one effect at a time, only while an effect earns its place. A screen predicts
every start of every candidate once; the most promising race for a few steps, and the first of them are finished.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from coast_cli.diagnosis.fit import Fit, fit, rms
from coast_cli.diagnosis.problem import Contender, Problem, Variant
from coast_cli.diagnosis.space import inverse
from coast_cli.diagnosis.thresholds import (
    ALIKE_NATS,
    AT_FLOOR,
    CLOSE_ENDS,
    EFFECT_NATS,
    GROWS_BY,
    MOST_CLOSE_ENDS,
    QUIET,
    TIE,
    WORTH_GROWING,
)
from coast_cli.effects.effect import Effect
from coast_cli.mechanics.section import FloatArray

EffectsKey = frozenset[Variant]
_GROWN_FROM = 2  # sets that are grown further
_ALWAYS_FINISHED = 2
_DIGITS = 4  # of nats that order a race
_UNSEEN = 1e-12  # share of the residual under which a start changes nothing


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A fitted set of effects, what it is, and its score in nats."""

    fit: Fit
    key: EffectsKey
    score: float

    @property
    def ids(self) -> tuple[str, ...]:
        """Effect ids in the order in which they act."""
        return self.fit.ids

    @property
    def paid(self) -> float:
        """The score once every effect has paid for being named."""
        return self.score - EFFECT_NATS * len(self.ids)


@dataclass(frozen=True, slots=True)
class Contest:
    """Everything that was fitted, best first; ``base`` is the model with refitted parameters alone."""

    base: Hypothesis
    tried: tuple[Hypothesis, ...]
    leading: Hypothesis

    def alternatives(self) -> tuple[Hypothesis, ...]:
        """Return other sets, no larger, that the data cannot tell from the leading one; the best of each set of ids.

        One that fits as closely, and is behind only by what its numbers cost, is told from it by less than an effect costs.
        """
        if not self.leading.ids:
            return ()
        found: dict[frozenset[str], Hypothesis] = {frozenset(self.leading.ids): self.leading}
        for other in self.tried:
            ids = frozenset(other.ids)
            as_close = other.fit.log_likelihood >= self.leading.fit.log_likelihood
            margin = EFFECT_NATS if as_close and len(ids) == len(self.leading.ids) else ALIKE_NATS
            if 0 < len(ids) <= len(self.leading.ids) and ids not in found and other.score > self.leading.score - margin:
                found[ids] = other
        return tuple(found.values())[1:]

    def parts(self) -> tuple[Hypothesis, ...]:
        """Return sets inside the leading one that earn their place over the base model too, best first."""
        leading = set(self.leading.ids)
        return tuple(h for h in self.tried if h.ids and set(h.ids) < leading and h.paid > self.base.score)


def run_contest(problem: Problem, most_effects: int = 5) -> Contest:
    """Fit and compare all sets worth comparing, up to ``most_effects`` effects.

    Sets grow by how much of the plain error they remove, because to coloured noise a half-explained misfit looks no
    likelier than a whole one; which of them leads is then judged by evidence, each effect paying ``EFFECT_NATS``.
    """
    base = hypothesis(problem, fit(problem))
    tried: dict[EffectsKey, Hypothesis] = {base.key: base}
    frontier = [base]
    for size in range(1, min(most_effects, problem.most_effects()) + 1):
        grown = _by_plain_error(problem, _grow(problem, frontier, tried, first=size == 1))
        if not grown or not _worth_growing(problem, frontier, grown[0]):
            break
        frontier = grown[:_GROWN_FROM]
        if grown[0].fit.rmse < max(AT_FLOOR * problem.noise_floor, problem.effort.enough * base.fit.rmse):
            break
    if problem.effort.exchanges:
        _exchange(problem, tried)
    _tighten(problem, tried)
    return settled(problem, base, tried.values())


def settle_close_ends(contest: Contest, problem: Problem, whole: Problem) -> Contest:
    """Return the contest with its close ends decided on every row, those held out among them.

    Only the choice between sets that score alike is made so, by scores of fits to ``whole``: each keeps its own fit.
    """
    leading = contest.leading
    if not leading.ids:
        return contest
    close = [h for h in ranked(contest.tried, lambda h: h.paid) if h.paid > leading.paid - CLOSE_ENDS]
    close = close[: int(MOST_CLOSE_ENDS)]
    if len(close) < 2:
        return contest
    scores = {}
    for one in close:
        start = carried_start(problem=problem, fitted=one.fit, whole=whole)
        scores[one.key] = hypothesis(whole, fit(whole, one.fit.effects, start, steps=6, until="fine")).score
    ahead = scores.get(leading.key, leading.score) - leading.score
    decided = {one.key: one for one in contest.tried}
    decided |= {one.key: replace(one, score=scores[one.key] - ahead) for one in close}
    return settled(problem, contest.base, decided.values())


def carried_start(*, problem: Problem, fitted: Fit, whole: Problem) -> FloatArray:
    """Return a fit's base coordinates where another problem of the same model has them, else as configured."""
    known = {p.name: float(c) for p, c in zip(problem.base, fitted.coordinates, strict=True)}
    return np.array([known.get(p.name, p.inner) for p in whole.base])


def settled(problem: Problem, base: Hypothesis, tried: Iterable[Hypothesis]) -> Contest:
    """Return the contest of hypotheses that were tried, the leading one found."""
    known = list(tried)
    return Contest(base, ranked(known, lambda h: h.score), _leading(problem, base, known))


def hypothesis(problem: Problem, fitted: Fit) -> Hypothesis:
    """Return a fit with its score: likelihood less Occam's factor and what the set is less likely beforehand."""
    score = fitted.log_likelihood - _occam(problem, fitted) - problem.prior_penalty_nats(fitted.effects)
    return Hypothesis(fitted, _key(problem, fitted.effects), score)


def ranked(hypotheses: Iterable[Hypothesis], score: Callable[[Hypothesis], float]) -> tuple[Hypothesis, ...]:
    """Return hypotheses best first; scores within ``TIE`` of the best left go by fewer parameters, then by id."""
    left = sorted(hypotheses, key=lambda h: (-score(h), h.ids))
    found: list[Hypothesis] = []
    while left:
        best = score(left[0])
        tied = [h for h in left if score(h) > best - TIE]
        chosen = min(tied, key=lambda h: (h.fit.parameter_count, h.ids, sorted(h.key)))
        found.append(chosen)
        left.remove(chosen)
    return tuple(found)


def _key(problem: Problem, effects: Sequence[Effect]) -> EffectsKey:
    return frozenset(problem.variant(effect) for effect in effects)


def _leading(problem: Problem, base: Hypothesis, tried: Sequence[Hypothesis]) -> Hypothesis:
    """Return the set with the most evidence after every effect has paid, and in which each is large enough to name."""
    for one in ranked(tried, lambda h: h.paid):
        if one.fit.rmse > problem.effort.most_behind * min(h.fit.rmse for h in tried if len(h.key) <= len(one.key)):
            continue
        smaller = [other for other in tried if other.key < one.key and len(other.key) == len(one.key) - 1]
        if all(problem.is_needed(one.fit, other.fit, base.fit) for other in smaller):
            return one
    return base


def _occam(problem: Problem, fitted: Fit) -> float:
    """Return the log of prior over posterior width of what evidence charges for, in nats; useless ones cost nothing."""
    space = problem.space(fitted.effects)
    paying = space.pays & space.moving
    if not paying.any():
        return 0.0
    width = space.width[paying]
    sharper = inverse(fitted.covariance[np.ix_(paying, paying)]) * np.outer(width, width)
    # By eigenvalues: where one parameter is known far better than another, a determinant loses the lesser one.
    return 0.5 * float(np.sum(np.log(np.maximum(np.linalg.eigvalsh(sharper + np.diag(~space.expected[paying])), 1.0))))


def _grow(
    problem: Problem, frontier: Sequence[Hypothesis], tried: dict[EffectsKey, Hypothesis], *, first: bool
) -> list[Hypothesis]:
    """Fit the sets one effect larger than those of the frontier; put them into ``tried``, return what may grow further."""
    effort, stage = problem.effort, 0 if first else 1
    started: dict[EffectsKey, tuple[float, Fit]] = {}
    for parent in frontier:
        fresh: dict[EffectsKey, tuple[float, Fit]] = {}
        promising = screen(problem, parent.fit, problem.candidates(parent.fit.effects))
        expected = [one for one in promising[effort.fitted[stage] :] if one.candidate.expected and parent.ids]
        for one in (*promising[: effort.fitted[stage]], *expected):
            for start in one.starts:
                effects = problem.ordered((*parent.fit.effects, start))
                key = _key(problem, effects)
                if key in tried or key in started:
                    continue
                begun = fit(problem, effects, parent.fit.coordinates, steps=effort.steps, until="rough")
                error = plain_error(problem, begun)
                if key not in fresh or error < fresh[key][0]:
                    fresh[key] = error, begun
        started |= fresh
    order = sorted(started.items(), key=lambda item: item[1][0])[: effort.finished[stage]]
    grown = []
    for place, (key, (error, begun)) in enumerate(order):
        if place >= _ALWAYS_FINISHED and error > order[0][1][0] + effort.far_behind:
            break
        tried[key] = hypothesis(problem, fit(problem, begun.effects, begun.coordinates, until="fine"))
        grown.append(tried[key])
    return grown


def _exchange(problem: Problem, tried: dict[EffectsKey, Hypothesis]) -> None:
    """Try each effect of the leading set against its rivals: what was taken first, alone, may have stood for two."""
    leading = _leading(problem, next(iter(tried.values())), list(tried.values()))
    for effect in leading.fit.effects if len(leading.ids) > 1 else ():
        rest = tuple(other for other in leading.fit.effects if other is not effect)
        key = _key(problem, rest)
        if key not in tried:
            tried[key] = hypothesis(problem, fit(problem, rest, leading.fit.coordinates, until="fine"))
        _grow(problem, [tried[key]], tried, first=False)


def _tighten(problem: Problem, tried: dict[EffectsKey, Hypothesis]) -> None:
    """Fit the leading set, and all that could take its place or tell the same, until their figures are settled."""
    base = tried[frozenset()]
    done = {base.key}
    while True:
        leading = _leading(problem, base, list(tried.values()))
        close = {h.key for h in tried.values() if h.ids and h.paid > leading.paid - EFFECT_NATS}
        waiting = ({leading.key} | close) - done
        if not waiting:
            return
        for key in sorted(waiting, key=sorted):
            rough = tried[key].fit
            tried[key] = hypothesis(problem, fit(problem, rough.effects, rough.coordinates, steps=0))
        done |= waiting


def _worth_growing(problem: Problem, frontier: Sequence[Hypothesis], grown: Hypothesis) -> bool:
    """Return whether one more effect earned enough for another to be tried; coloured noise counts for less.

    From the third effect on, sets could draw anything: each must take a good part of what is left.
    """
    if len(grown.ids) > 2 and grown.fit.rmse > (1.0 - GROWS_BY) * min(parent.fit.rmse for parent in frontier):
        return False
    gain = min(plain_error(problem, parent.fit) for parent in frontier) - plain_error(problem, grown.fit)
    if grown.fit.rmse < QUIET * problem.noise_floor:
        memory = grown.fit.evidence.memory
        gain *= (1.0 - memory) / (1.0 + memory)
    return gain >= WORTH_GROWING


def plain_error(problem: Problem, fitted: Fit) -> float:
    """Return half the white log variance times the number of samples, and its parameters' price: smaller is better."""
    error = sum(residual.size * np.log(max(rms(residual), 1e-300)) for residual in fitted.residuals)
    return _coarse(float(error)) + int(problem.space(fitted.effects).pays.sum())


def _coarse(nats: float) -> float:
    """Return nats to the digits in which processors agree, so that equals keep the order in which they are listed."""
    return round(nats, _DIGITS)


def _by_plain_error(problem: Problem, hypotheses: Iterable[Hypothesis]) -> list[Hypothesis]:
    return sorted(hypotheses, key=lambda h: plain_error(problem, h.fit))


@dataclass(frozen=True, slots=True)
class Promising:
    """A candidate with the starts from which a first step would take most away, moved to where it would take them."""

    candidate: Contender
    starts: tuple[Effect, ...]
    gain: float


def screen(problem: Problem, parent: Fit, candidates: Sequence[Contender]) -> list[Promising]:
    """Return candidates best first, by how much a first step of one of their starts would take away, nats.

    All starts are predicted in one batch. A step may be any multiple of a start; the parameters that are there already
    follow to first order, held by their priors.
    """
    weights = np.concatenate(
        [
            np.full(channel.rows.stop - channel.rows.start, max(evidence.level, channel.level, 1e-15))
            for channel, evidence in zip(problem.channels, parent.evidences, strict=True)
        ]
    )
    residual = parent.stacked / weights
    nuisance = parent.jacobian / weights[:, np.newaxis]
    spread = problem.space(parent.effects).spread
    covariance = inverse(nuisance.T @ nuisance + np.diag(1.0 / spread**2))
    starts = [start for candidate in candidates for start in candidate.starts]
    sets = [problem.ordered((*parent.effects, start)) for start in starts]
    moved = iter(problem.residuals([(parent.coordinates, effects) for effects in sets]) if sets else [])
    found = []
    for candidate in candidates:
        steps: list[tuple[float, Effect]] = []
        for start in candidate.starts:
            change = next(moved) / weights - residual
            change -= nuisance @ (covariance @ (nuisance.T @ change))
            size = float(change @ change)
            if size < _UNSEEN * max(1.0, float(residual @ residual)):
                continue
            amount = -float(change @ residual) / size
            helps = amount > 0.0 or problem.two_sided(start)
            gain = 0.5 * amount**2 * size if helps else 0.0
            steps.append((_coarse(gain), problem.scaled(start, amount if helps else abs(amount))))
        steps.sort(key=lambda pair: -pair[0])
        kept = [
            effect for gain, effect in steps[: problem.effort.starts] if gain >= problem.effort.second * steps[0][0]
        ]
        if kept and steps[0][0] >= problem.effort.least_gain:
            found.append(Promising(candidate, tuple(kept), steps[0][0]))
    found.sort(key=lambda one: -_coarse(one.gain))
    least = problem.effort.least_share * found[0].gain if found else 0.0
    return [one for one in found if one.gain >= least or one.candidate.expected]
