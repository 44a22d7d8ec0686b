"""From a contest to a verdict: named rules, one after the other, each a small function that is tested by itself.

A rule looks at a case and answers with a changed case (another leading set, and the rules begin again), with a ruling (the
verdict), or with nothing. A kind of recording lists its rules in the order in which they ask; rules that only joints or
only shapes need stand with those.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

import numpy as np

from coast_cli.diagnosis.answer import Diagnosis, Errors, Level, Named, SideBySide, Test, Value, Verdict
from coast_cli.diagnosis.contest import Contest, Hypothesis, carried_start
from coast_cli.diagnosis.curves import JointCurve, ShapeCurve
from coast_cli.diagnosis.fit import Fit, fit, rms
from coast_cli.diagnosis.holdout import HoldOut
from coast_cli.diagnosis.locate import Region
from coast_cli.diagnosis.space import Booleans
from coast_cli.diagnosis.spread import Spread
from coast_cli.diagnosis.thresholds import (
    LEAST_SURE,
    LEFT_TO_SAY,
    MAX_UNEXPLAINED_NOISE,
    MAX_UNEXPLAINED_SHARE,
    PARAMETERS_NATS,
    PARAMETERS_SIZE,
    REFUSED_NAMES,
    SUREST,
    TEMPER,
    UNEXPLAINED_SOFTNESS,
)
from coast_cli.effects.effect import Effect, declared
from coast_cli.mechanics.section import FloatArray

if TYPE_CHECKING:
    from coast_cli.diagnosis.unnamed.words import Description

SOMETHING_ELSE = "something_else"
_MOST_CHANGES = 100  # every change makes the leading set smaller, so that this is never reached


@dataclass(frozen=True, slots=True)
class Ruling:
    """A verdict and a sentence on it; ``keeps_model``: whether the leading set is the model though it is not named."""

    verdict: Verdict
    reason: str
    keeps_model: bool = False


@dataclass(frozen=True, slots=True)
class Leftover:
    """What is neither model nor noise: RMS, SI; and in words."""

    size: float
    words: str


@dataclass(frozen=True)
class Case(ABC):
    """A contest to be judged, and what its kind of recording knows of itself.

    Attributes:
        problem: that was fitted. kept_back: rows that no fit saw. contest: of what may explain it.
        attempts: ids of a set that was dropped because it did not hold. remark: on that, for the reason.
    """

    problem: Any
    kept_back: HoldOut
    contest: Contest
    attempts: tuple[str, ...] = ()
    remark: str = ""

    unit: ClassVar[str]
    agrees: ClassVar[str]
    alike: ClassVar[str]

    @abstractmethod
    def errors(self, coordinates: FloatArray, effects: Sequence[Any], rows: Sequence[Booleans]) -> Errors:
        """Return the errors of a model on some rows."""

    @abstractmethod
    def _leftover(self) -> Leftover:
        """Return what the leading set leaves."""

    @abstractmethod
    def noise_level(self, ruling: Ruling) -> float:
        """Return the noise that the recording shows, SI."""

    @abstractmethod
    def where(self, ruling: Ruling, final: Fit) -> tuple[Region, ...]:
        """Return the regions of the mismatch."""

    @abstractmethod
    def next_recording(self, ruling: Ruling) -> str:
        """Return what would settle what is open."""

    @abstractmethod
    def notes(self, ruling: Ruling, final: Fit) -> tuple[str, ...]:
        """Return what limits the answer."""

    @abstractmethod
    def curves(self, final: Fit) -> tuple[JointCurve, ...] | tuple[ShapeCurve, ...]:
        """Return what the refitted base and the corrected model predict of every run."""

    @abstractmethod
    def in_unit(self, value: float) -> float:
        """Return an SI response in the unit of the answer."""

    @property
    @abstractmethod
    def response_noise(self) -> float:
        """The noise beside which errors stand, in the unit of tables."""

    def in_widths(self, error: float | None) -> float:
        """Return what an error, in the unit of tables, is beyond the noise, in noise widths."""
        level = self.response_noise
        return float(np.sqrt(max((error or 0.0) ** 2 - level**2, 0.0)) / max(level, 1e-300))

    @property
    def explains_words(self) -> str:
        """How much is explained and how much is left on rows that were not fitted, in noise widths."""
        levels = self.comparison
        unseen = levels.refitted.held_out is not None
        before = self.in_widths(levels.refitted.held_out if unseen else levels.refitted.train)
        after = self.in_widths(levels.with_effects.held_out if unseen else levels.with_effects.train)
        explained = float(np.sqrt(max(before**2 - after**2, 0.0)))
        rows = "rows that were not fitted" if unseen else "the rows that were fitted, as none could be kept back"
        left = f"{after:.1f} are left" if after > LEFT_TO_SAY else "nothing beyond the noise is left"
        return f"explains {explained:.1f} of {before:.1f} noise widths on {rows}; {left}"

    @property
    def moved(self) -> str:
        """What is said where only base parameters have moved."""
        return "within the noise once the base parameters are refitted; no physics is missing"

    @property
    def floor(self) -> float:
        """The noise beside which what is left over is judged, SI."""
        return float(self.problem.noise_floor)

    @property
    def allowed_share(self) -> float:
        """Share of what was explained that may be left over."""
        return MAX_UNEXPLAINED_SHARE

    def model_tubes(self, final: Fit) -> dict[str, float | list[float]]:
        """Return what of the model is saved as numbers of its tubes."""
        return {}

    def model_spread(self, final: Fit) -> Spread | None:
        """Return how sure the numbers of the saved model are, where that is known."""
        return None

    def saved_effects(self, final: Fit) -> tuple[Effect, ...]:
        """Return what of the model is saved as corrections."""
        return final.effects

    def alternatives(self, ruling: Ruling) -> tuple[tuple[str, ...], ...]:
        """Return the ids of sets that the data cannot tell from the named one."""
        return tuple(rival.ids for rival in self.rivals) if self.is_named(ruling) else ()

    def tried_in_vain(self, ruling: Ruling) -> tuple[str, ...]:
        """Return the ids of the best set that was not good enough to be named."""
        return self.attempts or (self.leading.ids if ruling.verdict == "unexplained" else ())

    def chosen(self, effect: Effect) -> dict[str, Value]:
        """Return what was chosen for an effect and not fitted."""
        return {}

    @property
    def leading(self) -> Hypothesis:
        """The set that is judged."""
        return self.contest.leading

    @cached_property
    def described(self) -> Description | None:
        """What is known of a law without a name; None where there is none."""
        return None

    def told_law(self, final: Fit) -> Description | None:
        """Return all that is said of a law without a name as it is saved; None where there is none."""
        return self.described

    @cached_property
    def rivals(self) -> tuple[Hypothesis, ...]:
        """Sets that explain as much."""
        return self.contest.alternatives()

    @cached_property
    def leftover(self) -> Leftover:
        """What the leading set leaves."""
        return self._leftover()

    @cached_property
    def explained(self) -> float:
        """RMS that the leading set took from the base model's residual, SI."""
        return float(np.sqrt(max(self.contest.base.fit.rmse**2 - self.leading.fit.rmse**2, 0.0)))

    def led_by(self, leading: Hypothesis) -> Self:
        """Return the same with another leading set."""
        return replace(self, contest=replace(self.contest, leading=leading))

    def is_named(self, ruling: Ruling) -> bool:
        """Return whether the leading set is named."""
        return bool(self.leading.ids) and ruling.verdict != "unexplained"

    @cached_property
    def by_importance(self) -> tuple[str, ...]:
        """The leading ids, the one whose loss would cost most first."""
        leading = self.leading
        if len(leading.ids) < 2:
            return leading.ids
        tried = {hypothesis.key: hypothesis.fit.rmse for hypothesis in self.contest.tried}
        cost = {}
        for effect in leading.fit.effects:
            rest = tuple(other for other in leading.fit.effects if other is not effect)
            key = leading.key - {self.problem.variant(effect)}
            if key not in tried:
                tried[key] = fit(self.problem, rest, leading.fit.coordinates, steps=6, until="fine").rmse
            cost[effect.id] = tried[key]
        return tuple(sorted(leading.ids, key=lambda identifier: -cost[identifier]))

    def first_effect(self) -> Effect:
        """Return the most important effect of the leading set."""
        return next(effect for effect in self.leading.fit.effects if effect.id == self.by_importance[0])

    @cached_property
    def parameters_moved(self) -> bool:
        """Whether refitted base parameters say something that configured ones do not."""
        problem, base = self.problem, self.contest.base.fit
        before = problem.residuals([(problem.configured(), ())])[0]
        likelihood = sum(c.bank.evidence(before[c.rows]).log_likelihood for c in problem.channels)
        free = len(problem.values(problem.configured()))
        gain = base.log_likelihood - likelihood - 0.5 * free * np.log(base.residual.size)
        size = rms(before[problem.channels[0].rows] - base.residual) / base.evidence.level
        return bool(gain > PARAMETERS_NATS and size > PARAMETERS_SIZE)

    def final(self, fitted: Fit) -> Fit:
        """Return the fit on every row, unless the user named runs that no fit may see."""
        if not self.kept_back.chosen or not self.kept_back.any:
            return fitted
        whole = self.problem.only([np.ones(len(rows), bool) for rows in self.kept_back.rows])
        return fit(whole, fitted.effects, carried_start(problem=self.problem, fitted=fitted, whole=whole), steps=6)

    def comparison_of(self, fitted: Fit) -> SideBySide:
        """Return errors as configured, refitted, and with a fit's effects, side by side."""
        return self.side_by_side(self.problem, self.contest.base.fit, fitted)

    def side_by_side(self, known: Any, refitted: Fit, fitted: Fit) -> SideBySide:  # noqa: ANN401
        """Return the errors of three models on the rows that ``known`` fits, and on those kept back."""
        levels = []
        for one in (None, refitted, fitted):
            coordinates = self.problem.configured() if one is None else one.coordinates
            effects = () if one is None else one.effects
            train = self.errors(coordinates, effects, known.train)
            out = self.errors(coordinates, effects, self.kept_back.rows) if self.kept_back.any else None
            levels.append((Level(train.response, None if out is None else out.response), (out or train).tip_mm))
        return SideBySide(
            unit=self.unit,
            held_out_runs=self.kept_back.runs,
            rule=self.kept_back.rule,
            configured=levels[0][0],
            refitted=levels[1][0],
            with_effects=levels[2][0],
            tip_mm_refitted=levels[1][1],
            tip_mm_with_effects=levels[2][1],
        )

    @cached_property
    def comparison(self) -> SideBySide:
        """Errors of the leading set beside those without it."""
        return self.comparison_of(self.leading.fit)

    @cached_property
    def certainty(self) -> float:
        """Probability that the leading set or one of its rivals is right, and not something unknown."""
        left = self.leftover.size / max(self.explained, 1e-300)
        return float(1.0 / (1.0 + np.exp(np.clip((left - MAX_UNEXPLAINED_SHARE) / UNEXPLAINED_SOFTNESS, -50.0, 50.0))))

    @cached_property
    def shares(self) -> FloatArray:
        """Shares of the leading set and of its rivals in what is believed of them together, (1 + rivals,)."""
        scores = np.array([self.leading.score, *(rival.score for rival in self.rivals)])
        weights = np.exp((scores - scores.max()) / TEMPER)
        return np.asarray(weights / weights.sum())

    def believed(self, ruling: Ruling) -> float:
        """Return the probability that the leading set, or one of its rivals, is right under a ruling."""
        return self.certainty if self.is_named(ruling) else min(self.certainty, float(REFUSED_NAMES))

    def probabilities(self, ruling: Ruling) -> dict[str, float]:
        """Return the probability of each name, likeliest first, and of ``something_else``: that none of them is right."""
        if not self.leading.ids:
            return {}
        shares = self.shares * min(self.believed(ruling), float(SUREST))
        found: dict[str, float] = {}
        for one, share in zip((self.leading, *self.rivals), shares, strict=True):
            for identifier in one.ids:
                found[identifier] = found.get(identifier, 0.0) + float(share)
        ordered = dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))
        return ordered | {SOMETHING_ELSE: 1.0 - float(shares.sum())}

    @property
    def evidence(self) -> dict[str, float]:
        """What speaks against the leading names, by figure, where that is asked."""
        return {}

    @property
    def tests(self) -> tuple[Test, ...]:
        """What the answer rests on."""
        return ()

    def named(self, ruling: Ruling, final: Fit) -> tuple[Named, ...]:
        """Return the leading effects with their fitted numbers, the most important first."""
        chances = self.probabilities(ruling)
        space, names = self.problem.space(final.effects), {}
        place = len(space.base)
        for effect, owned in zip(final.effects, space.owned, strict=True):
            values = {}
            numbers, said = effect.numbers(), declared(effect, self.problem.recording)
            for coordinate in owned:
                value = float(numbers[coordinate.name])
                std = float(np.sqrt(final.covariance[place, place])) * (value if coordinate.logarithmic else 1.0)
                values[coordinate.name] = Value(value, std, final.at_bound[place])
                place += 1
            values |= self.chosen(effect)
            chance = max(chances.get(effect.id, 0.0), float(LEAST_SURE))
            names[effect.id] = Named(
                effect.id, effect.kind, effect.component, said.title, said.equation, chance, values
            )
        return tuple(names[identifier] for identifier in self.by_importance)

    def base_values(self, final: Fit) -> dict[str, Value]:
        """Return the base parameters as fitted."""
        values, found = self.problem.values(final.coordinates), {}
        for place, parameter in enumerate(self.problem.base):
            if parameter.name in values:
                value = values[parameter.name]
                std = float(np.sqrt(final.covariance[place, place])) * (value if parameter.logarithmic else 1.0)
                found[parameter.name] = Value(value, std, final.at_bound[place])
        return found

    def diagnosis(self, ruling: Ruling) -> Diagnosis:
        """Return the whole answer under a ruling."""
        explains = ruling.verdict != "unexplained" or ruling.keeps_model
        final = self.final(self.leading.fit if explains else self.contest.base.fit)
        configured = {p.name: p.value for p in self.problem.base}
        parameters = self.base_values(final)
        return Diagnosis(
            verdict=ruling.verdict,
            reason=f"{ruling.reason}; {self.remark}" if self.remark else ruling.reason,
            noise=self.in_unit(self.noise_level(ruling)),
            noise_unit=self.unit,
            where=() if ruling.verdict == "agrees" else self.where(ruling, final),
            effects=self.named(ruling, final) if self.is_named(ruling) else (),
            alternatives=self.alternatives(ruling),
            attempts=self.tried_in_vain(ruling),
            parameters=parameters,
            configured={name: configured[name] for name in parameters},
            comparison=self.comparison,
            next_recording=self.next_recording(ruling),
            notes=self.notes(ruling, final),
            model_effects=self.saved_effects(final),
            model_parameters=self.problem.values(final.coordinates),
            model_tubes=self.model_tubes(final),
            model_spread=self.model_spread(final),
            curves=self.curves(final),
            unnamed=self.told_law(final),
            recording=self.problem.recording,
            probabilities=self.probabilities(ruling),
            tests=self.tests,
            evidence=self.evidence,
        )


VerdictRule = Callable[[Any], Case | Ruling | None]
AnyCase = TypeVar("AnyCase", bound=Case)


def judge(case: AnyCase, rules: Sequence[VerdictRule]) -> tuple[AnyCase, Ruling]:
    """Return the case as the rules leave it, and the ruling of the first that gives one; the last one always does."""
    for _ in range(_MOST_CHANGES):
        for rule in rules:
            outcome = rule(case)
            if isinstance(outcome, Ruling):
                return case, outcome
            if isinstance(outcome, type(case)):
                case = outcome
                break
    raise ValueError("the rules came to no verdict")


def structure_is_left(case: Case) -> Ruling | None:
    """Rule: too much is left over, beside the noise and beside what was explained."""
    noise = min(case.floor, case.leading.fit.rmse)
    left = case.leftover.size
    if left > MAX_UNEXPLAINED_NOISE * noise and left > case.allowed_share * case.explained:
        return Ruling("unexplained", case.leftover.words)
    return None


def nothing_is_named(case: Case) -> Ruling | None:
    """Rule: no effect leads; base parameters have moved, or the model agrees."""
    if case.leading.ids:
        return None
    if case.parameters_moved:
        return Ruling("parameters", case.moved)
    return Ruling("agrees", case.agrees)


def first_effect_is_disputed(case: Case) -> Ruling | None:
    """Rule: a rival explains as much without the most important effect."""
    if any(case.by_importance[0] not in rival.ids for rival in case.rivals):
        return Ruling("ambiguous", case.alike)
    return None


def rivals_are_left(case: Case) -> Ruling | None:
    """Rule: another set explains as much."""
    return Ruling("ambiguous", case.alike) if case.rivals else None


def effects_are_named(case: Case) -> Ruling:
    """Rule: what is left over was explained, by the sensor or by physics, as the most important effect that is either."""
    kinds = {effect.id: effect.kind for effect in case.leading.fit.effects}
    first = next((kinds[i] for i in case.by_importance if kinds[i] != "parameter"), "physics")
    verdict: Verdict = "sensor" if first == "sensor" else "physics"
    return Ruling(verdict, "the named effects explain what the base model leaves over")
