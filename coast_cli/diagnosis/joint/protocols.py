"""Recordings that could be made: drive histories in bench words, before anything is recorded."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.mechanics.joint import tension as tension_at
from coast_cli.recordings.model import JointRun, ResponseKind
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem
    from coast_cli.mechanics.section import FloatArray
    from coast_cli.spec.config import Config

PLANNED_SAMPLES = 120  # of a run
_WHOLE = 240  # of each candidate, so that they compare at equal length
_HOLD = 60.0  # s
_FASTER = 10.0
_THREE = (0.4, 0.7, 1.0)  # of the largest bending length


@dataclass(frozen=True)
class Bench:
    """What stays the same over a plan's runs.

    Attributes:
        outer, middle: tube names. kind, columns: of the response. stroke_driven: else tension is the drive.
        with_tension: whether tension is recorded beside the stroke. unit: of the drive in SI, a millimetre or a newton.
    """

    middle: str
    outer: str | None = None
    kind: ResponseKind = "curvature"
    columns: int = 1
    stroke_driven: bool = True
    with_tension: bool = False

    @property
    def unit(self) -> float:
        """SI value of one user unit of the drive."""
        return MILLIMETRE if self.stroke_driven else 1.0

    @property
    def unit_name(self) -> str:
        """That unit's name."""
        return "mm" if self.stroke_driven else "N"

    def run(
        self,
        name: str,
        corners: Sequence[float],
        rate: float,
        length: float,
        *,
        hold: float = 0.0,
        samples: int = PLANNED_SAMPLES,
    ) -> JointRun:
        """Return a run that moves through ``corners`` (SI) at ``rate`` (SI per s), each held for ``hold`` s after the first."""
        times, drives = [0.0], [corners[0]]
        for target in corners[1:]:
            times.append(times[-1] + abs(target - drives[-1]) / rate)
            drives.append(target)
            if hold:
                times.append(times[-1] + hold)
                drives.append(target)
        time = np.linspace(0.0, times[-1], samples)
        drive = np.interp(time, times, drives)
        return JointRun(
            name=name,
            source="plan",
            line=np.arange(2, samples + 2),
            time=time,
            outer=self.outer,
            middle=self.middle,
            bending_length=np.full(samples, length),
            stroke=drive if self.stroke_driven else None,
            tension=np.zeros(samples)
            if self.stroke_driven and self.with_tension
            else None
            if self.stroke_driven
            else drive,
            response=np.zeros((samples, self.columns)),
            kind=self.kind,
        )


@dataclass(frozen=True)
class Protocol:
    """A recording in bench words, and its runs; their response is not known yet."""

    words: str
    runs: tuple[JointRun, ...]


def standard(bench: Bench, low: float, top: float, lengths: Sequence[float], rate: float, hold: float) -> Protocol:
    """Return a load and release at each bending length, held for ``hold`` s at the top."""
    corners = (low, top, low)
    runs = [bench.run(f"{_mm(length)} mm", corners, rate, length, hold=hold) for length in lengths]
    return Protocol(f"load to {_drive(bench, top)} and release to {_drive(bench, low)}", tuple(runs))


def candidates(
    bench: Bench, low: float, top: float, lengths: Sequence[float], longest: float, rate: float
) -> list[Protocol]:
    """Return a handful of recordings worth choosing from, each with as many samples.

    Args:
        low, top: smallest and largest drive so far, SI. lengths: bending lengths so far, m. longest: notched length, m.
        rate: of the drive so far, SI per s.
    """
    length = max(lengths)
    reach = min(longest, 1.25 * length)
    at = f"at {_number(rate / bench.unit)} {bench.unit_name}/s"
    where = f"X2 = {_mm(length)} mm"
    wide, half = low + 1.4 * (top - low), low + 0.5 * (top - low)
    to_top, to_low = _drive(bench, top), _drive(bench, low)
    whole, steps = (low, top, low), np.linspace(low, top, 6)

    def protocol(words: str, *runs: Sequence[Any], bench: Bench = bench, hold: float = 0.0) -> Protocol:
        each = _WHOLE // len(runs)
        made = (bench.run(f"{n}", *run, hold=hold, samples=each) for n, run in enumerate(runs, start=1))
        return Protocol(words, tuple(made))

    found = [
        protocol(
            f"release from {to_top} to {to_low} {at}, after a hold of {_HOLD:g} s, {where}",
            (whole, rate, length),
            hold=_HOLD,
        ),
        protocol(
            f"release from {_drive(bench, half)} and then from {to_top} to {to_low} {at}, {where}",
            ((low, half, low), rate, length),
            (whole, rate, length),
        ),
        protocol(
            f"two rates: load to {to_top} and release {at} and ten times faster, holds of {_HOLD:g} s, {where}",
            (whole, rate, length),
            (whole, _FASTER * rate, length),
            hold=_HOLD,
        ),
        protocol(
            f"three bending lengths, X2 = {', '.join(_mm(part * reach) for part in _THREE)} mm: from slack (0 "
            f"{bench.unit_name}) to {to_top} and release to slack {at}",
            *(((0.0, top, 0.0), rate, part * reach) for part in _THREE),
        ),
        protocol(
            f"hold {_HOLD / 3.0:g} s at each of five steps up to {to_top} and five down, {at} between them, {where}",
            ((*steps, *steps[-2::-1]), rate, length),
            hold=_HOLD / 3.0,
        ),
        protocol(
            f"release from {_drive(bench, wide)}, further than so far, to {to_low} {at}, {where}",
            ((low, wide, low), rate, length),
        ),
    ]
    if bench.stroke_driven and not bench.with_tension:
        words = f"tension recorded while loading to {to_top} and releasing to {to_low} {at}, {where}"
        found.append(protocol(words, (whole, rate, length), bench=replace(bench, with_tension=True)))
    return found


def planned(config: Config, runs: Iterable[JointRun], noise: float, tension_noise: float | None) -> JointProblem:
    """Return the problem that a plan will pose: responses as the configured model expects them, without noise.

    Args:
        noise: of the response, SI. tension_noise: N, where tension is recorded beside the stroke.
    """
    from coast_cli.diagnosis.joint.build import build_joint_problem
    from coast_cli.spec.build import build_joint

    rough = []
    for run in runs:
        joint = build_joint(config, run.outer, run.middle)
        if run.stroke is not None:
            bent = np.maximum(run.stroke - joint.deadband, 0.0) / (run.bending_length * joint.lever_arm)
        else:
            bent = run.drive / tension_at(joint, 1.0, run.bending_length)
        rough.append(replace(run, response=_as_response(run, np.minimum(bent, joint.closure_curvature))))
    return expected(build_joint_problem(config, rough), noise, tension_noise)


def expected(problem: JointProblem, noise: float, tension_noise: float | None) -> JointProblem:
    """Return a problem whose runs hold what its model predicts, every sample usable."""
    tension_noise = (
        tension_noise if all(run.stroke is not None and run.tension is not None for run in problem.runs) else None
    )
    runs = tuple(
        replace(run, response=found.response, tension=None if run.tension is None else found.tension)
        for run, found in zip(problem.runs, problem.predict(problem.configured(), ()), strict=True)
    )
    return replace(
        problem,
        runs=runs,
        train=tuple(np.ones(len(run), bool) for run in runs),
        usable=tuple(np.ones(run.response.shape, bool) for run in runs),
        tension_usable=tuple(np.full(len(run), tension_noise is not None) for run in runs),
        noise=noise,
        tension_noise=tension_noise,
    )


def _as_response(run: JointRun, curvature: FloatArray) -> FloatArray:
    each = {"curvature": 1.0, "bend": run.bending_length, "notch": run.bending_length / run.response.shape[1]}[run.kind]
    return np.repeat((curvature * each)[:, np.newaxis], run.response.shape[1], axis=1)


def _drive(bench: Bench, value: float) -> str:
    return f"{_number(value / bench.unit)} {bench.unit_name}"


def _mm(length: float) -> str:
    return _number(length / MILLIMETRE)


def _number(value: float) -> str:
    return f"{value:.2g}" if abs(value) < 10.0 else f"{value:.0f}"
