"""The rules of a joint's verdict, in the order in which they ask: each looks at a case and changes it, rules, or is silent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from coast_cli.diagnosis.contest import hypothesis
from coast_cli.diagnosis.fit import Fit, fit, rms
from coast_cli.diagnosis.joint.case import JointCase
from coast_cli.diagnosis.joint.holdout import ONE_RUN, rows_of_one_run
from coast_cli.diagnosis.joint.moments import lost_steps
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.joint.unseen import foretold
from coast_cli.diagnosis.joint.witness import load_cell_in_another_scale, same_factor_words
from coast_cli.diagnosis.judge import (
    Case,
    Ruling,
    VerdictRule,
    effects_are_named,
    first_effect_is_disputed,
    nothing_is_named,
    structure_is_left,
)
from coast_cli.diagnosis.thresholds import (
    FEWEST_RUNS_TO_DIFFER,
    FROZEN_SHARE,
    HARM,
    LAW_CERTIFIED,
    LEAST_MISFIT,
    LEAST_OF_ONE_RUN,
    NAMED_FROM,
    NEEDED,
    UNFELT,
)
from coast_cli.effects.library.bending_length_label import BendingLengthLabel
from coast_cli.effects.library.frozen_frames import FrozenFrames
from coast_cli.effects.library.lost_steps import LostSteps
from coast_cli.effects.library.run_differs import RunDiffers

OF_ONE_RUN = (RunDiffers, BendingLengthLabel, LostSteps)
_MOST_SUSPECTS = 4


def what_does_not_carry_over_is_dropped(case: JointCase) -> Case | None:
    """Rule: a set that does not predict unseen rows gives way to a part of it that does, or to the base model."""
    if case.is_settled:
        return None
    leading = case.leading
    if not leading.ids or case.carries_over(leading.fit):
        return None
    for part in case.contest.parts():
        if case.carries_over(part.fit):
            return case.led_by(part)
    base = case.contest.base
    remark = f"{' + '.join(leading.ids)} fits what was fitted but does not predict what was held out"
    contest = replace(case.contest, leading=base, tried=(base,))
    return replace(case, contest=contest, attempts=leading.ids, remark=remark)


def what_is_redundant_is_dropped(case: JointCase) -> Case | None:
    """Rule: an effect of a set is dropped where unseen rows are predicted as well without it."""
    if case.is_settled:
        return None
    after = case.missed(case.leading.fit)
    if after is None or len(case.leading.ids) < 2:
        return None
    for part in case.contest.parts():
        if len(part.ids) == len(case.leading.ids) - 1:
            without = case.missed(part.fit)
            if without is not None and without <= NEEDED * after:
                return case.led_by(part)
    return None


def what_vanished_is_dropped(case: JointCase) -> Case | None:
    """Rule: what the fit to all rows together does not hold is not named; the set without it is judged in its place."""
    if case.is_settled:
        return None
    gone = _vanished(case.problem, case.final(case.leading.fit))
    if not gone:
        return None
    rest = set(case.leading.ids) - gone
    return case.led_by(next((h for h in case.contest.tried if set(h.ids) == rest), case.contest.base))


def _vanished(problem: JointProblem, final: Fit) -> set[str]:
    """Return the effects without which the final model predicts the same, beside the noise."""
    sets = [tuple(other for other in final.effects if other is not effect) for effect in final.effects]
    whole, *without = problem.residuals([(final.coordinates, effects) for effects in (final.effects, *sets)])
    found = set()
    for effect, residual in zip(final.effects, without, strict=True):
        change = max(
            rms((residual - whole)[channel.rows]) / max(evidence.level, 1e-15)
            for channel, evidence in zip(problem.channels, final.evidences, strict=True)
        )
        if change < UNFELT:
            found.add(effect.id)
    return found


def laws_without_a_name_compete(case: JointCase) -> Case | None:
    """Rule: a law that stands elsewhere and explains more takes the place of the names; what names leave is told beside."""
    if case.is_settled or case.is_closed or not case.has_laws:
        return None
    law = case.open_world.preferred or case.open_world.added
    if law is None:
        return None
    leading = hypothesis(case.problem, law.fit)
    return replace(case.led_by(leading), law=law, told=case.open_world)


def frames_that_repeat_are_named(case: JointCase) -> Case | None:
    """Rule: frames that repeat in bursts are a fault of the camera; they were left out of every fit."""
    problem = case.problem
    if case.is_stale or problem.frozen_fraction < FROZEN_SHARE or FrozenFrames.id in problem.concealed:
        return None
    leading = case.leading.fit
    effects = problem.ordered((*leading.effects, FrozenFrames(fraction=problem.frozen_fraction)))
    named = hypothesis(problem, fit(problem, effects, leading.coordinates, steps=0))
    tried = case.contest.tried if case.leading.ids else (case.contest.base,)
    return replace(case, contest=replace(case.contest, leading=named, tried=tried), is_stale=True)


def a_law_that_unseen_rows_do_not_show_is_dropped(case: JointCase) -> Case | None:
    """Rule: a law stands only where the certifying rows are foretold better with it than without it."""
    if case.law is None or case.told is None or case.remark or not case.kept_back.any:
        return None
    before = case.told.contest.leading
    without = fit(case.known, before.fit.effects, before.fit.coordinates, steps=0)
    missed = foretold(case.known, without, case.kept_back.rows).error
    wanted = foretold(case.known, case.refitted_base, case.kept_back.rows).error > LEAST_MISFIT
    if wanted and case.certified.error <= LAW_CERTIFIED * missed:
        return None
    leading = before if wanted else case.contest.base
    return replace(case.led_by(leading), law=None, told=None, is_closed=True)


def a_law_without_a_name_leads(case: JointCase) -> Ruling | None:
    """Rule: where no name is left, the law is what is answered; beyond two laws it is only a part."""
    if case.described is None or case.names:
        return None
    if case.is_refused_by_unseen_rows:
        return Ruling("unexplained", f"{case.missed_words}; a law without a name explains a part of it")
    return Ruling("unnamed", f"a law without a name {case.explains_words}")


def names_explain(case: JointCase) -> Ruling:
    """Rule: the leading effects are named, and what they explain and leave is said in noise widths."""
    ruling = effects_are_named(case)
    owners = [case.problem.runs[round(e.run)].name for e in case.leading.fit.effects if isinstance(e, OF_ONE_RUN)]
    which = f" (run {', '.join(owners)})" if owners else ""
    return Ruling(ruling.verdict, f"{' + '.join(case.names)}{which} {case.explains_words}")


def one_run_is_not_blamed_for_slow_noise(case: JointCase) -> Case | None:
    """Rule: what one run alone has must stand clear of noise, as slow noise differs from run to run too."""
    effects = case.leading.fit.effects
    if case.is_settled or not effects or not all(isinstance(effect, OF_ONE_RUN) for effect in effects):
        return None
    with_it, without = (rms(one.residual) for one in (case.leading.fit, case.contest.base.fit))
    share = sum(rows.any() for rows in case.problem.train)
    lost = np.sqrt(max(without**2 - with_it**2, 0.0) * share) / max(case.problem.highest_floor, 1e-15)
    if lost > LEAST_OF_ONE_RUN:
        return None
    return case.led_by(case.contest.base)


def one_run_that_differs_is_named(case: JointCase) -> Case | None:
    """Rule: where unseen rows are missed, it is asked whether another setting or label of one run explains all of it.

    Three quarters of the run are fitted with all others; the rest of it certifies, and every other run must be foretold.
    The fit is drawn by such a run, so that others may be missed too: those missed most are asked in turn.
    """
    problem = case.problem
    if case.names or not case.is_refused_by_unseen_rows or len(problem.runs) < FEWEST_RUNS_TO_DIFFER:
        return None
    if case.law is not None:
        case = replace(case.led_by(case.contest.base), law=None, told=None)
    errors = {name: one.error for name, one in case.strangers.items()}
    if not case.certified.passed:
        errors |= dict.fromkeys(case.kept_back.runs, case.certified.error)
    suspects = sorted((name for name in errors if errors[name] > LEAST_OF_ONE_RUN), key=lambda name: -errors[name])
    asked = (_blamed(case, name) for name in suspects[:_MOST_SUSPECTS])
    held = [one for one in asked if one is not None and one.certified.passed and not one.strangers]
    return min(held, key=lambda one: round(one.certified.error, 1), default=None)


def _blamed(case: JointCase, name: str) -> JointCase | None:
    """Return the case with one run blamed, led by what of it explains best the rest of that run."""
    problem = case.problem
    number = next(index for index, run in enumerate(problem.runs) if run.name == name)
    rows = rows_of_one_run(problem.runs, number)
    known = problem.only(rows.fitted)
    starts = (
        RunDiffers(run=float(number), gain=1.05),
        *(BendingLengthLabel(float(number), by) for by in (4.0, -4.0)),
        *lost_steps(known, number),
    )
    found = []
    for effect in starts:
        if effect.id not in problem.concealed:
            fitted = fit(known, (effect,), case.chosen_fit.coordinates)
            found.append((foretold(known, fitted, rows.rows).error, len(effect.parameters), effect.id, fitted))
    if not found:
        return None
    found.sort(key=lambda one: (round(one[0], 1), *one[1:3]))
    tried = tuple(hypothesis(known, one[3]) for one in found)
    contest = replace(case.contest, leading=tried[0], tried=(case.contest.base, *tried))
    return replace(case, problem=known, kept_back=rows, contest=contest)


def names_that_unseen_rows_do_not_want_are_dropped(case: JointCase) -> Case | None:
    """Rule: names stand only where unseen rows that want something are foretold better with them than without."""
    if not (case.names and case.has_laws and case.kept_back.any) or case.is_stale or case.kept_back.rule == ONE_RUN:
        return None
    alone = foretold(case.known, case.refitted_base, case.kept_back.rows)
    if alone.error > LEAST_MISFIT or alone.error >= HARM * case.certified.error:
        return None
    return replace(case.led_by(case.contest.base), law=None, told=None, is_closed=True)


def names_that_are_too_unsure_give_way(case: JointCase) -> Case | Ruling | None:
    """Rule: names that are more likely wrong than a wrong name is worth give way to a law, or to none.

    Where unseen rows want nothing, they give way to the base model.
    """
    if not case.names or case.against is None or case.certainty >= NAMED_FROM:
        return None
    alone = foretold(case.known, case.refitted_base, case.kept_back.rows)
    if alone.count and alone.error <= LEAST_MISFIT:
        return replace(case.led_by(case.contest.base), law=None, told=None, is_closed=True)
    world = case.asked
    why = f"{' + '.join(case.names)} would be right with {100.0 * case.certainty:.0f} % only"
    for law in world.instead.laws[:1]:
        leading = hypothesis(case.problem, law.fit)
        changed = replace(case.led_by(leading), law=law, told=world, remark=why)
        as_good = changed.certified.error <= HARM * case.certified.error
        if as_good and world.carries_over(law, case.contest.base.fit) and not changed.is_refused_by_unseen_rows:
            return changed
    return Ruling("unexplained", f"{why}; {case.explains_words}; the model saved holds them", keeps_model=True)


def one_factor_of_both_moduli_is_the_load_cell(case: JointCase) -> Case | None:
    """Rule: where nothing is named but both moduli are off by one factor, the load cell reads in another scale."""
    if case.names or case.law is not None or case.is_stale or case.is_refused_by_unseen_rows:
        return None
    base = case.contest.base.fit
    found = load_cell_in_another_scale(case.problem, base)
    if found is None:
        return None
    named = hypothesis(case.problem, found)
    contest = replace(case.contest, leading=named, tried=(case.contest.base, named))
    return replace(case, contest=contest, remark=same_factor_words(case.problem, base), has_laws=False)


def unseen_rows_decide(case: JointCase) -> Ruling | None:
    """Rule: what unseen rows contradict is not said, be it a name or that nothing is left out."""
    return Ruling("unexplained", case.missed_words) if case.is_refused_by_unseen_rows else None


JOINT_RULES: tuple[VerdictRule, ...] = (
    what_does_not_carry_over_is_dropped,
    what_is_redundant_is_dropped,
    what_vanished_is_dropped,
    one_run_is_not_blamed_for_slow_noise,
    laws_without_a_name_compete,
    a_law_that_unseen_rows_do_not_show_is_dropped,
    one_run_that_differs_is_named,
    frames_that_repeat_are_named,
    one_factor_of_both_moduli_is_the_load_cell,
    names_that_unseen_rows_do_not_want_are_dropped,
    a_law_without_a_name_leads,
    structure_is_left,
    unseen_rows_decide,
    nothing_is_named,
    names_that_are_too_unsure_give_way,
    first_effect_is_disputed,
    names_explain,
)
