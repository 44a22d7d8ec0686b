"""Diagnose a joint recording: is there a mismatch, where, what was left out, the model with it, and is that better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.answer import Diagnosis
from coast_cli.diagnosis.contest import run_contest
from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.holdout import HoldOut
from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.case import JointCase
from coast_cli.diagnosis.joint.errors import UNITS, to_unit
from coast_cli.diagnosis.joint.holdout import hold_out, hold_out_others, rows_that_choose
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.joint.rules import JOINT_RULES
from coast_cli.diagnosis.joint.witness import off_data_sheet
from coast_cli.diagnosis.joint.words import (
    FIRST_RECORDING,
)
from coast_cli.diagnosis.judge import (
    Ruling,
    judge,
)
from coast_cli.diagnosis.thresholds import (
    FEWEST_SAMPLES,
    MAX_UNEXPLAINED_FRACTION,
    SAMPLES_A_PARAMETER,
    STILL_NOISE,
)

if TYPE_CHECKING:
    from coast_cli.recordings.model import JointRun
    from coast_cli.spec.config import Config


def diagnose_joint(
    config: Config,
    runs: Sequence[JointRun],
    *,
    named_hold_out: Sequence[str] = (),
    most_effects: int = 5,
    without: Sequence[str] = (),
    noise: float | None = None,
) -> Diagnosis:
    """Return the diagnosis of a joint recording.

    Args:
        config: the model that disagrees, its corrections included.
        runs: of one kind of response. named_hold_out: runs that no fit may see.
        most_effects: largest set that is tried. without: ids of effects that are neither named nor rivals.
        noise: of the response, SI, where it is known.

    Raises:
        BadInput: a run to hold out does not exist.
    """
    asked = _Question(config, runs, most_effects, without, noise)
    certifying = hold_out(runs, named_hold_out)
    found = asked.judged(certifying)
    if isinstance(found, Diagnosis):
        return found
    case, ruling = found
    if case.is_refused_by_unseen_rows and certifying.chosen:
        # The rows kept back may be what differs: with others kept back in their place that can be seen.
        other = hold_out_others(runs, certifying)
        again = asked.judged(other) if other is not None else None
        if isinstance(again, tuple) and not again[0].is_refused_by_unseen_rows:
            case, ruling = again
    off = off_data_sheet(case.problem, case.contest.base.fit) if ruling.verdict == "parameters" else ""
    again = asked.judged(certifying, trusting=True) if off else None
    if isinstance(again, tuple) and again[1].verdict not in ("agrees", "parameters", "unexplained"):
        answer = again[0].diagnosis(again[1])
        return replace(answer, reason=f"{answer.reason}; without it {off}")
    return case.diagnosis(ruling)


@dataclass(frozen=True, slots=True)
class _Question:
    """What was asked: a model, runs, how large sets may be, what is concealed, and the noise where it is known, SI."""

    config: Config
    runs: Sequence[JointRun]
    most_effects: int
    without: Sequence[str]
    noise: float | None

    def judged(self, certifying: HoldOut, *, trusting: bool = False) -> tuple[JointCase, Ruling] | Diagnosis:
        """Return the judged case, or the whole answer where the recording cannot decide.

        Args:
            certifying: rows that no fit sees. trusting: whether numbers of data sheets are held.
        """
        choosing = rows_that_choose(self.runs, certifying)
        fitted = [~(one | other) for one, other in zip(certifying.rows, choosing.rows, strict=True)]
        known = build_joint_problem(
            self.config, self.runs, certifying.rows, without=self.without, noise=self.noise, trusting=trusting
        )
        problem = known.only(fitted)
        reason = _insufficient(problem)
        if reason:
            kind = problem.runs[0].kind
            return Diagnosis(
                "insufficient", reason, to_unit(kind, problem.noise), UNITS[kind], next_recording=FIRST_RECORDING
            )
        contest = run_contest(problem, self.most_effects)
        start = JointCase(problem, certifying, contest, choosing=choosing, has_laws=self.most_effects > 0)
        return judge(start, JOINT_RULES)


def _insufficient(problem: JointProblem) -> str:
    """Return why the recording cannot decide anything, or an empty text."""
    if problem.observed.size < max(FEWEST_SAMPLES, SAMPLES_A_PARAMETER * len(problem.base)):
        return f"only {problem.observed.size} samples can be fitted"
    spans = [float(np.ptp(run.drive)) for run in problem.runs]
    if max(spans) <= 0.0:
        return "the drive never moves"
    moved = float(np.std(problem.observed))
    if moved <= STILL_NOISE * problem.floor and fit(problem).rmse > MAX_UNEXPLAINED_FRACTION * moved:
        return "the response never moves by more than its noise"
    return ""
