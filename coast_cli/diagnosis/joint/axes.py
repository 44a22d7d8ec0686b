"""The axes along which the mismatch of a joint is sought: drive, direction, length, time, run, notch and so on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.locate import Region, Samples, locate
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.evidence import drive_speed
from coast_cli.units import MILLIMETRE


def locate_joint(problem: JointProblem, base: Fit, memory: float | None = None) -> tuple[Region, ...]:
    """Return the regions that hold the base model's excess error, largest share first; none where it agrees.

    Args:
        memory: lag-one correlation of the noise, as far as it is known; that of the base model's residual by default.
    """
    known = base.evidence.memory if memory is None else memory
    return locate(samples_of(problem, base), problem.noise, min(known, problem.noise_estimate.correlation))


def samples_of(problem: JointProblem, base: Fit) -> Samples:
    """Return every fitted sample with its place along each axis of a joint's recording."""
    predictions = problem.predict(base.coordinates, base.effects)
    continuous: dict[str, list[FloatArray]] = {}
    discrete: dict[str, list[NDArray[np.str_]]] = {}
    for run_index, column, rows in problem.sequences:
        run = problem.runs[run_index]
        values: dict[str, FloatArray] = {}
        if problem.device is None:
            values["bending_length"] = run.bending_length / MILLIMETRE
            values["curvature"] = _curvature(problem, run_index, predictions[run_index].response[:, column])
        elif run.carried is not None:
            values["load"] = run.carried
        if run.stroke is not None:
            values["stroke"] = run.stroke / MILLIMETRE
        if run.tension is not None:
            values["tension"] = run.tension
        if run.time is not None:
            values["time"] = run.time
            values["rate"] = drive_speed(run) / (MILLIMETRE if run.stroke is not None else 1.0)
        for axis, value in values.items():
            continuous.setdefault(axis, []).append(value[rows])
        names = {
            "direction": np.where(run.direction < 0, "release", "load"),
            "run": np.full(len(run), run.name),
            "pair": np.full(len(run), run.pair),
            "cycle": run.branches.cycle.astype(str),
            "notch": np.full(len(run), str(column + 1)),
        }
        for axis, name in names.items():
            discrete.setdefault(axis, []).append(name[rows])
    size, spread = problem.observed.size, problem.space(base.effects).spread
    return Samples(
        residual=base.residual,
        directions=-base.jacobian[:size, : base.coordinates.size] * spread[: base.coordinates.size],
        continuous={axis: joined for axis, v in continuous.items() if (joined := np.concatenate(v)).size == size},
        discrete={axis: np.concatenate(v) for axis, v in discrete.items()},
    )


def _curvature(problem: JointProblem, index: int, response: FloatArray) -> FloatArray:
    """Return the curvature (1/m) that a predicted response of a run stands for."""
    run = problem.runs[index]
    if run.kind == "bend":
        return response / run.bending_length
    return response / float(problem.joints[run.pair].pitch) if run.kind == "notch" else response
