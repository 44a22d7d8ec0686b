"""Diagnose a joint recording: is there a mismatch, where, what was left out, the model with it, and is that better."""

from __future__ import annotations

from collections.abc import Sequence
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
    certifying = hold_out(runs, named_hold_out)
    found = _judged(config, runs, certifying, most_effects, without, noise)
    if not isinstance(found, Diagnosis):
        case, ruling = found
        if case.is_refused_by_unseen_rows and certifying.chosen:
            # The rows kept back may be what differs: with others kept back in their place that can be seen.
            other = hold_out_others(runs, certifying)
            again = _judged(config, runs, other, most_effects, without, noise) if other is not None else None
            if isinstance(again, tuple) and not again[0].is_refused_by_unseen_rows:
                case, ruling = again
        found = case.diagnosis(ruling)
    return found


def _judged(
    config: Config,
    runs: Sequence[JointRun],
    certifying: HoldOut,
    most_effects: int,
    without: Sequence[str],
    noise: float | None,
) -> tuple[JointCase, Ruling] | Diagnosis:
    """Return the judged case, or the whole answer where the recording cannot decide."""
    choosing = rows_that_choose(runs, certifying)
    fitted = [~(one | other) for one, other in zip(certifying.rows, choosing.rows, strict=True)]
    known = build_joint_problem(config, runs, certifying.rows, without=without, noise=noise)
    problem = known.only(fitted)
    reason = _insufficient(problem)
    if reason:
        kind = problem.runs[0].kind
        return Diagnosis(
            "insufficient", reason, to_unit(kind, problem.noise), UNITS[kind], next_recording=FIRST_RECORDING
        )
    start = JointCase(
        problem, certifying, run_contest(problem, most_effects), choosing=choosing, has_laws=most_effects > 0
    )
    case, ruling = judge(start, JOINT_RULES)
    return case, ruling


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
