"""What a recording says of a law without a name beside its numbers: energy in a loop, what it cannot hold, what would decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.joint.plan import bench_of, next_recording, usual_rate
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.unnamed.forms import Display
from coast_cli.diagnosis.unnamed.words import Known, dissipates
from coast_cli.effects.effect import Effect
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.mechanics.joint import tendon_shortening
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

_TAKES = ("tendon", "transmission", "structure")  # stages at which the tension at the actuator does the work
_LOOP_SAMPLES = 480
_LEAST_GAIN = 1.0  # nats, below which no recording that is offered parts two laws
_LEAST_ENERGY = 1e-3  # of the work of one way, below which a loop counts as closed


def laws_of(effects: Sequence[Effect]) -> tuple[UnnamedLaw, ...]:
    """Return the laws without a name of a model, by their numbers: of two, the first explains the most."""
    return tuple(sorted((e for e in effects if isinstance(e, UnnamedLaw)), key=lambda law: law.number))


def display_of(problem: JointProblem) -> Display:
    """Return the units in which laws of a recording are shown."""
    run = problem.runs[0]
    return Display(run.kind, run.stroke is None)


def known_of(problem: JointProblem, final: Fit, errors: tuple[float, float] | None) -> Known:
    """Return what a recording says of the laws of a model beside their numbers.

    Args:
        errors: on rows that were not fitted, in noise widths, without the laws and with them; None without such rows.
    """
    laws = laws_of(final.effects)
    energy, loop = _dissipated(problem, final)
    return Known(
        covariance={law.number: _covariance(problem, final, law) for law in laws},
        energy=energy,
        loop=loop,
        held_out=errors,
        memory=problem.holds["release"],
        rate=problem.holds["time"] and (problem.holds["rates"] or not any(dissipates(law) for law in laws)),
        open=_open(problem, laws),
    )


def parting(problem: JointProblem, alike: Sequence[Fit]) -> str:
    """Return the recording that would part the leading two of several fits that explain alike, or an empty text."""
    proposals = next_recording(problem, alike[:2]) if problem.device is None else []
    if not proposals or proposals[0].gain < _LEAST_GAIN:
        return ""
    return f"{proposals[0].words} (expected to add {proposals[0].gain:.0f} nats between the leading two)"


def _covariance(problem: JointProblem, final: Fit, law: UnnamedLaw) -> FloatArray:
    """Return the covariance of a law's parameters, in declared order; NaN where the fit does not know."""
    space = problem.space(final.effects)
    places = {
        coordinate.name: len(space.base) + sum(len(owned) for owned in space.owned[:index]) + offset
        for index, effect in enumerate(final.effects)
        if effect is law
        for offset, coordinate in enumerate(space.owned[index])
    }
    rows = [places.get(parameter.name, -1) for parameter in law.parameters]
    found = np.array(final.covariance[np.ix_(rows, rows)], dtype=np.float64)
    found[np.array(rows) < 0, :] = np.nan
    return found


def _dissipated(problem: JointProblem, final: Fit) -> tuple[float | None, str]:
    """Return the work (J) that the laws take in one full loop of the drive at its usual rate, and the loop in words."""
    taking = [law for law in laws_of(final.effects) if law.place in _TAKES and dissipates(law)]
    if not taking or problem.device is not None:
        return None, ""
    drives = [run.drive for run in problem.runs]
    low, top = min(float(drive.min()) for drive in drives), max(float(drive.max()) for drive in drives)
    length = max(float(np.median(run.bending_length)) for run in problem.runs)
    bench = bench_of(problem)
    corners = (low, top, low, top, low)
    run = bench.run("loop", corners, usual_rate(problem, top - low), length, samples=_LOOP_SAMPLES + 1)
    largest = max(float(np.nanmax(np.abs(one.response))) for one in problem.runs)
    run = replace(run, response=np.full_like(run.response, largest))  # so far tables must reach
    posed = replace(problem, runs=(run,), train=(), usable=(), tension_usable=())
    others = tuple(effect for effect in final.effects if effect not in taking)
    work = []
    for effects in (final.effects, others):
        found = posed.predict(final.coordinates, effects)[0]
        bent = found.response.sum(axis=1) / (1.0 if run.kind == "curvature" else length)
        joint = problem.joints[run.pair]
        if run.stroke is None:  # the tension that is asked for does the work
            work.append(_work(run.drive, tendon_shortening(joint, bent, length)))
        else:
            work.append(_work(found.tension, run.stroke))
    (taken, one_way), (before, _) = work
    taken -= before
    reach = f"{top / bench.unit:.3g} {bench.unit_name}"
    loop = f"a loop to {reach} and back at X2 = {length / MILLIMETRE:.3g} mm"
    return (taken if abs(taken) > _LEAST_ENERGY * one_way else None), loop


def _work(tension: FloatArray, moved: FloatArray) -> tuple[float, float]:
    """Return the work over the last whole loop of a history, and that of its way up, J."""
    half, quarter = tension.size // 2, 3 * tension.size // 4
    steps = 0.5 * (tension[1:] + tension[:-1]) * np.diff(moved)
    return float(np.sum(steps[half:])), float(np.sum(np.abs(steps[half:quarter])))


def _open(problem: JointProblem, laws: Sequence[UnnamedLaw]) -> tuple[str, ...]:
    """Return what of the description the recording cannot hold, a clause each."""
    held, found = problem.held, []
    if not problem.holds["release"]:
        found.append("whether it remembers, as there is no release")
    if not problem.holds["time"]:
        found.append("whether speed or time matters, as there is no time_s")
    elif not problem.holds["rates"] and any(dissipates(law) for law in laws):
        found.append("whether speed matters, as the drive has one rate and no hold")
    stages = {law.place for law in laws}
    if problem.tension_noise is None and problem.runs[0].stroke is not None and stages & {"drive", "tendon"}:
        found.append("drive or tendon, as there is no tension_n beside the stroke")
    elif not held.has_lengths and stages & {"structure", "transmission"}:
        found.append("structure or transmission, as there is one bending length")
    if held.runs == 1:
        found.append("whether it repeats, as there is one run")
    return tuple(found)
