"""What a joint's answer says besides its figures: notes on its joint_limits, and the next recording in bench words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.joint.candidates import applicable
from coast_cli.diagnosis.joint.loop import widest_loop
from coast_cli.diagnosis.joint.problem import JointProblem, with_base
from coast_cli.effects.catalogue import effects_of
from coast_cli.effects.devices import device_effects
from coast_cli.effects.effect import Effect
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.tube_superelasticity import TubeSuperelasticity
from coast_cli.effects.plateau import has_own_curve
from coast_cli.units import MEGAPASCAL, MILLIMETRE

FIRST_RECORDING = (
    "load from slack to the largest stroke and release to zero, 200 samples or more, at two bending lengths"
)
SAME_SWEEP_AGAIN = (
    "the same sweep twice, unchanged, then at half the rate and at another bending length, "
    "with time and tension recorded"
)


def joint_limits(problem: JointProblem) -> list[str]:
    """Return what the recording cannot show, a sentence each."""
    notes = []
    if not problem.holds["time"]:
        notes.append(
            "there is no time_s: samples are taken as one second apart (assumed), so what lag, creep or drift "
            "show is weaker, and their time constants count samples"
        )
    if not problem.holds["release"]:
        notes.append("there is no release, so friction, play and set cannot show")
    elif problem.holds["time"] and not problem.holds["rates"]:
        notes.append("the drive has one rate and no hold, so a late camera can hardly be told from play")
    return notes


def one_length(problem: JointProblem) -> list[str]:
    """Return the note on a single bending length, if there is but one."""
    if problem.held.has_lengths or problem.held.lengths is None:
        return []
    return ["there is one bending length, so what grows with it is taken up by the modulus"]


def loop_note(problem: JointProblem, effects: Sequence[Effect]) -> list[str]:
    """Say how wide the loop is low and high up, where what was named is one of those that make loops."""
    loop = widest_loop(problem.runs) if problem.device is None else None
    if loop is None or not any(effect.reverses or isinstance(effect, Backlash) for effect in effects):
        return []
    unit, name = (MILLIMETRE, "mm") if problem.runs[0].stroke is not None else (1.0, "N")
    low, high = f"{loop.low / unit:.2g} {name}", f"{loop.high / unit:.2g} {name}"
    return [f"the loop is {low} wide at a fifth of the response and {high} at four fifths: {loop.meaning}"]


def plateau_note(problem: JointProblem, fit: Fit) -> list[str]:
    """Say at which stress the plateau begins, where a softening of tubes with a curve of their own was fitted as a strain."""
    found = [effect for effect in fit.effects if isinstance(effect, TubeSuperelasticity)]
    joints = [joint for joint in problem.joints.values() if has_own_curve(joint)]
    if not (found and joints):
        return []
    stress = found[0].plateau(with_base(joints[0], problem.values(fit.coordinates))) / MEGAPASCAL
    return [f"tube_superelasticity: the upper plateau is at {stress:.4g} MPa, knee_strain times the joint's modulus"]


def untested(problem: JointProblem) -> str:
    """Return the recording that would show what this one cannot, in bench words; empty where little is left open."""
    if problem.device is not None:
        return _untested_device(problem)
    runs = problem.runs
    top = max(float(np.max(run.drive)) for run in runs)
    reach = f"{top / MILLIMETRE:.3g} mm" if runs[0].stroke is not None else f"{top:.3g} N"
    lengths = [float(np.median(run.bending_length)) for run in runs]
    parts = []
    if not problem.holds["release"]:
        parts.append(f"load to {reach}, release to half of it, load again and release to zero")
    if not problem.held.has_lengths and runs[0].kind != "notch":
        half = 0.5 * max(lengths) / MILLIMETRE
        parts.append(f"the same at X2 = {half:.3g} mm beside {max(lengths) / MILLIMETRE:.3g} mm")
    lowest = min(float(np.min(run.drive)) for run in runs)
    if lowest > (max(problem.joints[runs[0].pair].deadband, 0.02 * top) if runs[0].stroke is not None else 0.02 * top):
        parts.append("begin each sweep slack, at zero " + ("stroke" if runs[0].stroke is not None else "tension"))
    if not problem.holds["time"]:
        parts.append("record time_s, at two rates ten times apart, with a hold of 60 s at the largest drive")
    if runs[0].stroke is not None and problem.tension_noise is None:
        parts.append("record tension_n")
    return "; ".join(parts)


def _untested_device(problem: JointProblem) -> str:
    parts = [] if problem.holds["release"] else ["the same way back and forth again"]
    if not problem.holds["time"] or not problem.holds["rates"]:
        parts.append("record time_s, at two rates ten times apart, with a hold at both ends")
    if not problem.holds["load"]:
        parts.append("record the load of the far end (load_n or load_n_m), at two loads")
    return "; ".join(parts)


def device_limits(problem: JointProblem) -> list[str]:
    """Return what is no candidate on a device without tubes, as a note."""
    if problem.device is None:
        return []
    acting = {effect.id for effect in applicable(problem)}
    needing = [i for i in device_effects() if i not in acting | set(problem.concealed)]
    without = len(set(effects_of("joint")) - set(device_effects()))
    text = f"a transmission has no tubes, tendon or notches: {without} effects that act there are no candidates"
    holds = "not looked for here, as the recording holds nothing of them"
    return [f"{text}; {holds}: {', '.join(needing)}" if needing else text]
