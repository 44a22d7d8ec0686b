"""What the refitted base model and the corrected model predict, run by run: for plots and reports."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.recordings.model import JointRun, Recordings
    from coast_cli.spec.config import Config

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curve:
    """A run with what both models expect of it, [n, k] in the run's SI unit."""

    run: JointRun
    base: Floats
    corrected: Floats


def curves(config: Config, recordings: Recordings, diagnosis: Diagnosis) -> list[Curve]:
    """Return the curves of all joint runs in order; none where nothing was fitted, or of shapes.

    The base is refitted here, on the runs that were not held out.
    """
    from coast_cli.diagnosis.fit import fit
    from coast_cli.diagnosis.problem import build_problem

    if recordings.joint is None or diagnosis.comparison is None:
        return []
    runs = recordings.joint.runs
    held = [np.full(len(run), run.name in diagnosis.comparison.held_out_runs) for run in runs]
    problem = build_problem(config, runs, held)
    base = problem.predict(fit(problem).coordinates, ())
    wanted = [(p, diagnosis.model_parameters.get(p.name, p.value)) for p in problem.base]
    coordinates = np.array([np.log(value) if p.logarithmic else value for p, value in wanted])
    corrected = problem.predict(coordinates, diagnosis.model_effects)
    return [
        Curve(run, before.response, after.response) for run, before, after in zip(runs, base, corrected, strict=True)
    ]
