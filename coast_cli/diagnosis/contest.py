"""The contest: parameter errors, sensor artefacts and physics compete to explain what the base model leaves over.

Each hypothesis is a set of effects, fitted together with the base parameters. Its score is its likelihood as noise of
unknown level and colour, less the Occam factor of its parameters (Laplace's approximation of the evidence: MacKay,
Neural Computation 4 (1992) 415). Sets grow one effect at a time, only while an effect earns its place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.problem import Problem
from coast_cli.effects.catalogue import CATALOGUE, in_order
from coast_cli.effects.effect import Effect, Need, Parameter, Scale
from coast_cli.mechanics.section import FloatArray

# Nats by which an effect must beat the set without it. Calibrated on simulated recordings, see examples/concealed.
THRESHOLD = 7.0
# Smallest effect that is named, in noise levels: below it lies the misfit that every record has.
SMALLEST = 0.35
# Hypotheses this many nats behind the leading one still count as telling the same.
ALIKE = 4.0
_FITTED_SINGLES = 9
_FITTED_NEXT = 5
_FINISHED_SINGLES = 5
_FINISHED_NEXT = 4
_RACE_STEPS = 5
_STARTS = 2
_SECOND_START = 0.6
_GROWN_FROM = 2
_WORTH_GROWING = 4.0
# Up to this many noise levels a smooth gain may be the colour of the noise.
_QUIET = 1.9
_FLOOR = 1.12
# A gain of which one sample makes more than this share is that sample's alone.
_MOST_OF_GAIN = 0.85


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A fitted set of effects and its score in nats; the base model's own score is that of the empty set."""

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
        """Return other sets that the data cannot tell from the leading one; none of them merely adds to it."""
        leading = set(self.leading.ids)
        return tuple(
            other
            for other in self.tried
            if other.ids != self.leading.ids
            and not leading < set(other.ids)
            and other.score > self.leading.score - ALIKE
        )

    def parts(self) -> tuple[Hypothesis, ...]:
        """Return sets inside the leading one that earn their place over the base model too, best first."""
        leading, base = set(self.leading.ids), self.base.score
        return tuple(
            h for h in self.tried if set(h.ids) < leading and h.ids and h.score - base > THRESHOLD * len(h.ids)
        )


def run_contest(problem: Problem, most_effects: int = 5) -> Contest:
    """Fit and compare all sets worth comparing, up to ``most_effects`` effects.

    Sets grow by how much of the plain error they remove, because to coloured noise a half-explained misfit looks no
    likelier than a whole one; which of them leads is then judged by evidence, each effect paying ``THRESHOLD``.
    """
    scales = problem.scales()
    base = _hypothesis(problem, fit(problem), scales)
    candidates, by_rows = applicable(problem), applicable_by_rows(problem)
    most_effects = min(most_effects, _carries(problem))
    tried: dict[frozenset[str], Hypothesis] = {frozenset(): base}
    frontier = [base]
    for size in range(1, most_effects + 1):
        alone = [*candidates, *by_rows] if size == 1 else candidates
        rough = _race(problem, frontier, alone, scales, _FITTED_SINGLES if size == 1 else _FITTED_NEXT)
        grown = []
        for started in rough[: _FINISHED_SINGLES if size == 1 else _FINISHED_NEXT]:
            finished = _hypothesis(problem, fit(problem, started.effects, started.coordinates), scales)
            tried[frozenset(finished.ids)] = finished
            if not any(type(effect) in by_rows for effect in finished.fit.effects):
                grown.append(finished)
        if not grown:
            break
        grown.sort(key=lambda hypothesis: _plain_error(problem, hypothesis.fit))
        smaller = min(frontier, key=lambda parent: _plain_error(problem, parent.fit))
        gain = _plain_error(problem, smaller.fit) - _plain_error(problem, grown[0].fit)
        memory = grown[0].fit.evidence.memory
        quiet = grown[0].fit.rmse < _QUIET * problem.floor
        worth = gain * (1.0 - memory) / (1.0 + memory) if quiet else gain
        if worth < _WORTH_GROWING or _at_floor(problem, grown[0]):
            break
        frontier = grown[:_GROWN_FROM]
    leading = _lead(problem, tried)
    ranked = sorted(tried.values(), key=lambda hypothesis: -hypothesis.score)
    return Contest(base, tuple(ranked), leading)


def _carries(problem: Problem) -> int:
    """Return how many effects the recording can carry: one curve can be drawn by any three knees, many notches cannot."""
    if problem.runs[0].kind == "notch":
        return 5
    return 2 if problem.tension_noise is None else 3


def _race(
    problem: Problem,
    frontier: Sequence[Hypothesis],
    candidates: Sequence[type[Effect]],
    scales: dict[Scale, float],
    most: int,
) -> list[Fit]:
    """Return the sets one effect larger than those of the frontier after a few steps each, best first."""
    started: dict[frozenset[str], Fit] = {}
    for parent in frontier:
        starts = screen(problem, parent.fit, [c for c in candidates if c.id not in parent.ids], scales)
        wanted = list(dict.fromkeys(effect.id for effect in starts))[:most]
        for effect in starts:
            key = frozenset((*parent.ids, effect.id))
            if effect.id not in wanted or (key in started and parent is not frontier[0]):
                continue
            effects = in_order((*parent.fit.effects, effect))
            begun = fit(problem, effects, parent.fit.coordinates, steps=_RACE_STEPS, polish=False)
            if key not in started or begun.rmse < started[key].rmse:
                started[key] = begun
    return sorted(started.values(), key=lambda fitted: _plain_error(problem, fitted))


def _plain_error(problem: Problem, fitted: Fit) -> float:
    """Return half the white log variance times the number of samples, and its parameters' price: smaller is better."""
    count = problem.observed.size
    error = 0.5 * count * np.log(max(fitted.rmse, 1e-300) ** 2)
    if problem.tension_noise is not None and fitted.tension_residual.size:
        witness = float(np.mean(fitted.tension_residual**2))
        error += 0.5 * fitted.tension_residual.size * np.log(max(witness, 1e-300))
    return float(error + 1.0 * fitted.parameter_count)


def _at_floor(problem: Problem, hypothesis: Hypothesis) -> bool:
    """Return whether what is left is no more than the noise that the recording itself shows."""
    return hypothesis.fit.rmse < _FLOOR * problem.floor


def _lead(problem: Problem, tried: dict[frozenset[str], Hypothesis]) -> Hypothesis:
    """Return the set with the most evidence after every effect has paid, and in which each is large enough to name."""
    order = sorted(tried.values(), key=lambda h: h.score - THRESHOLD * len(h.ids), reverse=True)
    for hypothesis in order:
        smaller = [
            tried[key] for key in tried if key < frozenset(hypothesis.ids) and len(key) == len(hypothesis.ids) - 1
        ]
        if all(size_of(problem, hypothesis, other) >= SMALLEST and _spread_out(hypothesis, other) for other in smaller):
            return hypothesis
    return tried[frozenset()]


def _spread_out(larger: Hypothesis, smaller: Hypothesis) -> bool:
    """Return whether what a larger set gains rests on more than one sample: an outlier is no effect."""
    before, after = smaller.fit, larger.fit
    gain = np.concatenate(
        [
            (before.residual**2 - after.residual**2) / max(after.evidence.level, 1e-15) ** 2,
            (before.tension_residual**2 - after.tension_residual**2) / max(after.tension_evidence.level, 1e-15) ** 2,
        ]
    )
    total = float(np.sum(gain))
    return total <= 0.0 or float(gain.max()) < _MOST_OF_GAIN * total


def size_of(problem: Problem, larger: Hypothesis, smaller: Hypothesis) -> float:
    """Return by how much two fits differ, as RMS in levels of the noise that the larger set leaves."""
    change = np.sqrt(np.mean((larger.fit.residual - smaller.fit.residual) ** 2)) / larger.fit.evidence.level
    if problem.tension_noise is None or larger.fit.tension_residual.size == 0:
        return float(change)
    witness = larger.fit.tension_residual - smaller.fit.tension_residual
    return float(max(change, np.sqrt(np.mean(witness**2)) / larger.fit.tension_evidence.level))


def applicable(problem: Problem) -> list[type[Effect]]:
    """Return the effects that could show in this recording at all."""
    return _showing(problem, problem.holds)


def applicable_by_rows(problem: Problem) -> list[type[Effect]]:
    """Return the effects that could show if samples counted time, where there is no clock.

    They compete alone: with a guessed clock, which in one sweep runs with the drive, a set of them draws anything.
    """
    if problem.holds["time"]:
        return []
    return [effect for effect in _showing(problem, {**problem.holds, "time": True}) if "time" in effect.needs]


def _showing(problem: Problem, holds: Mapping[Need, bool]) -> list[type[Effect]]:
    fixed = {effect.id for effect in problem.fixed_effects}
    return [e for e in CATALOGUE.values() if e.id not in fixed and all(holds.get(need, True) for need in e.needs)]


def screen(
    problem: Problem, parent: Fit, candidates: Iterable[type[Effect]], scales: dict[Scale, float]
) -> list[Effect]:
    """Return starts of each candidate, best first, by how much of the residual a first step could take away.

    Every start of every effect costs one prediction; base and effect parameters already there may move along (linear).
    """
    response, tension = problem.fitted(problem.predict(parent.coordinates, parent.effects))
    weights = (
        max(parent.evidence.level, problem.noise),
        max(parent.tension_evidence.level, problem.tension_noise or 1.0),
    )

    def stacked(parts: tuple[FloatArray, FloatArray]) -> FloatArray:
        return np.concatenate([parts[0] / weights[0], parts[1] / weights[1]])

    residual = stacked((problem.observed, problem.observed_tension)) - stacked((response, tension))
    nuisance = np.linalg.qr(_directions(problem, parent, stacked, stacked((response, tension))))[0]
    left = residual - nuisance @ (nuisance.T @ residual)
    found: list[tuple[float, Effect]] = []
    for candidate in candidates:
        best: list[tuple[float, Effect]] = []
        for start in starts_of(candidate, scales, problem.holds):
            effects = in_order((*parent.effects, start))
            moved = stacked(problem.fitted(problem.predict(parent.coordinates, effects)))
            change = moved - stacked((response, tension))
            change -= nuisance @ (nuisance.T @ change)
            size = float(change @ change)
            if size < 1e-12 * max(1.0, float(residual @ residual)):
                continue
            amount = float(change @ left) / size
            gain = float(change @ left) ** 2 / size if amount > 0.0 or _signed(candidate) else 0.0
            step = float(np.copysign(np.clip(abs(amount), 0.1, 4.0), amount if gain else 1.0))
            best.append((gain, _scaled(start, step)))
        best.sort(key=lambda pair: -pair[0])
        found.extend(pair for pair in best[:_STARTS] if pair[0] >= _SECOND_START * best[0][0])
    found.sort(key=lambda pair: -pair[0])
    return [effect for _, effect in found]


def starts_of(
    effect: type[Effect], scales: dict[Scale, float], holds: Mapping[Need, bool] | None = None
) -> list[Effect]:
    """Return the starts of an effect on a recording with these scales, which ``holds`` what parameters need or not."""
    choices = [
        [p.null]
        if p.needs is not None and holds is not None and not holds.get(p.needs, True)
        else [float(np.clip(start * scales[p.relative_to], p.low, p.high)) for start in p.starts]
        for p in effect.parameters
    ]
    names = [parameter.name for parameter in effect.parameters]
    return [effect(**dict(zip(names, chosen, strict=True))) for chosen in product(*choices)]


def _directions(
    problem: Problem,
    parent: Fit,
    stacked: Callable[[tuple[FloatArray, FloatArray]], FloatArray],
    origin: FloatArray,
) -> FloatArray:
    """Return how the prediction moves with each parameter that is already fitted, (n, q), one column a parameter."""
    columns = []
    for place in range(parent.coordinates.size):
        moved = parent.coordinates.copy()
        moved[place] += 1e-3
        columns.append(stacked(problem.fitted(problem.predict(moved, parent.effects))) - origin)
    for index, effect in enumerate(parent.effects):
        for parameter in effect.parameters:
            value = getattr(effect, parameter.name)
            step = 1e-3 * max(abs(value), (parameter.high - parameter.low) * 1e-3)
            if value + step > parameter.high:
                step = -step
            changed = replace(effect, **{parameter.name: value + step})
            effects = (*parent.effects[:index], changed, *parent.effects[index + 1 :])
            columns.append(stacked(problem.fitted(problem.predict(parent.coordinates, effects))) - origin)
    scaled = [column / norm for column in columns if (norm := float(np.linalg.norm(column))) > 0.0]
    return np.stack(scaled, axis=1) if scaled else np.zeros((origin.size, 1))


def _scaled(effect: Effect, amount: float) -> Effect:
    """Move the sizes of an effect by the linear estimate, inside their ranges."""
    changes = {}
    for parameter in effect.parameters:
        if parameter.role == "size":
            wanted = parameter.null + (getattr(effect, parameter.name) - parameter.null) * amount
            margin = 1e-6 * (parameter.high - parameter.low)
            changes[parameter.name] = float(np.clip(wanted, parameter.low + margin, parameter.high - margin))
    return replace(effect, **changes)


def _signed(effect: type[Effect]) -> bool:
    """Return whether every size may take either sign."""
    return all(parameter.low < parameter.null for parameter in effect.parameters if parameter.role == "size")


def _hypothesis(problem: Problem, fitted: Fit, scales: dict[Scale, float]) -> Hypothesis:
    unlikely = sum(effect.unlikely for effect in fitted.effects)
    return Hypothesis(fitted, fitted.log_likelihood - _occam(problem, fitted, scales) - unlikely)


def _occam(problem: Problem, fitted: Fit, scales: dict[Scale, float]) -> float:
    """Return the log of prior over posterior width of the effect parameters, in nats; useless ones cost nothing."""
    size = len(problem.base)
    widths = np.array([_prior_width(p, scales) for effect in fitted.effects for p in effect.parameters])
    if widths.size == 0:
        return 0.0
    precision = np.linalg.pinv(fitted.covariance[size:, size:], hermitian=True)
    # By eigenvalues: where one parameter is known ever so much better than another, a determinant loses the lesser one.
    sharper = np.linalg.eigvalsh(precision * np.outer(widths, widths))
    return 0.5 * float(np.sum(np.log1p(np.maximum(sharper, 0.0))))


def _prior_width(parameter: Parameter, scales: dict[Scale, float]) -> float:
    scale = scales[parameter.relative_to]
    reach = [abs(start * scale - (parameter.null if not parameter.relative_to else 0.0)) for start in parameter.starts]
    return 2.0 * max(*reach, 1e-9) if len(reach) > 1 else 2.0 * max(reach[0], 1e-9)
