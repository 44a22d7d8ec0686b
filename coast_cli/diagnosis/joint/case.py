"""A joint's contest to be judged: what unseen rows say of it, what is left over, and the answer under a ruling."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from coast_cli.diagnosis.answer import Errors, Named, SideBySide, Test
from coast_cli.diagnosis.curves import JointCurve
from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.holdout import HoldOut
from coast_cli.diagnosis.joint.axes import locate_joint
from coast_cli.diagnosis.joint.errors import UNITS, errors_of, held_out_spread, to_unit
from coast_cli.diagnosis.joint.holdout import ONE_RUN
from coast_cli.diagnosis.joint.odds import Against
from coast_cli.diagnosis.joint.openworld import OpenWorld
from coast_cli.diagnosis.joint.problem import CONFIG_KEYS, JointProblem
from coast_cli.diagnosis.joint.structure import Structure, find_structure
from coast_cli.diagnosis.joint.told import display_of, known_of, laws_of, parting
from coast_cli.diagnosis.joint.unseen import foretold, runs_against_the_rest, strangers
from coast_cli.diagnosis.joint.witness import strained
from coast_cli.diagnosis.joint.words import (
    SAME_SWEEP_AGAIN,
    device_limits,
    joint_limits,
    loop_note,
    one_length,
    plateau_note,
    untested,
)
from coast_cli.diagnosis.judge import (
    SOMETHING_ELSE,
    Case,
    Leftover,
    Ruling,
)
from coast_cli.diagnosis.locate import Region
from coast_cli.diagnosis.space import Booleans
from coast_cli.diagnosis.spread import Spread, effect_keys, spread_of
from coast_cli.diagnosis.thresholds import (
    ABOVE_NOISE,
    FAR_ABOVE_NOISE,
    FLOOR_DOUBT,
    HARM,
    MAX_HELD_OUT_SHARE,
    MAX_UNEXPLAINED_SHARE,
    MAX_UNEXPLAINED_SHARE_OF_DEVICES,
    MAX_UNEXPLAINED_SHARE_OF_SETS,
    REFUSED_NAMES,
    REPEATS,
    SUREST,
)
from coast_cli.diagnosis.unnamed.search import LawFit
from coast_cli.diagnosis.unnamed.words import Description, describe
from coast_cli.diagnosis.unseen import Unseen
from coast_cli.effects.library.frozen_frames import FrozenFrames
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class JointCase(Case):
    """A joint's contest to be judged.

    Attributes:
        choosing: rows that choose among hypotheses; ``kept_back`` are those that certify the choice.
        law: a law without a name that leads, or stands beside the names; None where there is none.
        told: what the law competed with. has_laws: whether laws without a name compete at all. is_closed: whether they did
            compete, and unseen rows did not show one.
        is_stale: whether frames that repeat were named.
    """

    problem: JointProblem
    choosing: HoldOut = field(kw_only=True)
    law: LawFit | None = field(default=None, kw_only=True)
    told: OpenWorld | None = field(default=None, kw_only=True)
    has_laws: bool = field(default=True, kw_only=True)
    is_closed: bool = field(default=False, kw_only=True)
    is_stale: bool = field(default=False, kw_only=True)

    agrees = "the model as configured agrees with the recording within its noise"
    alike = "several sets of effects explain the recording alike"

    @property
    def unit(self) -> str:  # type: ignore[override]
        """Unit of the response in tables."""
        return UNITS[self.problem.runs[0].kind]

    @property
    def floor(self) -> float:
        """The noise, SI: to say that something unknown is there, all slow noise is granted, as for a name."""
        return self.problem.floor if self.leading.ids else self.problem.highest_floor

    @property
    def allowed_share(self) -> float:
        """Share of what was explained that may be left over; less of a set, which may draw anything."""
        if self.problem.device is not None:
            return MAX_UNEXPLAINED_SHARE_OF_DEVICES
        single = len(self.leading.ids) < 2 or self.problem.runs[0].kind == "notch"
        return MAX_UNEXPLAINED_SHARE if single else MAX_UNEXPLAINED_SHARE_OF_SETS

    @cached_property
    def structure(self) -> Structure:
        """Structure that the leading set leaves."""
        return find_structure(self.problem, self.leading.fit)

    @cached_property
    def open_world(self) -> OpenWorld:
        """Names against laws without a name."""
        return OpenWorld(self.problem, self.problem.only(self.choosing.rows), self.contest)

    @property
    def is_settled(self) -> bool:
        """Whether a rule has put something in the place of what the contest of names led by."""
        asked = self.kept_back.rule == ONE_RUN
        return self.law is not None or self.is_stale or asked

    @property
    def names(self) -> tuple[str, ...]:
        """Ids of the leading set that have a name."""
        return tuple(e.id for e in self.leading.fit.effects if not isinstance(e, UnnamedLaw))

    @cached_property
    def described(self) -> Description | None:
        """What is said of the law that leads or stands beside the names; None where there is none."""
        if self.law is None or self.told is None or len(self.names) == len(self.leading.ids):
            return None
        nearest = () if self.names else self.told.nearest
        laws = [laws_of(one.fit.effects) for one in self.told.alike(self.law)]
        return describe(laws, display_of(self.problem), nearest)

    def told_law(self, final: Fit) -> Description | None:
        """Return all that is said of the law: as it is saved, or as it led where it explains only a part."""
        if self.described is None or self.law is None or self.told is None:
            return None
        nearest = () if self.names else self.told.nearest
        others = [laws_of(one.fit.effects) for one in self.told.alike(self.law)[1:]]
        before, after = self.comparison.refitted.held_out, self.comparison.with_effects.held_out
        level = max(self.in_unit(self.problem.noise_estimate.level), 1e-300)
        errors = None if before is None or after is None else (before / level, after / level)
        shown = final if laws_of(final.effects) else self.leading.fit
        known = known_of(self.problem, shown, errors)
        return describe([laws_of(shown.effects), *others], display_of(self.problem), nearest, known)

    @property
    def response_noise(self) -> float:
        """The noise beside which errors stand, in the unit of tables."""
        return self.in_unit(self.problem.noise_estimate.level)

    @property
    def missed_words(self) -> str:
        """Which unseen rows are missed, and by how much."""
        parts = []
        if not self.certified.passed:
            rows = f"run {', '.join(self.kept_back.runs)}" if self.kept_back.runs else "rows that were not fitted"
            parts.append(f"{rows}: {self.certified.error:.1f} noise widths, {self.certified.allowed:.1f} allowed")
        for name, unseen in sorted(self.strangers.items(), key=lambda item: -item[1].error):
            parts.append(f"run {name}, foretold by the others: {unseen.error:.1f}, {unseen.allowed:.1f} allowed")
        what = " + ".join(self.names) or "the base model"
        return f"{what} does not foretell what it was not fitted to ({'; '.join(parts[:3])})"

    @cached_property
    def certainty(self) -> float:
        """Probability that the names, or one of their rivals, are right."""
        if self.kept_back.rule == ONE_RUN:
            return float(SUREST)  # a part of that run, and every other run, certify what is said of it
        return super().certainty if self.against is None else self.against.certainty

    @cached_property
    def asked(self) -> OpenWorld:
        """The names that lead, or led before a law took their place, against laws without a name."""
        return self.told or self.open_world

    @cached_property
    def against(self) -> Against | None:
        """What speaks against those names; None where there are none, or no law competes with them.

        The odds are set on joints of tubes, so that of other devices nothing is said by them.
        """
        world = self.asked
        names, base = world.contest.leading.fit, self.contest.base.fit
        if not self.has_laws or not names.effects or self.problem.device is not None:
            return None
        if self.is_stale or self.kept_back.rule == ONE_RUN:
            return None
        if self.problem.device is not None:  # whose line leaves more than noise: the odds were set on tubes
            return None
        left, before = world.left_over(names), world.left_over(base)
        laws = () if world.is_complete else world.instead.laws[:1]
        gain = max((world.gain(law, names) for law in laws), default=0.0)
        # Where not even laws reach the noise, what is left is counted by what they leave.
        reach = max((1.0, *(world.left_over(law.fit) for law in laws)))
        certified = self.certified
        if self.law is not None:
            alone = fit(self.known, names.effects, names.coordinates, steps=0)
            certified = foretold(self.known, alone, self.kept_back.rows)
        unseen = certified.error / certified.allowed / reach if self.kept_back.any else 0.5
        return Against(
            left=float(np.log1p(left / reach)),
            share=min(left / max(before, 1e-9), 1.0),
            unseen=max(unseen - 0.5, 0.0),
            asked=float(-np.log10(world.asked.p_value)),
            gain=float(np.log1p(max(gain, 0.0))),
            beside=float(world.added is not None),
            names=float(len(names.effects) > 1),
            doubt=min(self.problem.noise_estimate.log_level_std, float(FLOOR_DOUBT)),
        )

    @property
    def evidence(self) -> dict[str, float]:
        """What speaks against the leading names, figure by figure; nothing where none lead."""
        return {} if self.against is None else self.against.table()

    def probabilities(self, ruling: Ruling) -> dict[str, float]:
        """Return the probability of each name; where laws alone explain, of the names that come nearest."""
        if self.law is None or self.told is None:
            found = super().probabilities(ruling)
            return found | {FrozenFrames.id: float(SUREST)} if self.is_stale else found
        if self.against is not None or (self.problem.device is not None and self.names):
            chance = min(self.certainty, float(SUREST))
            return dict.fromkeys(self.told.contest.leading.ids, chance) | {SOMETHING_ELSE: 1.0 - chance}
        nearest = [identifier for identifier, _ in self.told.nearest]
        chance = float(REFUSED_NAMES) / max(len(nearest), 1)
        return dict.fromkeys(nearest, chance) | {SOMETHING_ELSE: 1.0 - chance * len(nearest)}

    def believed(self, ruling: Ruling) -> float:
        """Return the probability that the leading names, or their rivals, are right."""
        return self.certainty if self.against is not None else super().believed(ruling)

    def tried_in_vain(self, ruling: Ruling) -> tuple[str, ...]:
        """Return the ids of names that were not good enough, also where a law took their place."""
        if self.law is not None and self.told is not None and not self.names:
            return self.told.contest.leading.ids
        return super().tried_in_vain(ruling)

    @property
    def tests(self) -> tuple[Test, ...]:
        """Unseen rows, every run against the others, and whether noise alone would ask as loudly for a law."""
        found = []
        if self.kept_back.any:
            found.append(Test("rows_not_seen", self.certified.p_value, self.certified.passed))
        if self.against_the_rest:
            least = min(one.p_value for one in self.against_the_rest.values())
            found.append(Test("every_run_against_the_others", least, not self.strangers))
        if self.has_laws and self.told is None and not self.is_closed:
            world = self.open_world
            found.append(Test("no_law_without_a_name_is_asked_for", world.asked.p_value, world.is_complete))
        return tuple(found)

    @cached_property
    def against_the_rest(self) -> dict[str, Unseen]:
        """How well the other runs foretell each fitted run, to first order."""
        return runs_against_the_rest(self.known, self.chosen_fit)

    def named(self, ruling: Ruling, final: Fit) -> tuple[Named, ...]:
        """Return the leading effects that have a name."""
        return tuple(one for one in super().named(ruling, final) if one.id in self.names)

    @cached_property
    def known(self) -> JointProblem:
        """The problem with the rows that were fitted and those that chose."""
        return self.problem.only(self.kept_back.fitted)

    @cached_property
    def chosen_fit(self) -> Fit:
        """The leading set, fitted to all rows that are known."""
        return fit(self.known, self.leading.fit.effects, self.leading.fit.coordinates, steps=0)

    @cached_property
    def certified(self) -> Unseen:
        """How the leading set foretells the certifying rows."""
        return foretold(self.known, self.chosen_fit, self.kept_back.rows)

    @cached_property
    def strangers(self) -> dict[str, Unseen]:
        """Runs that the others do not foretell, by name."""
        return strangers(self.known, self.chosen_fit, self.contest.base.fit, self.against_the_rest)

    @cached_property
    def is_refused_by_unseen_rows(self) -> bool:
        """Whether unseen rows contradict the answer.

        Where nothing is named, the certifying rows and every run against the others lie within what noise and doubt allow.
        A name may leave a part of what it explains, which is said.
        """
        if not self.names:
            return not self.certified.passed or bool(self.strangers)
        if self.certified.passed:
            return False
        before = foretold(self.known, self.refitted_base, self.kept_back.rows)
        return self.certified.error > MAX_UNEXPLAINED_SHARE * before.error

    @cached_property
    def refitted_base(self) -> Fit:
        """The base model, fitted to all rows that are known."""
        return fit(self.known, (), self.contest.base.fit.coordinates)

    def final(self, fitted: Fit) -> Fit:
        """Return the fit on every row, unless the user named runs that no fit may see."""
        if self.kept_back.chosen:
            return super().final(fitted)
        return self.chosen_fit if fitted is self.leading.fit else self.refitted_base

    def comparison_of(self, fitted: Fit) -> SideBySide:
        """Return errors as configured, refitted and with a fit's effects, on the certifying rows."""
        chosen = self.chosen_fit
        if fitted is not self.leading.fit:
            chosen = fit(self.known, fitted.effects, fitted.coordinates, steps=0)
        return self.side_by_side(self.known, self.refitted_base, chosen)

    def missed(self, fitted: Fit) -> float | None:
        """Return the error on the choosing rows, in the unit of tables; None where no rows choose."""
        if not self.choosing.any:
            return None
        return self.errors(fitted.coordinates, fitted.effects, self.choosing.rows).response

    def is_named(self, ruling: Ruling) -> bool:
        """Return whether the leading set is named."""
        return super().is_named(ruling) and ruling.verdict != "unnamed"

    def in_unit(self, value: float) -> float:
        """Return an SI response in the unit of tables."""
        return to_unit(self.problem.runs[0].kind, value)

    def errors(self, coordinates: FloatArray, effects: Sequence[Any], rows: Sequence[Booleans]) -> Errors:
        """Return the errors of a model on some rows."""
        return errors_of(self.problem, coordinates, effects, rows)

    def _leftover(self) -> Leftover:
        size = excess(
            self.leading.fit, self.floor, self.structure.repeats, ABOVE_NOISE if self.leading.ids else FAR_ABOVE_NOISE
        )
        kept = "needs direction or history" if self.structure.memory else "needs neither direction nor history"
        repeats = f"{100 * max(self.structure.repeats, 0.0):.0f} % of it repeats from run to run"
        unit = {"curvature": "1/m", "position": "mm", "force": "N"}.get(self.problem.runs[0].kind, "degrees")
        words = f"{self.in_unit(size):.3g} {unit} is left that no effect of the catalogue explains"
        return Leftover(size, f"{words}; {repeats}, and it {kept}")

    def noise_level(self, ruling: Ruling) -> float:
        """Return the noise that the recording shows, SI."""
        return self.problem.noise_estimate.level

    def where(self, ruling: Ruling, final: Fit) -> tuple[Region, ...]:
        """Return the regions that hold the base model's excess error."""
        base = self.contest.base.fit if self.kept_back.rule != ONE_RUN else self.refitted_base
        return locate_joint(
            self.problem if self.kept_back.rule != ONE_RUN else self.known, base, self.leading.fit.evidence.memory
        )

    def curves(self, final: Fit) -> tuple[JointCurve, ...]:
        """Return what the refitted base and the corrected model predict of every run."""
        before = self.problem.predict(self.contest.base.fit.coordinates, ())
        after = self.problem.predict(final.coordinates, final.effects)
        runs = zip(self.problem.runs, before, after, strict=True)
        return tuple(JointCurve(run, old.response, new.response) for run, old, new in runs)

    def model_spread(self, final: Fit) -> Spread | None:
        """Return how sure the numbers of the saved model are."""
        base = self.problem.base
        values = self.problem.values(final.coordinates)
        keys = [CONFIG_KEYS[parameter.name] for parameter in base] + effect_keys(final.effects)
        scale = [values[parameter.name] if parameter.logarithmic else 1.0 for parameter in base]
        return spread_of(keys, [*scale, *[1.0] * (len(keys) - len(scale))], final.covariance)

    def carries_over(self, fitted: Fit) -> bool:
        """Return whether most of the improvement is there on rows that were not fitted.

        Rows that the base model predicts within the noise cannot show an improvement, only harm. Elsewhere the error may
        be as large as the noise and what the fit does not know of its parameters make it.
        """
        before, after = self.missed(self.contest.base.fit), self.missed(fitted)
        if before is None or after is None:
            return True
        within = ABOVE_NOISE * self.in_unit(self.floor)
        if before < within:
            return after < HARM * before
        if after < before and (after < within or after < MAX_HELD_OUT_SHARE * before):
            return True
        unsure = held_out_spread(self.problem, fitted, self.choosing.rows)
        return after < before and after < np.hypot(within, ABOVE_NOISE * unsure)

    def next_recording(self, ruling: Ruling) -> str:
        """Return what would settle what is open, in bench words."""
        if ruling.verdict == "unnamed" and self.law is not None:
            alike = () if self.told is None else self.told.alike(self.law)
            return parting(self.problem, [one.fit for one in alike]) or self.law.law.decided_by
        if self.rivals and self.described is None and self.problem.device is None:
            from coast_cli.diagnosis.joint.plan import next_recording

            proposals = next_recording(self.problem, [self.leading.fit, *(rival.fit for rival in self.rivals[:3])])
            if proposals and proposals[0].gain > 0.0:
                return f"{proposals[0].words} (expected to add {proposals[0].gain:.0f} nats between the closest two)"
            return self.first_effect().decided_by
        if ruling.verdict == "unexplained":
            return SAME_SWEEP_AGAIN
        return self.first_effect().decided_by if self.is_named(ruling) else untested(self.problem)

    def notes(self, ruling: Ruling, final: Fit) -> tuple[str, ...]:
        """Return what joint_limits the answer, a sentence each."""
        leading = self.leading.fit
        notes = [*joint_limits(self.problem), *loop_note(self.problem, leading.effects), *one_length(self.problem)]
        notes += device_limits(self.problem)
        if not self.kept_back.runs:
            notes.append(f"held out: {self.kept_back.rule}")
        if self.leading.ids and not self.choosing.any:
            notes.append("no run could be spared to choose among hypotheses: those that were fitted chose too")
        touching = zip(self.problem.base, leading.at_bound, strict=False)
        notes.extend(f"{parameter.name} is on its bound" for parameter, bound in touching if bound)
        notes.extend(plateau_note(self.problem, leading) if self.is_named(ruling) else [])
        notes.extend(strained(self.problem, leading))
        if not leading.converged:
            notes.append("the fit was still moving when it stopped")
        return tuple(notes)


def excess(fitted: Fit, floor: float, repeats: float, margin: float) -> float:
    """Return the RMS of what is neither model nor noise, SI; a residual within ``margin`` of the floor is noise."""
    above = np.sqrt(max(fitted.rmse**2 - floor**2, 0.0)) if fitted.rmse > margin * floor else 0.0
    repeated = fitted.rmse * np.sqrt(max(repeats, 0.0)) if repeats > REPEATS else 0.0
    return float(max(above, repeated))
