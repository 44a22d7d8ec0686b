"""Diagnose shapes: is there a mismatch, where along the tube, what was left out, the model with it, and is that better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.answer import Comparison, Diagnosis, Level, Named, Value, Verdict
from coast_cli.diagnosis.holdout import HoldOut
from coast_cli.diagnosis.locate import Region
from coast_cli.diagnosis.shapes.contest import Contest, Hypothesis, run_contest, settle
from coast_cli.diagnosis.shapes.errors import UNIT, errors_of, expected_of
from coast_cli.diagnosis.shapes.fit import Fit, fit
from coast_cli.diagnosis.shapes.holdout import hold_out_photographs
from coast_cli.diagnosis.shapes.leftover import Leftover, find_leftover, points_noise
from coast_cli.diagnosis.shapes.locate import locate
from coast_cli.diagnosis.shapes.problem import END_EFFECT_SPREAD, Problem, build_problem
from coast_cli.effects.shapes.catalogue import SHAPE_CATALOGUE
from coast_cli.effects.shapes.effect import TUBE
from coast_cli.effects.shapes.local_stiffness_defect import LocalStiffnessDefect
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.noise import NoiseEstimate
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.model import ShapeRun
    from coast_cli.spec.config import Config

# Structure left over is tolerated up to these shares of the noise and of what was explained.
_OF_NOISE = 0.6
_OF_EXPLAINED = 0.35
# Base parameters have moved when the refit gains this many nats and changes the fit by this share of the noise.
_PARAMETERS_GAIN = 6.0
_PARAMETERS_SIZE = 0.35
# What was held out may be missed by so many times what noise and the uncertainty of the fit let expect.
_AS_EXPECTED = 1.5
_FEWEST_POINTS = 10
_FIRST_LEVEL = 1e-4  # m, before any noise is known
_HIDDEN_IN_MODULUS = ("notch_end_effect", "chord_section", "notch_depth_error", "gravity")


def diagnose_shapes(
    config: Config, runs: Sequence[ShapeRun], *, named_hold_out: Sequence[str] = (), most_effects: int = 5
) -> Diagnosis:
    """Return the diagnosis of photographed tubes and assembled pairs.

    Args:
        config: the model that disagrees, its corrections included.
        runs: shapes of single tubes, of pairs, or both. named_hold_out: runs that no fit may see.
        most_effects: largest set that is tried.

    Raises:
        BadInput: points cannot be the shape of their tube, or a run to hold out does not exist.
    """
    whole = build_problem(config, runs)
    kept_back = hold_out_photographs(whole.photographs, named_hold_out)
    problem = whole.with_train([~rows for rows in kept_back.rows])
    if problem.size < max(_FEWEST_POINTS, 3 * problem.free):
        reason = f"only {problem.size} points can be fitted"
        return Diagnosis("insufficient", reason, 0.0, UNIT, next_recording=_next_photograph(problem))
    shown = whole if kept_back.chosen else problem
    estimate = points_noise(shown, fit(shown, level=_FIRST_LEVEL))
    floor = max(estimate.level * float(np.exp(min(estimate.log_level_std, 0.5))), 1e-9)
    contest = run_contest(problem, floor, most_effects)
    if kept_back.chosen:
        contest = settle(contest, problem, whole, floor)
    return _Judge(problem, kept_back, contest, floor, estimate).diagnosis()


@dataclass(frozen=True)
class _Judge:
    """Turns a contest into a verdict and figures; ``floor`` is the noise of the points, m, generous by its own error."""

    problem: Problem
    kept_back: HoldOut
    contest: Contest
    floor: float
    estimate: NoiseEstimate

    def diagnosis(self) -> Diagnosis:
        """Return the whole answer."""
        problem, contest, leading = self.problem, self.contest, self.contest.leading
        leftover = find_leftover(problem, leading.fit, self.floor, sure=self.estimate.sure)
        explained = float(np.sqrt(max(contest.base.fit.rmse**2 - leading.fit.rmse**2, 0.0)))
        noise = min(self.floor, leading.fit.rmse)
        unexplained = leftover.size > _OF_NOISE * noise and leftover.size > _OF_EXPLAINED * explained
        comparison = self._comparison(leading.fit)
        reason = ""
        if leading.ids and not self._holds(comparison):
            unexplained = True
            reason = f"{' + '.join(leading.ids)} fits what was fitted but does not predict what was held out"
        rivals = contest.alternatives()
        verdict = self._verdict(rivals, unexplained=unexplained)
        named = bool(leading.ids) and not unexplained
        final = self._final(contest.base.fit if unexplained else leading.fit)
        return Diagnosis(
            verdict=verdict,
            reason=reason or self._reason(verdict, leftover),
            noise=noise / MILLIMETRE,
            noise_unit=UNIT,
            where=() if verdict == "agrees" else self._where(final, named=named),
            effects=self._named(final, rivals, leftover.size / max(explained, 1e-300)) if named else (),
            alternatives=self._alternatives(verdict, rivals),
            attempts=leading.ids if unexplained else (),
            parameters=_base_values(problem, final),
            configured={parameter.key: parameter.value for parameter in problem.base[: problem.free]},
            comparison=comparison,
            next_recording=self._next_recording(verdict),
            notes=(*self._notes(verdict), *_spread_note(problem, final)),
            model_effects=tuple(effect for effect in final.effects if not effect.of_stock),
            model_parameters=problem.values(final.coordinates),
            model_tubes=problem.corrected_tubes(final.coordinates, final.effects),
        )

    def _holds(self, comparison: Comparison) -> bool:
        """Return whether the effects predict what was held out better than without them, or as well as can be expected."""
        before, after = comparison.refitted.held_out, comparison.with_effects.held_out
        if before is None or after is None or after < before:
            return True
        return after < _AS_EXPECTED * expected_of(
            self.problem, self.contest.leading.fit, self.kept_back.rows, self.floor
        )

    def _verdict(self, rivals: Sequence[Hypothesis], *, unexplained: bool) -> Verdict:
        if unexplained:
            return "unexplained"
        if not self.contest.leading.ids:
            return "parameters" if self._parameters_moved() else "agrees"
        kinds = [SHAPE_CATALOGUE[identifier].kind for identifier in self._by_importance()]
        if rivals:
            return "ambiguous"
        if all(kind == "parameter" for kind in kinds):
            return "parameters"
        return "sensor" if next(kind for kind in kinds if kind != "parameter") == "sensor" else "physics"

    def _parameters_moved(self) -> bool:
        problem, base = self.problem, self.contest.base.fit
        before = problem.residual(problem.configured())
        gain = base.log_likelihood - problem.bank.evidence(before).log_likelihood
        gain -= 0.5 * problem.free * float(np.log(problem.size))
        size = float(np.sqrt(np.mean((before - base.residual) ** 2))) / base.evidence.level
        return bool(gain > _PARAMETERS_GAIN and size > _PARAMETERS_SIZE)

    def _final(self, fitted: Fit) -> Fit:
        """Return the fit on every point, unless the user named runs that no fit may see."""
        if not self.kept_back.chosen:
            return fitted
        whole = self.problem.with_train([np.ones(len(p.run), bool) for p in self.problem.photographs])
        level = max(self.floor, 0.3 * fitted.rmse)
        return fit(whole, fitted.effects, fitted.coordinates, level=level, steps=4)

    def _comparison(self, fitted: Fit) -> Comparison:
        problem, held = self.problem, self.kept_back.rows
        base = self.contest.base.fit

        def level(coordinates: FloatArray, found: Fit | None) -> tuple[Level, float]:
            effects = () if found is None else found.effects
            train = errors_of(problem, coordinates, effects, problem.train)
            out = errors_of(problem, coordinates, effects, held) if any(rows.any() for rows in held) else None
            return Level(train.shape, None if out is None else out.shape), (out or train).tip

        configured, _ = level(problem.configured(), None)
        refitted, tip_refitted = level(base.coordinates, None)
        with_effects, tip_effects = level(fitted.coordinates, fitted)
        return Comparison(
            unit=UNIT,
            held_out_runs=self.kept_back.runs,
            rule=self.kept_back.rule,
            configured=configured,
            refitted=refitted,
            with_effects=with_effects,
            tip_mm_refitted=tip_refitted,
            tip_mm_with_effects=tip_effects,
        )

    def _by_importance(self) -> list[str]:
        """Return the leading ids, the one whose loss would cost most first."""
        leading = self.contest.leading
        if len(leading.ids) < 2:
            return list(leading.ids)
        tried = {hypothesis.fit.key: hypothesis.fit.rmse for hypothesis in self.contest.tried}
        cost = {}
        for effect in leading.fit.effects:
            rest = tuple(other for other in leading.fit.effects if other is not effect)
            key = leading.fit.key - {effect.variant}
            cost[effect.id] = (
                tried.get(key)
                or fit(self.problem, rest, leading.fit.coordinates, level=self.floor, steps=6, polish=False).rmse
            )
        return sorted(leading.ids, key=lambda identifier: -cost[identifier])

    def _named(self, final: Fit, rivals: Sequence[Hypothesis], leftover: float) -> tuple[Named, ...]:
        scores = np.array([self.contest.leading.score, *(rival.score for rival in rivals)])
        weights = np.exp((scores - scores.max()) / 2.0)
        known = 1.0 / (1.0 + np.exp(np.clip((leftover - _OF_EXPLAINED) / 0.08, -50.0, 50.0)))
        confidence = float(np.clip(weights[0] / weights.sum() * known, 0.01, 0.99))
        names, place = {}, len(self.problem.base)
        for effect in final.effects:
            values = {}
            for parameter in effect.fitted():
                std = float(np.sqrt(max(final.covariance[place, place], 0.0)))
                value = float(getattr(effect, parameter.name))
                std *= value if parameter.name in effect.logarithmic else 1.0
                values[parameter.name] = Value(value, std, final.at_bound[place])
                place += 1
            if TUBE in effect.parameters:
                values["tube"] = Value(float(getattr(effect, "tube", 0.0)), 0.0, at_bound=False)
            names[effect.id] = Named(
                effect.id, effect.kind, effect.component, effect.title, effect.equation, confidence, values
            )
        return tuple(names[identifier] for identifier in self._by_importance())

    def _where(self, final: Fit, *, named: bool) -> tuple[Region, ...]:
        """Return the regions found before anything was named, and the place that a named effect has of its own."""
        regions = list(locate(self.problem, self.contest.base.fit, self.floor, self.estimate.correlation))
        share = regions[0].share if regions else 1.0
        p_value = regions[0].p_value if regions else 0.01
        for effect in final.effects if named else ():
            tube = int(getattr(effect, "tube", 0.0))
            if isinstance(effect, LocalStiffnessDefect):
                pitch = max(float(t.pitch.max()) for p in self.problem.photographs for _, t in p.tubes) / MILLIMETRE
                half = max(effect.length_mm, pitch) / 2.0
                place = Region(
                    "arc_length", None, effect.arc_length_mm - half, effect.arc_length_mm + half, share, p_value
                )
                regions = [place, *(region for region in regions if region.axis != "arc_length")]
            if tube and len(self.problem.scene.tubes) > 1:
                name = self.problem.scene.tubes[tube]
                regions = [r for r in regions if r.axis != "pair"] + [Region("pair", name, None, None, share, p_value)]
        return tuple(regions)

    def _alternatives(self, verdict: Verdict, rivals: Sequence[Hypothesis]) -> tuple[tuple[str, ...], ...]:
        if verdict == "ambiguous":
            return tuple(rival.ids for rival in rivals)
        if verdict == "parameters" and not self.contest.leading.ids and self._modulus_alone():
            return tuple((identifier,) for identifier in _HIDDEN_IN_MODULUS)
        return ()

    def _modulus_alone(self) -> bool:
        """Return whether the modulus moved and all tubes are of one geometry, so that what softens them hides in it."""
        problem = self.problem
        cells = {
            (tube.outer_radius, tube.inner_radius, tube.depth.tobytes(), tube.cut.tobytes(), tube.uncut.tobytes())
            for photograph in problem.photographs
            for _, tube in photograph.tubes
        }
        values = problem.values(self.contest.base.fit.coordinates)
        moved = any(abs(np.log(values[p.key] / p.value)) > 0.03 for p in problem.base if p.logarithmic)
        return len(cells) == 1 and moved

    def _reason(self, verdict: Verdict, leftover: Leftover) -> str:
        if verdict == "agrees":
            return "the model as configured agrees with the shapes within the noise of their points"
        if verdict == "parameters" and self.contest.leading.ids:
            return "within the noise once base parameters and the notch depth are corrected; no physics is missing"
        if verdict == "parameters" and self._modulus_alone():
            return (
                "within the noise once the base parameters are refitted; by one tube geometry alone, a wrong modulus, "
                f"{', '.join(_HIDDEN_IN_MODULUS)} cannot be told apart"
            )
        if verdict == "parameters":
            return "within the noise once the base parameters are refitted; no physics is missing"
        if verdict == "unexplained":
            repeats = f"; {100 * max(leftover.repeats, 0.0):.0f} % of it repeats" if leftover.repeats > 0.1 else ""
            return f"{leftover.size / MILLIMETRE:.3g} mm is left that no effect of the catalogue explains{repeats}"
        if verdict == "ambiguous":
            return "several sets of effects explain the shapes alike"
        return "the named effects explain what the base model leaves over"

    def _next_recording(self, verdict: Verdict) -> str:
        missing = _next_photograph(self.problem)
        if verdict == "ambiguous":
            first = self._by_importance()[0]
            return missing or SHAPE_CATALOGUE[first].decided_by
        if verdict == "unexplained":
            return missing or "the same tube once more unchanged, then turned by 90 degrees and clamped half as long"
        if verdict == "parameters" and not self.contest.leading.ids and self._modulus_alone():
            return "another tube of the same material with another notch depth or cut length, both ways up"
        return missing if verdict in ("physics", "sensor") else ""

    def _notes(self, verdict: Verdict) -> tuple[str, ...]:
        problem, notes = self.problem, []
        if _one_way_up(problem):
            notes.append(
                f"{', '.join(_one_way_up(problem))}: photographed one way up only, so natural curvature and load "
                "are told apart by the shape of the bend alone"
            )
        alone = {photograph.tubes[0][0] for photograph in problem.photographs if not photograph.is_pair}
        assumed = [name for number, name in problem.scene.tubes.items() if number not in alone]
        if assumed and verdict != "agrees":
            notes.append(
                f"{', '.join(assumed)}: never photographed alone, so depth and natural curvature are taken as "
                "configured; an error of them looks like a fault of the assembly"
            )
        if not self.kept_back.runs:
            notes.append(f"held out: {self.kept_back.rule}")
        touching = zip(problem.base, self.contest.leading.fit.at_bound, strict=False)
        notes.extend(f"{parameter.key} is on its bound" for parameter, bound in touching if bound)
        if any(p.placed.all() for p in problem.photographs):
            notes.append("shapes with one point a pitch are taken as the clamp and the middles of the rings")
        return tuple(notes)


def _spread_note(problem: Problem, final: Fit) -> list[str]:
    """Say by how much the end effect of each tube was found to differ from the table."""
    if not any(getattr(effect, "by_tube", 0.0) for effect in final.effects):
        return []
    found = problem.spreads(final.coordinates)
    parts = ", ".join(
        f"{problem.scene.tubes[n]} {100.0 * share:+.0f} %" for n, share in found.items() if abs(share) > 0.01
    )
    allowed = f"{100.0 * END_EFFECT_SPREAD:.0f} %"
    return (
        [f"the end effect of a tube may differ from its table by {allowed}, one standard deviation: {parts}"]
        if parts
        else []
    )


def _one_way_up(problem: Problem) -> list[str]:
    """Return the tubes and pairs that were not photographed both ways up."""
    sides: dict[str, set[float]] = {}
    for photograph in problem.photographs:
        sides.setdefault(photograph.run.pair, set()).add(photograph.upward)
    return [name for name, found in sides.items() if len(found) == 1]


def _next_photograph(problem: Problem) -> str:
    """Return the photographs that are missing to separate natural curvature from load, or an empty text."""
    single = _one_way_up(problem)
    if not single:
        return ""
    way = {1.0: "down", -1.0: "up"}
    wanted = {p.run.pair: way[p.upward] for p in problem.photographs if p.run.pair in single}
    parts = ", ".join(f"{name} with natural = {side}" for name, side in wanted.items())
    return f"the same tubes turned over ({parts}), 40 points or more each: this separates natural curvature from load"


def _base_values(problem: Problem, fitted: Fit) -> dict[str, Value]:
    found = {}
    for place, parameter in enumerate(problem.base[: problem.free]):
        value = problem.values(fitted.coordinates)[parameter.key]
        spread = float(np.sqrt(max(fitted.covariance[place, place], 0.0)))
        found[parameter.key] = Value(value, value * spread if parameter.logarithmic else spread, fitted.at_bound[place])
    return found
