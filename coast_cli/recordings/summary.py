"""What is in a recording, run by run, and what it can and cannot decide."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import UsageError
from coast_cli.recordings.evidence import Evidence, evidence_of
from coast_cli.recordings.noise import NoiseEstimate, recording_noise, run_noises
from coast_cli.recordings.shape_noise import shape_noise
from coast_cli.recordings.thresholds import RATES_DIFFER
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.model import JointRun, Recordings, ResponseKind, ShapeRun

    Row = dict[str, str | float | int | None]

UNITS: dict[ResponseKind, tuple[str, float]] = {
    "curvature": ("curvature_per_m", 1.0),
    "bend": ("bend_deg", DEGREE),
    "notch": ("notch_deg", DEGREE),
    "position": ("position_mm", MILLIMETRE),
    "force": ("force_n", 1.0),
}


def summary_rows(recordings: Recordings, noise: float | None = None) -> list[Row]:
    """Return a row a run, joints first; the same names in each, None where one does not apply.

    Args:
        noise: of the camera where it is known, in the unit of the response.

    Raises:
        UsageError: it is no noise, or the responses have several units.
    """
    joint = recordings.joint.runs if recordings.joint else ()
    shape = recordings.shape.runs if recordings.shape else ()
    levels = run_noises(joint, known_noise(recordings, noise))
    return [*(_joint_row(*one) for one in zip(joint, levels, strict=True)), *(_shape_row(run) for run in shape)]


def known_noise(recordings: Recordings, noise: float | None) -> float | None:
    """Return a known noise in SI, from the unit of the response.

    Raises:
        UsageError: it is no noise, or the responses have several units.
    """
    if noise is None:
        return None
    kinds = {run.kind for run in recordings.joint.runs} if recordings.joint else set()
    if not 0.0 < noise < float("inf"):
        raise UsageError(f"{noise:g} is no noise level; allowed: a number above 0 in the unit of the response.")
    if len(kinds) != 1 or recordings.shape:
        raise UsageError("one noise level for several units; allowed: recordings of one kind of response of a joint.")
    return noise * UNITS[kinds.pop()][1]


def _joint_row(run: JointRun, noise: NoiseEstimate) -> Row:
    branches = run.branches
    response, unit = UNITS[run.kind]
    drive, drive_unit = ("stroke_mm", MILLIMETRE) if run.stroke is not None else ("tension_n", 1.0)
    has_length = bool(np.isfinite(run.bending_length).all())
    seconds = None if run.time is None else float(run.time[-1] - run.time[0])
    return {
        "run": run.name,
        "pair": run.pair or None,
        "n": len(run),
        "dropped": int((~run.valid).sum()),
        "drive": drive,
        "drive_from": float(run.drive.min()) / drive_unit,
        "drive_to": float(run.drive.max()) / drive_unit,
        "bending_length_from_mm": float(run.bending_length.min()) / MILLIMETRE if has_length else None,
        "bending_length_to_mm": float(run.bending_length.max()) / MILLIMETRE if has_length else None,
        "response": response,
        "response_to": float(np.nanmax(np.abs(run.response))) / unit,
        "load": int((run.direction > 0).sum()),
        "release": int((run.direction < 0).sum()),
        "hold": int((run.direction == 0).sum()),
        "cycles": branches.cycles,
        "duration_s": seconds,
        "noise": noise.level / unit,
        "noise_low": noise.interval[0] / unit,
        "noise_high": noise.interval[1] / unit,
        "noise_std": noise.level_std / unit if np.isfinite(noise.level_std) else None,
        "noise_correlation": noise.correlation,
        "quantum": noise.quantum / unit,
        "outlier_share": noise.outlier_share,
    }


def _shape_row(run: ShapeRun) -> Row:
    noise = shape_noise([run])
    row: Row = dict.fromkeys(_joint_names())
    row |= {
        "run": run.name,
        "pair": run.pair,
        "n": len(run),
        "dropped": 0,
        "response": "shape_mm",
        "response_to": float(np.hypot(run.x - run.x[0], run.y - run.y[0]).max()) / MILLIMETRE,
        "noise": noise.level / MILLIMETRE,
        "noise_low": noise.interval[0] / MILLIMETRE,
        "noise_high": noise.interval[1] / MILLIMETRE,
        "noise_std": noise.level_std / MILLIMETRE if np.isfinite(noise.level_std) else None,
        "noise_correlation": noise.correlation,
        "quantum": noise.quantum / MILLIMETRE,
        "outlier_share": noise.outlier_share,
    }
    return row


def _joint_names() -> tuple[str, ...]:
    return (
        "run",
        "pair",
        "n",
        "dropped",
        "drive",
        "drive_from",
        "drive_to",
        "bending_length_from_mm",
        "bending_length_to_mm",
        "response",
        "response_to",
        "load",
        "release",
        "hold",
        "cycles",
        "duration_s",
        "noise",
        "noise_low",
        "noise_high",
        "noise_std",
        "noise_correlation",
        "quantum",
        "outlier_share",
    )


def can_decide(recordings: Recordings, noise: float | None = None) -> tuple[str, ...]:
    """Return sentences on what the recordings can and cannot decide, and what to record for the rest."""
    joint = recordings.joint.runs if recordings.joint else ()
    shape = recordings.shape.runs if recordings.shape else ()
    return (*_about_joints(joint, known_noise(recordings, noise)), *_about_shapes(shape))


def _about_joints(runs: Sequence[JointRun], known: float | None) -> list[str]:
    if not runs:
        return []
    held = evidence_of(runs)
    has_tubes = any(run.pair for run in runs)
    sentences = [*_history(held), *_clock(held)]
    if has_tubes:
        sentences += [*_lengths(held), *_drives(held)]
    elif not held.loads:
        sentences.append("no load is recorded: stretch cannot be told from the ratio, nor friction from play by load.")
    return [*sentences, *_repeats(held), *_noise(runs, known)]


def _history(held: Evidence) -> list[str]:
    found = []
    if not held.has_release:
        found.append("loading only: friction, play and what else shows on release cannot be decided; record a release.")
    else:
        found.append(f"release is recorded in {held.released} of {held.runs} runs: friction and play can be decided.")
        if held.cycles < 2:
            found.append(
                "no run loads a second time: slack or set that the first load leaves behind cannot be decided."
            )
    if not held.holds:
        found.append("the drive never holds: creep cannot be decided; hold the largest stroke for a minute.")
    return found


def _clock(held: Evidence) -> list[str]:
    if not held.has_clock:
        where = "no clock" if held.untimed == held.runs else f"no clock in {held.untimed} of {held.runs} runs"
        return [f"{where}: nothing about rate or time (lag, creep, drift) can be concluded."]
    if held.rate_ratio > RATES_DIFFER:
        return [f"rates differ by {held.rate_ratio:.1f} times: a lag of the camera can be told from friction."]
    if held.has_rates:
        return ["one rate, and a hold: a lag of the camera can be told from friction."]
    return ["one rate only: a lag of the camera cannot be told from friction; repeat a loop at a third of the speed."]


def _lengths(held: Evidence) -> list[str]:
    if not held.has_lengths or held.lengths is None:
        return ["one bending length: notch friction and an offset of X2 hide in the modulus; record a second X2."]
    low, high = (length / MILLIMETRE for length in held.lengths)
    return [f"bending lengths from {low:g} to {high:g} mm: notch friction can be told from the modulus."]


def _drives(held: Evidence) -> list[str]:
    if not held.strokes:
        return ["driven by tension: nothing about the tendon's stretch or the deadband can be decided."]
    if held.tensions < held.strokes:
        return ["stroke without tension: joint modulus, pulley friction and tendon modulus are one product."]
    return ["stroke and tension: the tendon's stretch can be told from what bends the tubes."]


def _repeats(held: Evidence) -> list[str]:
    if held.runs == 1:
        return ["one run: held out are blocks of it, which is weaker than a run of its own."]
    return [f"{held.repeats} runs repeat one another: one of them can be held out."] if held.repeats > 1 else []


def _noise(runs: Sequence[JointRun], known: float | None) -> list[str]:
    """Say the one noise of all runs of a kind, as every command takes it."""
    found = []
    for kind, (name, unit) in UNITS.items():
        members = [run for run in runs if run.kind == kind]
        if members:
            noise = recording_noise(members, known)
            low, high = (bound / unit for bound in noise.interval)
            level = f"{noise.level / unit:.3g} {name}"
            found.append(f"noise of all runs together: {level} ({low:.3g} to {high:.3g}, 90 %); {noise.words}.")
    return found


def _about_shapes(runs: Sequence[ShapeRun]) -> list[str]:
    if not runs:
        return []
    sides: dict[str, set[str | None]] = {}
    for run in runs:
        sides.setdefault(run.pair, set()).add(run.natural)
    one_way = [pair for pair, ways in sides.items() if not {"up", "down"} <= ways]
    if one_way:
        names = ", ".join(one_way)
        return [f"{names}: one way up only, so natural curvature cannot be told from sag; turn the tube over."]
    return ["each tube lies both ways up: natural curvature can be told from sag."]
