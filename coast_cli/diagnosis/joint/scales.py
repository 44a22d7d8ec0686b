"""How far a recording reaches: what the starts of effects, and the widths of their priors, are multiples of."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from coast_cli.effects.effect import Scale
from coast_cli.units import MEGAPASCAL, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem


def scales_of(problem: JointProblem) -> dict[Scale, float]:
    """Return the largest curvature, strain, tension and so on that a recording reaches at configured values."""
    spans = [float(np.ptp(run.time)) for run in problem.runs if run.time is not None and run.time.size]
    own = _of_device(problem) if problem.device is not None else _of_segment(problem)
    response = max(float(np.nanmax(np.abs(run.response), initial=0.0)) for run in problem.fitted_runs)
    return {
        "": 1.0,
        "curvature": response,
        "strain": 0.0,
        "stress": 0.0,
        "closure": 0.0,
        "tension": 0.0,
        "duration": max(spans, default=1.0),
        "response": response,
        "stroke": max(float(np.ptp(run.drive)) / MILLIMETRE for run in problem.runs),
        "runs": float(len(problem.runs)),
        "period": 10.0 * problem.swing.period if problem.swing is not None else 1.0,
        "compliance": 1.0,
        **own,
    }


def _of_segment(problem: JointProblem) -> dict[Scale, float]:
    from coast_cli.effects.stations import stations_for

    curvature, strain, closure, tension = 1e-9, 1e-9, 1e-9, 1e-9
    stiffest = max(joint.youngs_modulus for joint in problem.joints.values())
    predictions = problem.predict(problem.configured(), ())
    for run, prediction in zip(problem.runs, predictions, strict=True):
        if run not in problem.fitted_runs:
            continue
        joint = problem.joints[run.pair]
        stations = stations_for(joint, (), float(run.bending_length[0]), run.kind, run.response.shape[1])
        divisor = {
            "curvature": 1.0,
            "bend": float(run.bending_length.mean()),
            "notch": float(stations.pitch.mean()),
        }
        seen = float(np.nanmax(np.abs(run.response), initial=0.0)) / divisor[run.kind]
        curvature = max(curvature, seen)
        strain = max(strain, seen * float(stations.segment.strain_per_curvature.mean()))
        closure = max(closure, seen / float(stations.segment.closing_curvature.mean()))
        measured = run.tension if run.tension is not None else prediction.tension
        tension = max(tension, float(np.nanmax(measured, initial=0.0)))
    stress = strain * stiffest / MEGAPASCAL
    return {"curvature": curvature, "strain": strain, "stress": stress, "closure": closure, "tension": tension}


def _of_device(problem: JointProblem) -> dict[Scale, float]:
    unit = MILLIMETRE if problem.runs[0].stroke is not None else 1.0
    span = max(float(np.ptp(run.drive)) for run in problem.runs) / unit
    loads = [load for run in problem.runs if (load := run.carried) is not None]
    carried = float(np.ptp(np.concatenate(loads))) if loads else 1.0
    return {"stroke": span, "compliance": span / max(carried, 1e-12)}
