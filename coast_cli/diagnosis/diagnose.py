"""Diagnose a joint recording: is there a mismatch, where, what was left out, the model with it, and is that better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.answer import Comparison, Diagnosis, Level, Named, Value, Verdict
from coast_cli.diagnosis.contest import Contest, Hypothesis, run_contest
from coast_cli.diagnosis.errors import UNITS, errors_of, held_out_spread, to_unit
from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.holdout import HoldOut, hold_out
from coast_cli.diagnosis.locate import locate
from coast_cli.diagnosis.loop import widest_loop
from coast_cli.diagnosis.problem import CONFIG_KEYS, Problem, build_problem
from coast_cli.diagnosis.spread import Spread, effect_keys, spread_of
from coast_cli.diagnosis.structure import Structure, find_structure
from coast_cli.effects.backlash import Backlash
from coast_cli.effects.catalogue import CATALOGUE
from coast_cli.effects.effect import Effect
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.model import JointRun
    from coast_cli.spec.config import Config

# A record whose residual stands this far above its own noise floor is not explained by noise.
_ABOVE_NOISE = 1.9
# ... and this far, with slow noise counted in full, where nothing was named: a drift of the camera reaches 2.2.
_FAR_ABOVE_NOISE = 2.5
# Structure left over is tolerated up to these shares of the noise and of what was explained.
_OF_NOISE = 0.6
_OF_EXPLAINED = 0.35
# Two effects that only bend against each other draw anything: of a set, less may be left over.
_OF_EXPLAINED_BY_SETS = 0.22
# ... and on rows that were not fitted the error must fall to this share, unless it is at the noise.
_OF_HELD_OUT = 0.55
# Growth of a held-out error within the noise that still counts as none.
_HARM = 1.1
# An effect of a set is needed where unseen rows are predicted worse without it, by at least this factor.
_NEEDED = 1.01
# A base parameter has moved when the refit gains this many nats and changes the fit by this share of the noise.
_PARAMETERS_GAIN = 6.0
_PARAMETERS_SIZE = 0.35
# Share of the residual that other runs must predict to count as structure; slow noise reaches 0.4 by chance.
_REPEATS = 0.45
# No name is surer than this: the README's run bears out no more.
_SUREST = 0.95
# An effect that changes the prediction by less than this share of the noise has gone.
_UNFELT = 0.1
_FEWEST_SAMPLES = 12
# A response of which the base model leaves no more than this share moves, however noisy its few samples look.
_FOLLOWED = 0.5


def diagnose_joint(
    config: Config, runs: Sequence[JointRun], *, named_hold_out: Sequence[str] = (), most_effects: int = 5
) -> Diagnosis:
    """Return the diagnosis of a joint recording.

    Args:
        config: the model that disagrees, its corrections included.
        runs: of one kind of response. named_hold_out: runs that no fit may see.
        most_effects: largest set that is tried.

    Raises:
        BadInput: a run to hold out does not exist.
    """
    kept_back = hold_out(runs, named_hold_out)
    problem = build_problem(config, runs, kept_back.rows)
    reason = _insufficient(problem)
    if reason:
        kind = problem.runs[0].kind
        return Diagnosis(
            "insufficient", reason, to_unit(kind, problem.noise), UNITS[kind], next_recording=_FIRST_RECORDING
        )
    contest = run_contest(problem, most_effects)
    return _Judge(problem, kept_back, contest).diagnosis()


_FIRST_RECORDING = (
    "load from slack to the largest stroke and release to zero, 200 samples or more, at two bending lengths"
)


def _insufficient(problem: Problem) -> str:
    """Return why the recording cannot decide anything, or an empty text."""
    if problem.observed.size < max(_FEWEST_SAMPLES, 3 * len(problem.base)):
        return f"only {problem.observed.size} samples can be fitted"
    spans = [float(np.ptp(run.drive)) for run in problem.runs]
    if max(spans) <= 0.0:
        return "the drive never moves"
    moved = float(np.std(problem.observed))
    if moved <= 1.3 * problem.floor and fit(problem).rmse > _FOLLOWED * moved:
        return "the response never moves by more than its noise"
    return ""


@dataclass(frozen=True)
class _Judge:
    """Turns a contest into a verdict, and the verdict into figures."""

    problem: Problem
    kept_back: HoldOut
    contest: Contest

    def diagnosis(self) -> Diagnosis:
        """Return the whole answer."""
        problem, contest = self.problem, self.contest
        leading = contest.leading
        # To say that something unknown is there is as grave as a name: without one, all slow noise is granted.
        floor = problem.floor if leading.ids else problem.highest_floor
        structure = find_structure(problem, leading.fit)
        excess = _excess(leading.fit, floor, structure, _ABOVE_NOISE if leading.ids else _FAR_ABOVE_NOISE)
        explained = float(np.sqrt(max(contest.base.fit.rmse**2 - leading.fit.rmse**2, 0.0)))
        allowed = _OF_EXPLAINED if len(leading.ids) < 2 or problem.runs[0].kind == "notch" else _OF_EXPLAINED_BY_SETS
        unexplained = excess > _OF_NOISE * min(floor, leading.fit.rmse) and excess > allowed * explained
        comparison = self._comparison(leading.fit)
        if leading.ids and not self._carries_over(leading.fit, comparison, floor):
            # What does not carry over to unseen rows is dropped: a part of it that does is judged in its place, or the base.
            part = next((h for h in contest.parts() if self._carries_over(h.fit, self._comparison(h.fit), floor)), None)
            if part is not None:
                return replace(self, contest=replace(contest, leading=part)).diagnosis()
            base_alone = replace(self, contest=replace(contest, leading=contest.base, tried=(contest.base,)))
            judged = base_alone.diagnosis()
            tried = f"{' + '.join(leading.ids)} fits what was fitted but does not predict what was held out"
            return replace(judged, attempts=leading.ids, reason=f"{judged.reason}; {tried}")
        idle = self._idle_beside(leading, comparison)
        if idle is not None:
            return replace(self, contest=replace(contest, leading=idle)).diagnosis()
        final = self._final(leading.fit)
        vanished = _vanished(problem, final)
        if vanished:
            # What all rows together do not hold is not named; the set without it is judged in its place.
            rest = next((h for h in contest.tried if set(h.ids) == set(leading.ids) - vanished), contest.base)
            return replace(self, contest=replace(contest, leading=rest)).diagnosis()
        verdict = self._verdict(unexplained=unexplained)
        named = self._named(leading, final, excess, explained) if verdict in ("physics", "sensor", "ambiguous") else ()
        kind = problem.runs[0].kind
        level = leading.fit.evidence.level if not unexplained else min(floor, leading.fit.rmse)
        quiet = replace(contest.base.fit, evidence=replace(leading.fit.evidence, level=level))
        where = () if verdict == "agrees" else locate(problem, quiet)
        used = final if not unexplained else self._final(contest.base.fit)
        return Diagnosis(
            verdict=verdict,
            reason=self._reason(verdict, excess, structure),
            noise=to_unit(kind, level),
            noise_unit=UNITS[kind],
            where=where,
            effects=named,
            alternatives=tuple(other.ids for other in self._rivals()) if named else (),
            attempts=leading.ids if unexplained else (),
            parameters=_base_values(problem, used),
            configured={parameter.name: parameter.value for parameter in problem.base},
            comparison=comparison,
            next_recording=self._next_recording(verdict),
            notes=self._notes(),
            model_effects=() if unexplained else final.effects,
            model_parameters=problem.values(used.coordinates),
            model_spread=_spread(problem, used),
        )

    def _verdict(self, *, unexplained: bool) -> Verdict:
        if unexplained:
            return "unexplained"
        if not self.contest.leading.ids:
            return "parameters" if self._parameters_moved() else "agrees"
        first = _by_importance(self.problem, self.contest)[0]
        if any(first not in rival.ids for rival in self._rivals()):
            return "ambiguous"
        return "sensor" if CATALOGUE[first].kind == "sensor" else "physics"

    def _rivals(self) -> tuple[Hypothesis, ...]:
        """Return alternatives as small as the leading set."""
        if not self.contest.leading.ids:
            return ()
        size = len(self.contest.leading.ids)
        return tuple(other for other in self.contest.alternatives() if 0 < len(other.ids) <= size)

    def _parameters_moved(self) -> bool:
        problem, base = self.problem, self.contest.base.fit
        response, tension = problem.fitted(problem.predict(problem.configured(), ()))
        as_configured = problem.bank.evidence(problem.observed - response).log_likelihood
        as_configured += problem.tension_bank.evidence(problem.observed_tension - tension).log_likelihood
        gain = base.log_likelihood - as_configured - 0.5 * len(problem.base) * np.log(problem.observed.size)
        refitted, _ = problem.fitted(problem.predict(base.coordinates, ()))
        size = float(np.sqrt(np.mean((response - refitted) ** 2))) / base.evidence.level
        return bool(gain > _PARAMETERS_GAIN and size > _PARAMETERS_SIZE)

    def _final(self, fitted: Fit) -> Fit:
        """Return the fit on every run, unless the user named runs that no fit may see."""
        if not self.kept_back.chosen or not any(rows.any() for rows in self.kept_back.rows):
            return fitted
        whole = self.problem.only([np.ones(len(run), bool) for run in self.problem.runs])
        return fit(whole, fitted.effects, fitted.coordinates, steps=6)

    def _comparison(self, fitted: Fit) -> Comparison:
        problem, base = self.problem, self.contest.base.fit
        held = self.kept_back.rows

        def level(coordinates: FloatArray, effects: Sequence[Effect]) -> tuple[Level, float]:
            train = errors_of(problem, coordinates, effects, problem.train)
            out = errors_of(problem, coordinates, effects, held) if any(rows.any() for rows in held) else None
            return Level(train.response, None if out is None else out.response), (out or train).tip_mm

        configured, _ = level(problem.configured(), ())
        refitted, tip_refitted = level(base.coordinates, ())
        with_effects, tip_effects = level(fitted.coordinates, fitted.effects)
        return Comparison(
            unit=UNITS[problem.runs[0].kind],
            held_out_runs=self.kept_back.runs,
            rule=self.kept_back.rule,
            configured=configured,
            refitted=refitted,
            with_effects=with_effects,
            tip_mm_refitted=tip_refitted,
            tip_mm_with_effects=tip_effects,
        )

    def _idle_beside(self, leading: Hypothesis, comparison: Comparison) -> Hypothesis | None:
        """Return the leading set less one effect, where that predicts unseen rows as well; None where all are needed."""
        after = comparison.with_effects.held_out
        if after is None or len(leading.ids) < 2:
            return None
        for part in self.contest.parts():
            if len(part.ids) == len(leading.ids) - 1:
                without = self._comparison(part.fit).with_effects.held_out
                if without is not None and without <= _NEEDED * after:
                    return part
        return None

    def _carries_over(self, fitted: Fit, comparison: Comparison, floor: float) -> bool:
        """Return whether most of the improvement is there on rows that were not fitted; ``floor`` in SI.

        Held-out rows that the base model predicts within the noise cannot show an improvement, only harm. Elsewhere the
        error may be as large as the noise and what the fit does not know of its parameters make it.
        """
        before, after = comparison.refitted.held_out, comparison.with_effects.held_out
        if before is None or after is None:
            return True
        within = _ABOVE_NOISE * to_unit(self.problem.runs[0].kind, floor)
        if before < within:
            return after < _HARM * before
        if after < before and (after < within or after < _OF_HELD_OUT * before):
            return True
        unsure = held_out_spread(self.problem, fitted, self.kept_back.rows)
        return after < before and after < np.hypot(within, _ABOVE_NOISE * unsure)

    def _named(self, leading: Hypothesis, final: Fit, excess: float, explained: float) -> tuple[Named, ...]:
        confidence = _confidence(self.contest, self._rivals(), excess / max(explained, 1e-300))
        size, names = len(self.problem.base), {}
        place = size
        for effect in final.effects:
            values = {}
            for parameter in effect.parameters:
                std = float(np.sqrt(max(final.covariance[place, place], 0.0)))
                values[parameter.name] = Value(getattr(effect, parameter.name), std, final.at_bound[place])
                place += 1
            names[effect.id] = Named(
                effect.id, effect.kind, effect.component, effect.title, effect.equation, confidence, values
            )
        return tuple(names[identifier] for identifier in _by_importance(self.problem, self.contest))

    def _reason(self, verdict: Verdict, excess: float, structure: Structure) -> str:
        kind = self.problem.runs[0].kind
        unit = "1/m" if kind == "curvature" else "degrees"
        if verdict == "agrees":
            return "the model as configured agrees with the recording within its noise"
        if verdict == "parameters":
            return "within the noise once the base parameters are refitted; no physics is missing"
        if verdict == "unexplained" and excess > 0.0:
            kept = "needs direction or history" if structure.memory else "needs neither direction nor history"
            repeats = f"{100 * max(structure.repeats, 0.0):.0f} % of it repeats from run to run"
            size = f"{to_unit(kind, excess):.3g} {unit}"
            return f"{size} is left that no effect of the catalogue explains; {repeats}, and it {kept}"
        if verdict == "ambiguous":
            return "several sets of effects explain the recording alike"
        return "the named effects explain what the base model leaves over"

    def _next_recording(self, verdict: Verdict) -> str:
        rivals = self._rivals()
        if rivals:
            from coast_cli.diagnosis.plan import next_recording

            proposals = next_recording(self.problem, [self.contest.leading.fit, *(rival.fit for rival in rivals[:3])])
            if proposals and proposals[0].gain > 0.0:
                return f"{proposals[0].words} (expected to add {proposals[0].gain:.0f} nats between the closest two)"
            return CATALOGUE[_by_importance(self.problem, self.contest)[0]].decided_by
        if verdict == "unexplained":
            return (
                "the same sweep twice, unchanged, then at half the rate and at another bending length, "
                "with time and tension recorded"
            )
        if verdict in ("physics", "sensor"):
            return CATALOGUE[_by_importance(self.problem, self.contest)[0]].decided_by
        return _untested(self.problem)

    def _loop_note(self) -> list[str]:
        """Say how wide the loop is low and high up, where what was named is one of those that make loops."""
        named = {CATALOGUE[identifier] for identifier in self.contest.leading.ids}
        loop = widest_loop(self.problem.runs)
        if loop is None or not any(effect.reverses or effect is Backlash for effect in named):
            return []
        unit, name = (MILLIMETRE, "mm") if self.problem.runs[0].stroke is not None else (1.0, "N")
        low, high = f"{loop.low / unit:.2g} {name}", f"{loop.high / unit:.2g} {name}"
        return [f"the loop is {low} wide at a fifth of the response and {high} at four fifths: {loop.meaning}"]

    def _notes(self) -> tuple[str, ...]:
        runs, notes = self.problem.runs, []
        if not self.problem.holds["time"]:
            notes.append(
                "there is no time_s: samples are taken as one second apart (assumed), so what lag, creep or drift "
                "show is weaker, and their time constants count samples"
            )
        if not self.problem.holds["release"]:
            notes.append("there is no release, so friction, play and set cannot show")
        elif self.problem.holds["time"] and not self.problem.holds["rates"]:
            notes.append("the drive has one rate and no hold, so a late camera can hardly be told from play")
        notes.extend(self._loop_note())
        lengths = [float(np.median(run.bending_length)) for run in runs]
        if np.ptp(lengths) <= 0.05 * max(lengths):
            notes.append("there is one bending length, so what grows with it is taken up by the modulus")
        if not self.kept_back.runs:
            notes.append(f"held out: {self.kept_back.rule}")
        touching = [
            parameter.name
            for parameter, bound in zip(self.problem.base, self.contest.leading.fit.at_bound, strict=False)
            if bound
        ]
        notes.extend(f"{name} is on its bound" for name in touching)
        if not self.contest.leading.fit.converged:
            notes.append("the fit was still moving when it stopped")
        return tuple(notes)


def _untested(problem: Problem) -> str:
    """Return the recording that would show what this one cannot, in bench words; empty where little is left open."""
    runs = problem.runs
    top = max(float(np.max(run.drive)) for run in runs)
    reach = f"{top / MILLIMETRE:.3g} mm" if runs[0].stroke is not None else f"{top:.3g} N"
    lengths = [float(np.median(run.bending_length)) for run in runs]
    parts = []
    if not problem.holds["release"]:
        parts.append(f"load to {reach}, release to half of it, load again and release to zero")
    if np.ptp(lengths) <= 0.05 * max(lengths) and runs[0].kind != "notch":
        half = 0.5 * max(lengths) / MILLIMETRE
        parts.append(f"the same at X2 = {half:.3g} mm beside {max(lengths) / MILLIMETRE:.3g} mm")
    lowest = min(float(np.min(run.drive)) for run in runs)
    if lowest > (max(problem.joints[runs[0].pair].deadband, 0.02 * top) if runs[0].stroke is not None else 0.02 * top):
        parts.append("begin each sweep slack, at zero " + ("stroke" if runs[0].stroke is not None else "tension"))
    if not problem.holds["time"]:
        parts.append("record time_s, at two rates ten times apart, with a hold of 60 s at the largest drive")
    if runs[0].stroke is not None and problem.tension_noise is None:
        parts.append("record tension_n")
    return "; ".join(parts)


def _excess(fitted: Fit, floor: float, structure: Structure, margin: float) -> float:
    """Return the RMS of what is neither model nor noise, SI; a residual within ``margin`` of the floor is noise."""
    above = np.sqrt(max(fitted.rmse**2 - floor**2, 0.0)) if fitted.rmse > margin * floor else 0.0
    repeated = fitted.rmse * np.sqrt(max(structure.repeats, 0.0)) if structure.repeats > _REPEATS else 0.0
    return float(max(above, repeated))


def _vanished(problem: Problem, final: Fit) -> set[str]:
    """Return the effects without which the final model predicts the same, beside the noise."""
    response, tension = problem.fitted(problem.predict(final.coordinates, final.effects))
    found = set()
    for effect in final.effects:
        others = [other for other in final.effects if other is not effect]
        without, slackened = problem.fitted(problem.predict(final.coordinates, others))
        change = float(np.sqrt(np.mean((response - without) ** 2))) / max(final.evidence.level, 1e-15)
        if tension.size:
            witness = float(np.sqrt(np.mean((tension - slackened) ** 2)))
            change = max(change, witness / max(final.tension_evidence.level, 1e-15))
        if change < _UNFELT:
            found.add(effect.id)
    return found


def _by_importance(problem: Problem, contest: Contest) -> list[str]:
    """Return the leading ids, the one whose loss would cost most first."""
    leading = contest.leading
    if len(leading.ids) < 2:
        return list(leading.ids)
    tried = {frozenset(h.ids): h for h in contest.tried}
    cost = {}
    for identifier in leading.ids:
        rest = frozenset(leading.ids) - {identifier}
        without = tried.get(rest)
        if without is None:
            effects = tuple(effect for effect in leading.fit.effects if effect.id != identifier)
            rmse = fit(problem, effects, leading.fit.coordinates, steps=6, polish=False).rmse
        else:
            rmse = without.fit.rmse
        cost[identifier] = rmse
    return sorted(leading.ids, key=lambda identifier: -cost[identifier])


def _confidence(contest: Contest, rivals: Sequence[Hypothesis], leftover: float) -> float:
    """Return the probability that the leading set is right: against its rivals, and against something unknown."""
    scores = np.array([contest.leading.score, *(rival.score for rival in rivals)])
    weights = np.exp((scores - scores.max()) / 2.0)
    known = 1.0 / (1.0 + np.exp((leftover - _OF_EXPLAINED) / 0.08))
    return float(np.clip(weights[0] / weights.sum() * known, 0.01, _SUREST))


def _base_values(problem: Problem, fitted: Fit) -> dict[str, Value]:
    found = {}
    for place, parameter in enumerate(problem.base):
        value = problem.values(fitted.coordinates)[parameter.name]
        spread = float(np.sqrt(max(fitted.covariance[place, place], 0.0)))
        std = value * spread if parameter.logarithmic else spread
        found[parameter.name] = Value(value, std, fitted.at_bound[place])
    return found


def _spread(problem: Problem, fitted: Fit) -> Spread:
    values = problem.values(fitted.coordinates)
    keys = [CONFIG_KEYS[parameter.name] for parameter in problem.base] + effect_keys(fitted.effects)
    scale = [values[parameter.name] if parameter.logarithmic else 1.0 for parameter in problem.base]
    return spread_of(keys, [*scale, *[1.0] * (len(keys) - len(scale))], fitted.covariance)
