"""Diagnose shapes: is there a mismatch, where along the tube, what was left out, the model with it, and is that better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.diagnosis.answer import Diagnosis, Errors, Value
from coast_cli.diagnosis.contest import run_contest, settle_close_ends
from coast_cli.diagnosis.curves import ShapeCurve
from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.judge import (
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
from coast_cli.diagnosis.shapes.leftover import find_leftover, points_noise
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.shapes.stretches import locate_along_tube
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
    FEWEST_POINTS,
    MODULUS_MOVED,
    POINTS_DOUBT,
    SAMPLES_A_PARAMETER,
)
from coast_cli.effects.effect import Effect, acting, declared
from coast_cli.effects.library.local_stiffness_defect import LocalStiffnessDefect
from coast_cli.effects.shape_stages import TUBE, OnShapes
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.noise import NoiseEstimate
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
    shown = whole if kept_back.chosen else problem
    estimate = points_noise(shown, fit(shown, until="fine"))
    floor = max(estimate.level * float(np.exp(min(estimate.log_level_std, POINTS_DOUBT))), 1e-9)
    floor = floor if noise is None else noise
    problem, whole = replace(problem, noise=floor), replace(whole, noise=floor)
    contest = run_contest(problem, most_effects)
    if kept_back.chosen:
        contest = settle_close_ends(contest, problem, whole)
    case, ruling = judge(ShapeCase(problem, kept_back, contest, estimate=estimate), SHAPE_RULES)
    return case.diagnosis(ruling)


@dataclass(frozen=True, kw_only=True)
class _Estimated:
    """What the points themselves say of their noise."""

    estimate: NoiseEstimate


@dataclass(frozen=True)
class ShapeCase(_Estimated, Case):
    """A contest over photographs to be judged."""

    problem: ShapeProblem

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
        """Return the noise of the points, m."""
        return min(self.floor, self.leading.fit.rmse)

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
        """Return the tube that an effect was chosen to sit on."""
        if TUBE not in effect.parameters_on("shapes"):
            return {}
        return {TUBE.name: Value(float(getattr(effect, TUBE.name, 0.0)), 0.0, at_bound=False)}

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
            if isinstance(effect, LocalStiffnessDefect):
                pitch = max(float(t.pitch.max()) for p in self.problem.photographs for _, t in p.tubes) / MILLIMETRE
                half = max(effect.length_mm, pitch) / 2.0
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


def only_parameters_are_named(case: ShapeCase) -> Ruling | None:
    """Rule: what is named are numbers of the tubes themselves, no physics."""
    if all(effect.kind == "parameter" for effect in case.leading.fit.effects):
        words = "within the noise once base parameters and the notch depth are corrected; no physics is missing"
        return Ruling("parameters", words)
    return None


SHAPE_RULES: tuple[VerdictRule, ...] = (
    unseen_points_are_missed,
    structure_is_left,
    nothing_is_named,
    rivals_are_left,
    only_parameters_are_named,
    effects_are_named,
)
