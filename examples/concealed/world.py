"""One robot with one thing left out, and the noiseless playback of a whole protocol on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from examples.concealed.camera import observe
from examples.concealed.design import Joint, Robot
from examples.concealed.faults import load_cell, seen_by_camera, shown_frames
from examples.concealed.mechanism import Effects, simulate
from examples.concealed.protocol import Protocol, RunPlan
from examples.concealed.refit import Rows

Array = NDArray[np.float64]


@dataclass
class World:
    """Everything that stays the same when a case is recorded again with another protocol."""

    robot: Robot
    actual: Robot
    effects: dict[str, dict[str, object]]
    noise: dict[str, object]
    sigma: float
    curvature: float
    protocol: Protocol
    streams: list[int] = field(default_factory=list)
    held_out: int | None = None
    twins: tuple[str, ...] = ()


@dataclass(frozen=True)
class Played:
    """Noiseless rows of all runs; `frames` is the row, of all, whose frame each row shows."""

    rows: Rows
    time: Array
    tension: Array
    response: Array
    frames: NDArray[np.intp]


def drive_range(joint: Joint, plan: RunPlan, curvature: float, protocol: Protocol, slack: float) -> tuple[float, float]:
    """Smallest and largest drive of a run (m, or N without a tendon)."""
    top, tension = joint.stroke(np.array(curvature), plan.length)
    if joint.tendon_radius == 0:
        return 0.02 * float(tension), float(tension)
    span = float(top) - joint.deadband
    low = joint.deadband - slack * span if protocol.slack_start else joint.deadband + slack * span / 2
    return max(low, 0.0), float(top)


def play_protocol(
    actual: Robot,
    protocol: Protocol,
    effects: Effects,
    curvature: float,
    seed: Sequence[int],
    *,
    driven_for: Robot | None = None,
) -> Played:
    """Return the noiseless recording of every run; the same seed gives the same notches whatever the effects are.

    The drive spans what `driven_for` (the robot itself by default) needs for `curvature`.
    """
    joints, index, drives, lengths, times, tensions, responses, frames = [], [], [], [], [], [], [], []
    first = 0
    for number, plan in enumerate(protocol.runs):
        rng = np.random.default_rng([*seed, number])
        joint = actual.pair(plan.outer, plan.middle)
        share = rng.uniform(0.82, 1.0)
        reference = (driven_for or actual).pair(plan.outer, plan.middle)
        low, high = drive_range(reference, plan, curvature * share, protocol, rng.uniform(0.04, 0.2))
        drive = low + (high - low) * plan.fraction
        notch_rng = np.random.default_rng([*seed, 1000 + number])
        if effects:
            trace = simulate(
                joint,
                plan.length,
                drive,
                plan.time,
                effects,
                notch_rng,
                largest=curvature,
                density=actual.density,
                run=number,
            )
            response = observe(
                trace.theta, trace.weight, trace.length, plan.time, trace.simulated, protocol.response, effects
            )
            along = np.linspace(0, 1, plan.recorded.size)
            response, tension = response[plan.recorded], load_cell(trace.tension[plan.recorded], effects, along)
            response = seen_by_camera(response, plan.time[plan.recorded], effects, number, _camera_rng(seed, number))
        else:
            response, tension = clean_response(joint, plan, drive[plan.recorded], protocol.response)
        joints.append(joint)
        index.append(np.full(plan.recorded.size, number))
        drives.append(drive[plan.recorded])
        lengths.append(np.full(plan.recorded.size, plan.length))
        times.append(plan.time[plan.recorded])
        tensions.append(tension)
        responses.append(response)
        frames.append(first + shown_frames(plan.recorded.size, effects, _camera_rng(seed, number)))
        first += plan.recorded.size
    rows = Rows(
        tuple(joints), np.concatenate(index), np.concatenate(drives), np.concatenate(lengths), protocol.response
    )
    played = (np.concatenate(parts) for parts in (times, tensions, responses))
    return Played(rows, *played, np.concatenate(frames))


def _camera_rng(seed: Sequence[int], number: int) -> np.random.Generator:
    return np.random.default_rng([*seed, 2000 + number])


def clean_response(joint: Joint, plan: RunPlan, drive: Array, kind: str) -> tuple[Array, Array]:
    """Return the base model itself, the same in load and release."""
    if joint.tendon_radius == 0:
        kappa, tension = np.maximum(drive, 0) * joint.arm / (joint.gain(plan.length) * joint.rigidity), drive
    else:
        kappa = joint.curvature(drive, plan.length)
        tension = joint.stroke(kappa, plan.length)[1]
    if kind == "curvature":
        return kappa[:, None], tension
    if kind == "bend":
        return np.degrees(kappa * plan.length)[:, None], tension
    return np.degrees(np.repeat(kappa[:, None] * joint.middle.pitch, joint.middle.count, axis=1)), tension
