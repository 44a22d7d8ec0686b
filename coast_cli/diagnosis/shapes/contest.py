"""The contest: left-out effects compete to explain what base parameters leave over.

As for joints (``diagnosis.contest``): sets are fitted with the base parameters, scored as noise of unknown level and colour
less the Occam factor of their parameters, and grow one effect at a time. A screen costs one batch of beams: every start
of every effect at once, each scaled to where its first step would take it, base parameters free to follow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.diagnosis.shapes.fit import Fit, Space, fit
from coast_cli.diagnosis.shapes.forward import Job
from coast_cli.diagnosis.shapes.problem import Problem
from coast_cli.diagnosis.thresholds import EFFECT_NATS as THRESHOLD
from coast_cli.diagnosis.thresholds import SMALLEST
from coast_cli.effects.shapes.catalogue import SHAPE_CATALOGUE, in_order
from coast_cli.effects.shapes.effect import ShapeEffect
from coast_cli.mechanics.section import FloatArray

# Hypotheses this many nats behind the leading one still count as telling the same.
ALIKE = 3.0
# ... and so many behind it, and so many of them, are decided again on what was held out.
_CLOSE = 12.0
_MOST_CLOSE = 6
Key = frozenset[tuple[str, float]]
_FITTED_SINGLES = 9
_FITTED_NEXT = 4
_GROWN_FROM = 2
_FINISHED = 2
_FAR_BEHIND = 25.0  # nats of plain error
_WORTH_GROWING = 4.0
_WORTH_FITTING = 1.0
# An effect that is named changes the fit by at least this share of what the base model leaves.
_LEAST_PART = 0.1
_EXPLAINED = 0.07  # of the base model's error: what is left is then small whatever the noise
_RIVAL_SHARE = 0.2  # of the best effect's gain, under which an effect is not fitted


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A fitted set of effects and its score in nats."""

    fit: Fit
    score: float

    @property
    def ids(self) -> tuple[str, ...]:
        """Effect ids in the order in which they act."""
        return self.fit.ids


@dataclass(frozen=True, slots=True)
class Contest:
    """Everything that was fitted, best first; ``base`` is the model with refitted parameters alone."""

    base: Hypothesis
    tried: tuple[Hypothesis, ...]
    leading: Hypothesis

    def alternatives(self) -> tuple[Hypothesis, ...]:
        """Return other sets, no larger, that the shapes cannot tell from the leading one; best of each set of ids."""
        if not self.leading.ids:
            return ()
        found: dict[frozenset[str], Hypothesis] = {frozenset(self.leading.ids): self.leading}
        for other in self.tried:
            ids = frozenset(other.ids)
            if 0 < len(ids) <= len(self.leading.ids) and ids not in found and other.score > self.leading.score - ALIKE:
                found[ids] = other
        return tuple(found.values())[1:]


def run_contest(problem: Problem, level: float, most_effects: int = 5) -> Contest:
    """Fit and compare all sets worth comparing, up to ``most_effects`` effects; ``level`` is the noise, m.

    Sets grow by plain error. Then every effect of a leading set of several is exchanged for its rivals, because what was
    taken first, alone, may have stood for two.
    """
    base = _hypothesis(problem, fit(problem, level=level))
    tried: dict[Key, Hypothesis] = {frozenset(): base}
    frontier = [base]
    for size in range(1, most_effects + 1):
        most = _FITTED_SINGLES if size == 1 else _FITTED_NEXT
        grown = [child for parent in frontier for child in _grow(problem, parent, level, tried, most)]
        if not grown:
            break
        grown.sort(key=lambda hypothesis: _plain_error(problem, hypothesis))
        smaller = min(_plain_error(problem, parent) for parent in frontier)
        if _plain_error(problem, grown[0]) > smaller - _WORTH_GROWING:
            break
        frontier = grown[:_GROWN_FROM]
        if grown[0].fit.rmse < max(1.12 * level, _EXPLAINED * base.fit.rmse):
            break
    leading = _lead(problem, tried)
    for effect in leading.fit.effects if len(leading.ids) > 1 else ():
        rest = tuple(other for other in leading.fit.effects if other is not effect)
        key = leading.fit.key - {effect.variant}
        if key not in tried:
            tried[key] = _hypothesis(problem, fit(problem, rest, leading.fit.coordinates, level=level, steps=8))
        _grow(problem, tried[key], level, tried, _FITTED_NEXT)
    ranked = sorted(tried.values(), key=lambda hypothesis: -hypothesis.score)
    return Contest(base, tuple(ranked), _lead(problem, tried))


def settle(contest: Contest, problem: Problem, whole: Problem, level: float) -> Contest:
    """Return the contest with its close ends decided on every point, those held out among them.

    Only the choice between sets that score alike is made so, by scores of fits to ``whole``: each keeps its own fit.
    """
    leading = contest.leading
    if not leading.ids:
        return contest
    close = [other for other in contest.tried if _paid(other) > _paid(leading) - _CLOSE][:_MOST_CLOSE]
    if len(close) < 2:
        return contest
    scores = {}
    for one in close:
        start, rough = _carried(problem, one.fit, whole), max(level, 0.3 * one.fit.rmse)
        refitted = fit(whole, one.fit.effects, start, level=rough, steps=6)
        scores[one.fit.key] = _hypothesis(whole, refitted).score
    ahead = scores[leading.fit.key] - leading.score
    decided = {one.fit.key: one for one in contest.tried}
    decided |= {one.fit.key: replace(one, score=scores[one.fit.key] - ahead) for one in close}
    ranked = sorted(decided.values(), key=lambda hypothesis: -hypothesis.score)
    return Contest(contest.base, tuple(ranked), _lead(problem, decided))


def _carried(problem: Problem, fitted: Fit, whole: Problem) -> FloatArray:
    known = {p.key: float(c) for p, c in zip(problem.base, fitted.coordinates, strict=True)}
    start = zip(whole.base, whole.configured().tolist(), strict=True)
    return np.array([known.get(parameter.key, configured) for parameter, configured in start])


def _paid(hypothesis: Hypothesis) -> float:
    """Return the score once every effect has paid."""
    return hypothesis.score - THRESHOLD * len(hypothesis.ids)


def _grow(
    problem: Problem, parent: Hypothesis, level: float, tried: dict[Key, Hypothesis], most: int
) -> list[Hypothesis]:
    """Fit the set with each of the most promising effects added, put them into ``tried`` and return the new ones.

    All start the race; those that a few steps leave far behind are not finished.
    """
    loose = max(level, 0.3 * parent.fit.rmse)
    started = []
    promising = screen(problem, parent.fit, level)
    # What theory says is there is tried beside the most promising: a large step says little to first order.
    for effect in (*promising[:most], *(one for one in promising[most:] if one.rarity < 0.0 and parent.ids)):
        if parent.fit.key | {effect.variant} not in tried:
            effects = in_order((*parent.fit.effects, effect))
            started.append(fit(problem, effects, parent.fit.coordinates, level=loose, steps=4, polish=False))
    if not started:
        return []
    behind = problem.size * np.log(np.array([max(one.rmse, 1e-300) for one in started]))
    order = np.argsort(behind)
    grown = []
    for place in order:
        if place in order[:_FINISHED] or behind[place] < behind[order[0]] + _FAR_BEHIND:
            one = started[place]
            finished = fit(
                problem, one.effects, one.coordinates, level=min(loose, max(one.evidence.level, level)), steps=6
            )
            tried[finished.key] = _hypothesis(problem, finished)
            grown.append(tried[finished.key])
    return grown


def _plain_error(problem: Problem, hypothesis: Hypothesis) -> float:
    """Return the residual as white noise, in nats, and its parameters' price: smaller is better."""
    own = len(problem.base) - problem.free
    parameters = sum(len(effect.fitted()) + own * getattr(effect, "by_tube", 0.0) for effect in hypothesis.fit.effects)
    return float(problem.size * np.log(max(hypothesis.fit.rmse, 1e-300)) + parameters)


def _lead(problem: Problem, tried: dict[Key, Hypothesis]) -> Hypothesis:
    """Return the set with the most evidence once every effect has paid, in which each is large enough to name."""
    order = sorted(tried.values(), key=_paid, reverse=True)
    for hypothesis in order:
        key = hypothesis.fit.key
        smaller = [other for other_key, other in tried.items() if other_key < key and len(other_key) == len(key) - 1]
        least = max(SMALLEST * hypothesis.fit.evidence.level, _LEAST_PART * tried[frozenset()].fit.rmse)
        if all(change_of(problem, hypothesis, other) >= least for other in smaller):
            return hypothesis
    return tried[frozenset()]


def change_of(problem: Problem, one: Hypothesis, other: Hypothesis) -> float:
    """Return by how much two fits differ, m RMS: of all residuals, or of those along the line, which are few."""
    change = (one.fit.residual - other.fit.residual) ** 2
    along = float(np.mean(change[problem.along])) if problem.along.any() else 0.0
    return float(np.sqrt(max(float(np.mean(change)), along)))


def screen(problem: Problem, parent: Fit, level: float) -> list[ShapeEffect]:
    """Return the best start of each effect, best first, by how much its first step would take away.

    The step may be any multiple of the start, other parameters follow to first order, and the start is moved with it.
    """
    scale = max(level, parent.evidence.level, 1e-12)
    taken = {effect.id for effect in parent.effects} | problem.carried
    starts = [
        start
        for effect in SHAPE_CATALOGUE.values()
        if effect.id not in taken and (problem.scene.pairs or not effect.on_pairs)
        for start in effect.starts(problem.scene)
    ]
    jobs: list[Job] = []
    spans = []
    for start in starts:
        touched = problem.touched(start)
        state = problem.state(parent.coordinates, in_order((*parent.effects, start)))
        spans.append((len(jobs), touched))
        jobs += [(index, state) for index in touched]
    moved = problem.residuals(jobs)
    space = Space(problem, parent.effects)
    nuisance = parent.jacobian / scale
    precision = nuisance.T @ nuisance + np.diag(1.0 / space.width**2)
    residual = parent.residual / scale
    best: dict[tuple[str, float], tuple[float, ShapeEffect]] = {}
    for start, (first, touched) in zip(starts, spans, strict=True):
        change = np.zeros_like(residual)
        for offset, index in enumerate(touched):
            rows = problem.slices[index]
            change[rows] = moved[first + offset] / scale - residual[rows]
        follow = np.linalg.solve(precision, nuisance.T @ change)
        left = change - nuisance @ follow
        size = float(left @ left)
        if not size > 1e-3:
            continue
        amount = -float(left @ residual) / size
        if start.one_sided() and amount <= 0.0:
            continue
        gain = amount**2 * size / 2.0
        kind = start.id, getattr(start, "by_tube", 0.0)
        if gain > _WORTH_FITTING and (kind not in best or gain > best[kind][0]):
            best[kind] = gain, start.scaled(amount)
    ranked = sorted(best.values(), key=lambda pair: -pair[0])
    return [effect for gain, effect in ranked if gain > _RIVAL_SHARE * ranked[0][0] or effect.rarity < 0.0]


def _hypothesis(problem: Problem, fitted: Fit) -> Hypothesis:
    """Return the fit with its score: likelihood less the log of prior over posterior width, and of tubes to choose from.

    Base parameters that only these effects set free pay as the effects' own do.
    """
    widths = Space(problem, fitted.effects).width
    paying = np.arange(problem.free, widths.size)
    occam = 0.0
    if fitted.effects:
        covariance = (fitted.covariance / np.outer(widths, widths))[np.ix_(paying, paying)]
        occam = max(-0.5 * float(np.linalg.slogdet(covariance)[1]), 0.0)
    chosen = sum(1 for effect in fitted.effects if getattr(effect, "tube", 0.0))
    occam += chosen * float(np.log(max(len(problem.scene.tubes), 1)))
    occam += sum(effect.rarity for effect in fitted.effects)
    # That tubes differ from what an effect has for all is one more thing to be believed.
    occam += THRESHOLD * sum(getattr(effect, "by_tube", 0.0) for effect in fitted.effects)
    return Hypothesis(fitted, fitted.log_likelihood - occam)
