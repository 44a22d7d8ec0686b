"""Diagnose shapes: is there a mismatch, where along the tube, what was left out, the model with it, and is that better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.diagnosis.answer import Diagnosis, Errors, Test, Value
from coast_cli.diagnosis.contest import hypothesis, run_contest, settle_close_ends
from coast_cli.diagnosis.curves import ShapeCurve
from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.judge import (
    SOMETHING_ELSE,
    Case,
    Leftover,
    Ruling,
    VerdictRule,
    effects_are_named,
    judge,
    nothing_is_named,
    rivals_are_left,
    structure_is_left,
)
from coast_cli.diagnosis.locate import Region
from coast_cli.diagnosis.shapes.build import build_shape_problem
from coast_cli.diagnosis.shapes.curves import shape_curves
from coast_cli.diagnosis.shapes.ends import early_ends
from coast_cli.diagnosis.shapes.errors import UNIT, expected_of, shape_errors_of
from coast_cli.diagnosis.shapes.holdout import hold_out_photographs
from coast_cli.diagnosis.shapes.law_words import describe_shape
from coast_cli.diagnosis.shapes.laws import ShapeLawFit, ShapeWorld, names_of
from coast_cli.diagnosis.shapes.leftover import find_leftover
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.shapes.stretches import locate_along_tube
from coast_cli.diagnosis.shapes.unseen import photographs_against_the_rest, points_foretold
from coast_cli.diagnosis.shapes.words import (
    ANOTHER_GEOMETRY,
    HIDDEN_IN_MODULUS,
    SAME_TUBE_AGAIN,
    next_photograph,
    shape_limits,
    spread_note,
)
from coast_cli.diagnosis.space import Booleans
from coast_cli.diagnosis.thresholds import (
    AS_EXPECTED,
    DOUBTED_NAMES,
    FEWEST_POINTS,
    LAW_CERTIFIED,
    MAX_UNEXPLAINED_SHARE,
    MODULUS_MOVED,
    POINTS_DOUBT,
    SAMPLES_A_PARAMETER,
)
from coast_cli.diagnosis.unnamed.words import Description
from coast_cli.diagnosis.unseen import Unseen
from coast_cli.effects.effect import Effect, acting, declared
from coast_cli.effects.library.clipped_weight import ClippedWeight
from coast_cli.effects.library.kink import Kink
from coast_cli.effects.library.local_stiffness_defect import LocalStiffnessDefect
from coast_cli.effects.shape_stages import OF_CURVATURE, TUBE, OnShapes
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.noise import NoiseEstimate
from coast_cli.recordings.shape_noise import shape_noise
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.model import ShapeRun
    from coast_cli.spec.config import Config


def diagnose_shapes(
    config: Config,
    runs: Sequence[ShapeRun],
    *,
    named_hold_out: Sequence[str] = (),
    most_effects: int = 5,
    without: Sequence[str] = (),
    noise: float | None = None,
) -> Diagnosis:
    """Return the diagnosis of photographed tubes and assembled pairs.

    Args:
        config: the model that disagrees, its corrections included.
        runs: shapes of single tubes, of pairs, or both. named_hold_out: runs that no fit may see.
        most_effects: largest set that is tried. without: ids of effects that are neither named nor rivals.
        noise: of the points, m, where it is known.

    Raises:
        BadInput: points cannot be the shape of their tube, or a run to hold out does not exist.
    """
    whole = build_shape_problem(config, runs, without=without)
    kept_back = hold_out_photographs(whole.photographs, named_hold_out)
    problem = whole.only(kept_back.fitted)
    if problem.size < max(FEWEST_POINTS, SAMPLES_A_PARAMETER * problem.free):
        reason = f"only {problem.size} points can be fitted"
        return Diagnosis("insufficient", reason, 0.0, UNIT, next_recording=next_photograph(problem), recording="shapes")
    estimate = shape_noise([run for run in runs if kept_back.chosen or run.name not in kept_back.runs], noise)
    floor = max(estimate.level * float(np.exp(min(estimate.log_level_std, POINTS_DOUBT))), 1e-9)
    problem, whole = (replace(one, noise=floor, estimate=estimate) for one in (problem, whole))
    contest = run_contest(problem, most_effects)
    if kept_back.chosen:
        contest = settle_close_ends(contest, problem, whole)
    case, ruling = judge(
        ShapeCase(problem, kept_back, contest, estimate=estimate, has_laws=most_effects > 0), SHAPE_RULES
    )
    return case.diagnosis(ruling)


@dataclass(frozen=True)
class ShapeCase(Case):
    """A contest over photographs to be judged.

    Attributes:
        estimate: of the noise of the points. law: without a name, that leads; None where there is none.
        told: what the law competed with. has_laws: whether laws without a name compete at all.
        is_doubted: whether a law was ahead of the names that unseen points do not show clearly.
    """

    problem: ShapeProblem
    estimate: NoiseEstimate = field(kw_only=True)
    law: ShapeLawFit | None = field(default=None, kw_only=True)
    told: ShapeWorld | None = field(default=None, kw_only=True)
    has_laws: bool = field(default=True, kw_only=True)
    is_doubted: bool = field(default=False, kw_only=True)

    unit = UNIT
    agrees = "the model as configured agrees with the shapes within the noise of their points"
    alike = "several sets of effects explain the shapes alike"

    def in_unit(self, value: float) -> float:
        """Return a distance in mm."""
        return value / MILLIMETRE

    def errors(self, coordinates: FloatArray, effects: Sequence[Any], rows: Sequence[Booleans]) -> Errors:
        """Return the errors of a model on some points."""
        return shape_errors_of(self.problem, coordinates, effects, rows)

    def _leftover(self) -> Leftover:
        found = find_leftover(self.problem, self.leading.fit, self.floor, sure=self.estimate.sure)
        repeats = f"; {100 * max(found.repeats, 0.0):.0f} % of it repeats" if found.repeats > 0.1 else ""
        words = f"{found.size / MILLIMETRE:.3g} mm is left that no effect of the catalogue explains{repeats}"
        return Leftover(found.size, words)

    def noise_level(self, ruling: Ruling) -> float:
        """Return the noise of the points across the line, m."""
        return self.estimate.level

    @property
    def response_noise(self) -> float:
        """The noise beside which distances stand, which have it along both axes, mm."""
        return float(np.sqrt(2.0)) * self.estimate.level / MILLIMETRE

    @cached_property
    def world(self) -> ShapeWorld:
        """Names against laws without a name."""
        return ShapeWorld(self.problem, self.contest)

    @cached_property
    def described(self) -> Description | None:
        """What is said of the law that leads; None where there is none."""
        if self.law is None or self.told is None or self.names:
            return None
        fitted = self.law.fit
        count = len(self.law.law.values())
        before = points_foretold(self.problem, self.contest.base.fit, self.kept_back.rows)
        return describe_shape(
            self.told.alike(self.law),
            self.problem.scene.tubes,
            self.told.nearest,
            fitted.covariance[-count:, -count:],
            (before.error, self.certified.error) if self.certified.count else None,
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Ids of the leading set that have a name."""
        return names_of(_shape_effects(self.leading.fit))

    @cached_property
    def certainty(self) -> float:
        """Probability that a name is right; no more than even odds where a law was ahead of the names."""
        return min(super().certainty, float(DOUBTED_NAMES) if self.is_doubted else 1.0)

    def probabilities(self, ruling: Ruling) -> dict[str, float]:
        """Return the probability of each name and of something else, which it is where a law without a name leads."""
        return {SOMETHING_ELSE: 1.0} if self.described is not None else super().probabilities(ruling)

    def tried_in_vain(self, ruling: Ruling) -> tuple[str, ...]:
        """Return the ids of names that were not good enough, also where a law took their place."""
        return super().tried_in_vain(ruling) if self.told is None else self.told.contest.leading.ids

    def is_named(self, ruling: Ruling) -> bool:
        """Return whether the leading set is named."""
        return super().is_named(ruling) and ruling.verdict != "unnamed"

    @cached_property
    def certified(self) -> Unseen:
        """How the leading set foretells the points that were kept back."""
        return points_foretold(self.problem, self.leading.fit, self.kept_back.rows)

    @cached_property
    def against_the_rest(self) -> dict[str, Unseen]:
        """How well the other photographs foretell each, to first order."""
        return photographs_against_the_rest(self.problem, self.leading.fit)

    @property
    def strangers(self) -> dict[str, Unseen]:
        """Photographs that the others do not foretell, by name."""
        return {name: one for name, one in self.against_the_rest.items() if not one.passed}

    @property
    def tests(self) -> tuple[Test, ...]:
        """Unseen points, every photograph against the others, and whether noise alone asks as loudly for a law."""
        found = []
        if self.kept_back.any:
            found.append(Test("rows_not_seen", self.certified.p_value, self.certified.passed))
        if self.against_the_rest:
            least = min(one.p_value for one in self.against_the_rest.values())
            found.append(Test("every_run_against_the_others", least, not self.strangers))
        if self.has_laws and self.told is None:
            asked = self.world.asked.p_value
            found.append(Test("no_law_without_a_name_is_asked_for", asked, self.world.is_complete))
        return tuple(found)

    @cached_property
    def is_refused_by_unseen_points(self) -> bool:
        """Whether unseen points contradict the answer; a name may leave a part of what it explains, which is said."""
        if not self.leading.ids:
            return not self.certified.passed or bool(self.strangers)
        if self.certified.passed:
            return False
        before = points_foretold(self.problem, self.contest.base.fit, self.kept_back.rows)
        return self.certified.error > MAX_UNEXPLAINED_SHARE * before.error

    @property
    def missed_words(self) -> str:
        """Which unseen points are missed, and by how much."""
        parts = []
        if not self.certified.passed:
            points = ", ".join(self.kept_back.runs) or "points that were not fitted"
            parts.append(f"{points}: {self.certified.error:.1f} noise widths, {self.certified.allowed:.1f} allowed")
        if not self.leading.ids:
            for name, unseen in sorted(self.strangers.items(), key=lambda item: -item[1].error):
                parts.append(f"{name}, foretold by the others: {unseen.error:.1f}, {unseen.allowed:.1f} allowed")
        what = " + ".join(self.leading.ids) or "the base model"
        return f"{what} does not foretell what it was not fitted to ({'; '.join(parts[:3])})"

    def curves(self, final: Fit) -> tuple[ShapeCurve, ...]:
        """Return the lines of both models at the points of every photograph."""
        return shape_curves(self.problem, self.contest.base.fit, final)

    def model_tubes(self, final: Fit) -> dict[str, float | list[float]]:
        """Return what of the model is saved as numbers of its tubes."""
        return self.problem.corrected_tubes(final.coordinates, _shape_effects(final))

    def saved_effects(self, final: Fit) -> tuple[Effect, ...]:
        """Return what of the model is saved as corrections."""
        return tuple(effect for effect in _shape_effects(final) if not effect.of_stock)

    def chosen(self, effect: Effect) -> dict[str, Value]:
        """Return the tube that an effect was chosen to sit on, and the natural curvature that it is in proportion to."""
        known = effect.parameters_on("shapes")
        found = {TUBE.name: float(getattr(effect, TUBE.name, 0.0))} if TUBE in known else {}
        if getattr(effect, OF_CURVATURE.name, 0.0):
            found[OF_CURVATURE.name] = float(getattr(effect, OF_CURVATURE.name))
        return {name: Value(value, 0.0, at_bound=False) for name, value in found.items()}

    def alternatives(self, ruling: Ruling) -> tuple[tuple[str, ...], ...]:
        """Return the ids of sets that the shapes cannot tell from the named one, or that hide in the modulus."""
        if ruling.verdict == "ambiguous":
            return tuple(rival.ids for rival in self.rivals)
        if ruling.verdict == "parameters" and not self.leading.ids and self.modulus_alone:
            return tuple((identifier,) for identifier in HIDDEN_IN_MODULUS)
        return ()

    @cached_property
    def modulus_alone(self) -> bool:
        """Whether the modulus moved and all tubes are of one geometry, so that what softens them hides in it."""
        problem = self.problem
        cells = {
            (tube.outer_radius, tube.inner_radius, tube.depth.tobytes(), tube.cut.tobytes(), tube.uncut.tobytes())
            for photograph in problem.photographs
            for _, tube in photograph.tubes
        }
        values = problem.values(self.contest.base.fit.coordinates)
        moved = any(abs(np.log(values[p.name] / p.value)) > MODULUS_MOVED for p in problem.base if p.logarithmic)
        return len(cells) == 1 and moved

    @property
    def moved(self) -> str:
        """What is said where only base parameters have moved."""
        if self.modulus_alone:
            return (
                "within the noise once the base parameters are refitted; by one tube geometry alone, a wrong modulus, "
                f"{', '.join(HIDDEN_IN_MODULUS)} cannot be told apart"
            )
        return super().moved

    def where(self, ruling: Ruling, final: Fit) -> tuple[Region, ...]:
        """Return the regions found before anything was named, and the place that a named effect has of its own."""
        regions = list(locate_along_tube(self.problem, self.contest.base.fit, self.floor, self.estimate.correlation))
        share = regions[0].share if regions else 1.0
        p_value = regions[0].p_value if regions else 0.01
        for effect in _shape_effects(final) if self.is_named(ruling) else ():
            tube = int(getattr(effect, "tube", 0.0))
            if isinstance(effect, LocalStiffnessDefect | Kink | ClippedWeight):
                pitch = max(float(t.pitch.max()) for p in self.problem.photographs for _, t in p.tubes) / MILLIMETRE
                half = max(getattr(effect, "length_mm", 0.0), pitch) / 2.0
                low, high = effect.arc_length_mm - half, effect.arc_length_mm + half
                place = Region("arc_length", None, low, high, share, p_value)
                regions = [place, *(region for region in regions if region.axis != "arc_length")]
            if tube and len(self.problem.scene.tubes) > 1:
                name = self.problem.scene.tubes[tube]
                regions = [r for r in regions if r.axis != "pair"] + [Region("pair", name, None, None, share, p_value)]
        return tuple(regions)

    def next_recording(self, ruling: Ruling) -> str:
        """Return the photographs that would settle what is open."""
        missing = next_photograph(self.problem)
        if ruling.verdict == "ambiguous":
            return missing or declared(self.first_effect(), "shapes").decided_by
        if ruling.verdict == "unnamed" and self.law is not None:
            return missing or self.law.law.decided_by
        if ruling.verdict == "unexplained":
            return missing or SAME_TUBE_AGAIN
        if ruling.verdict == "parameters" and not self.leading.ids and self.modulus_alone:
            return ANOTHER_GEOMETRY
        return missing if ruling.verdict in ("physics", "sensor") else ""

    def notes(self, ruling: Ruling, final: Fit) -> tuple[str, ...]:
        """Return what shape_limits the answer, a sentence each."""
        notes = shape_limits(self.problem, agrees=ruling.verdict == "agrees")
        if not self.kept_back.runs:
            notes.append(f"held out: {self.kept_back.rule}")
        touching = zip(self.problem.base, self.leading.fit.at_bound, strict=False)
        notes.extend(f"{parameter.name} is on its bound" for parameter, bound in touching if bound)
        if any(p.placed.all() for p in self.problem.photographs):
            notes.append("shapes with one point a pitch are taken as the clamp and the middles of the rings")
        notes.extend(early_ends(self.problem.photographs))
        return (*notes, *spread_note(self.problem, final))


def _shape_effects(fitted: Fit) -> tuple[OnShapes, ...]:
    return tuple(acting(fitted.effects, OnShapes))


def unseen_points_are_missed(case: ShapeCase) -> Ruling | None:
    """Rule: effects that predict what was held out worse than no effects, and worse than can be expected, explain nothing."""
    before, after = case.comparison.refitted.held_out, case.comparison.with_effects.held_out
    if not case.leading.ids or before is None or after is None or after < before:
        return None
    if after < AS_EXPECTED * expected_of(case.problem, case.leading.fit, case.kept_back.rows, case.floor):
        return None
    names = " + ".join(case.leading.ids)
    return Ruling("unexplained", f"{names} fits what was fitted but does not predict what was held out")


def laws_of_shapes_compete(case: ShapeCase) -> Case | None:
    """Rule: a law that explains what the names leave, or what there is no name for, takes their place."""
    if case.law is not None or not case.has_laws:
        return None
    law = case.world.preferred
    if law is None:
        return None
    return replace(case.led_by(hypothesis(case.problem, law.fit)), law=law, told=case.world)


def a_law_that_unseen_points_do_not_show_is_dropped(case: ShapeCase) -> Case | None:
    """Rule: a law stands only where points that were kept back are foretold better with it than without it."""
    if case.law is None or case.told is None or not case.kept_back.any:
        return None
    before = case.told.contest.leading
    missed = points_foretold(case.problem, before.fit, case.kept_back.rows).error
    if case.certified.error <= LAW_CERTIFIED * missed:
        return None
    return replace(case.led_by(before), law=None, told=None, has_laws=False, is_doubted=True)


def a_law_of_shapes_leads(case: ShapeCase) -> Ruling | None:
    """Rule: where no name is left, the law is what is answered; where it leaves too much, it is only a part."""
    if case.described is None:
        return None
    if case.is_refused_by_unseen_points:
        return Ruling("unexplained", f"{case.missed_words}; a part of it: {case.described.words}")
    return Ruling("unnamed", f"a law without a name {case.explains_words}")


def unseen_points_decide(case: ShapeCase) -> Ruling | None:
    """Rule: what unseen points contradict is not said, be it a name or that nothing is left out."""
    return Ruling("unexplained", case.missed_words) if case.is_refused_by_unseen_points else None


def names_explain_shapes(case: ShapeCase) -> Ruling:
    """Rule: the leading effects are named, and what they explain and leave is said in noise widths."""
    ruling = effects_are_named(case)
    return Ruling(ruling.verdict, f"{' + '.join(case.leading.ids)} {case.explains_words}")


def only_parameters_are_named(case: ShapeCase) -> Ruling | None:
    """Rule: what is named are numbers of the tubes themselves, no physics."""
    if all(effect.kind == "parameter" for effect in case.leading.fit.effects):
        words = "within the noise once base parameters and the notch depth are corrected; no physics is missing"
        return Ruling("parameters", words)
    return None


SHAPE_RULES: tuple[VerdictRule, ...] = (
    laws_of_shapes_compete,
    a_law_that_unseen_points_do_not_show_is_dropped,
    a_law_of_shapes_leads,
    unseen_points_are_missed,
    structure_is_left,
    unseen_points_decide,
    nothing_is_named,
    rivals_are_left,
    only_parameters_are_named,
    names_explain_shapes,
)
