"""A joint that is driven step by step, as a control loop drives it: it remembers where friction and play have left it.

The branches of load and release are the forward model's own tables, at a few bending lengths; between them each station
waits until a bound pushes it (``effects.memory.follow``, here one row at a time). So a history gives what
``effects.forward.predict`` gives for it. Plain numbers throughout: arrays of one entry would cost ten times as much.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, isfinite, pi, sin
from typing import NamedTuple

import numpy as np

from coast_cli.design.stepped import Creep, LawSlack, PermanentSet, Slack, StepLaw, Values, relaxed
from coast_cli.effects.catalogue import in_order
from coast_cli.effects.effect import Effect, acting
from coast_cli.effects.forward import Layout, Tables
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.bending_length_offset import BendingLengthOffset
from coast_cli.effects.library.camera_offset import CameraOffset
from coast_cli.effects.library.camera_scale import CameraScale
from coast_cli.effects.library.leadscrew_pitch_error import SCREW_PITCH, LeadscrewPitchError
from coast_cli.effects.library.sensor_lag import SensorLag
from coast_cli.effects.library.tendon_creep import TendonCreep
from coast_cli.effects.library.tendon_permanent_set import TendonPermanentSet
from coast_cli.effects.memory import waiting_parts
from coast_cli.effects.stages import (
    OnBranches,
    OnDrag,
    OnDrift,
    OnDrive,
    OnSensor,
    OnSettling,
    OnSlack,
    OnStretch,
    OnTubes,
)
from coast_cli.effects.stations import Stations, require_one_shape
from coast_cli.effects.unnamed import UnnamedLaw, Variable
from coast_cli.errors import BadInput, UsageError
from coast_cli.mechanics.joint import Joint, Tendon
from coast_cli.units import MILLIMETRE

_LENGTHS = 9  # tabulated bending lengths, as many as the forward model takes of a run that slides X2
_DRIVES = (LeadscrewPitchError, Backlash, BendingLengthOffset)
_CAMERAS = (CameraScale, CameraOffset, SensorLag)
_SLACKS = (TendonCreep, TendonPermanentSet)
_NOT_STEPPED: tuple[type[Effect], ...] = (OnDrag, OnSettling, OnDrift)
_NOT_KNOWN = ("rate", "path", "run")  # what a step does not know of its history
_SLACK_SWEEPS, _SLACK_TOLERANCE = 40, 1e-10  # m
_SHORTEST = 1e-4  # m, as BendingLengthOffset has it
_FEW, _TENSIONS = 1e-8, 16385

Row = tuple[float, ...]


class JointStep(NamedTuple):
    """Where a joint is: curvature (1/m), tension (N), tip (m), and the curvature that its camera would show (1/m)."""

    curvature: float
    tension: float
    tip_x: float
    tip_y: float
    seen_curvature: float


@dataclass(frozen=True, slots=True)
class _Side:
    """One branch at one bending length: drives that rise (m), and the curvature of each station there (1/m)."""

    drive: list[float]
    curvature: list[Row]

    def at(self, drive: float) -> Row:
        """Return the curvatures at a drive; the ends hold beyond."""
        right = bisect_right(self.drive, drive)
        if right == 0:
            return self.curvature[0]
        if right == len(self.drive):
            return self.curvature[-1]
        low, high = self.drive[right - 1], self.drive[right]
        part = (drive - low) / (high - low)
        before, after = self.curvature[right - 1], self.curvature[right]
        return tuple([one + part * (two - one) for one, two in zip(before, after, strict=True)])


class JointState:
    """A joint between steps; make one, then call ``step``.

    Args:
        joint: with a tendon. effects: its corrections, e.g. ``design.effects``.
        bending_lengths: the shortest and the longest X2 that will be asked for, m.
        largest_curvature: that tables must reach, 1/m.

    Raises:
        BadInput: the joint has no tendon, or a correction needs the whole history and cannot be stepped.
    """

    def __init__(
        self,
        joint: Joint,
        effects: Sequence[Effect] = (),
        *,
        bending_lengths: tuple[float, float],
        largest_curvature: float = 100.0,
    ) -> None:
        ordered = in_order(effects)
        _check(ordered)
        for effect in acting(ordered, OnTubes):
            joint = effect.joint(joint)
        if joint.tendon is None:
            raise BadInput("a joint is stepped by its stroke, and there is no [tendon] table")
        low, high = self._range = _range(joint, bending_lengths)
        require_one_shape(joint, low, high)
        self._drives = [effect for effect in ordered if isinstance(effect, _DRIVES) or _law_at(effect, "drive")]
        self._cameras = [effect for effect in ordered if isinstance(effect, _CAMERAS) or _law_at(effect, "sensor")]
        self._laws = {effect.id: StepLaw(effect) for effect in ordered if isinstance(effect, UnnamedLaw)}
        self._slacks = _slacks(ordered, joint.tendon.stiffness)
        self._clock, self._begun = 0.0, False
        offset = sum(e.offset_mm * MILLIMETRE for e in self._drives if isinstance(e, BendingLengthOffset))
        low, high = (max(length + offset, _SHORTEST) for length in (low, high))
        self._lengths = np.unique(np.linspace(low, high, _LENGTHS if high > low else 1)).tolist()
        self._reverses = any(effect.reverses for effect in ordered)
        layout, tables = Layout("curvature", 1, largest_curvature), Tables()
        found = [
            tables.axes(joint, ordered, length, layout, (1.0, 0.0), stroke_driven=True) for length in self._lengths
        ]
        self._load = [_side(one.load_drive, one.load_curvature) for one in found]
        self._release = [_side(one.release_drive, one.release_curvature) for one in found]
        self._segment = _Segment(found[0].stations)
        self._deadband = joint.deadband
        self._parts = waiting_parts(max((effect.rounding for effect in acting(ordered, OnBranches)), default=0.0))
        rest = found[0].stations.rest
        start: Row = tuple(np.asarray(self._load[0].curvature[0] if rest is None else rest, dtype=float).tolist())
        self._waiting = [start] * len(self._parts)
        self._pull = _Pull(joint.tendon, ordered, joint, max(side.drive[-1] for side in self._load))
        self._play: dict[int, float] = {}
        self._lagging: dict[int, _Lag] = {}

    def step(self, dt: float, stroke: float, bending_length: float) -> JointStep:
        """Move the actuators to X1 (stroke, m) and X2 (bending length, m), ``dt`` s after the step before.

        Raises:
            UsageError: a number that is not finite, a time that runs back, or an X2 outside the range given.
        """
        if not (isfinite(stroke) and isfinite(dt) and dt >= 0.0):
            raise UsageError(f"step: dt {dt:g} s, stroke {stroke:g} m: allowed: finite numbers, dt from 0.")
        if not self._range[0] - _FEW <= bending_length <= self._range[1] + _FEW:
            allowed = f"{self._range[0]:g} to {self._range[1]:g}, as bending_lengths says"
            raise UsageError(f"step: X2 {bending_length:g} m: allowed: {allowed}.")
        drive, length = stroke, bending_length
        self._clock += dt if self._begun else 0.0
        for place, effect in enumerate(self._drives):
            drive, length = self._driven(place, effect, dt, drive, length)
        left, part = self._between(length)
        slack, each = self._slackened(dt, drive, length, left, part)
        segment = self._segment
        curvature = segment.mean(each)
        stretch = drive - slack - self._deadband - segment.shortening(each, length)
        bend = curvature * length
        half = bend / 2.0
        chord = length if abs(half) < _FEW else length * sin(half) / half
        seen = curvature
        for place, camera in enumerate(self._cameras):
            seen = self._shown(place, camera, dt, seen, self._values(stroke, bending_length))
        self._begun = True
        return JointStep(curvature, self._pull.tension(max(stretch, 0.0)), chord * cos(half), chord * sin(half), seen)

    def _values(self, drive: float, length: float) -> dict[Variable, float]:
        """Return the variables that a law may depend on."""
        return {"stroke": drive, "tension": drive, "bending_length": length, "time": self._clock}

    def _slackened(self, dt: float, drive: float, length: float, left: int, part: float) -> tuple[float, Row]:
        """Return the tendon length (m) that slack takes, and the curvature of each station behind it."""
        if not self._slacks:
            return 0.0, self._moved(drive - self._deadband, left, part)
        waiting, taken, values = self._waiting, 0.0, self._values(drive, length)
        for sweep in range(_SLACK_SWEEPS):
            self._waiting = list(waiting)
            each = self._moved(drive - taken - self._deadband, left, part)
            stretch = drive - taken - self._deadband - self._segment.shortening(each, length)
            tension = self._pull.tension(max(stretch, 0.0))
            change = sum(slack.at(dt, tension, values) for slack in self._slacks) - taken
            if abs(change) < _SLACK_TOLERANCE:
                break
            taken += change if sweep < _SLACK_SWEEPS // 3 else 0.5 * change
        for slack in self._slacks:
            slack.keep()
        return taken, each

    def _driven(self, place: int, effect: Effect, dt: float, drive: float, length: float) -> tuple[float, float]:
        if isinstance(effect, Backlash):
            width = effect.width_mm * MILLIMETRE
            drive = self._play[place] = min(max(self._play.get(place, drive), drive), drive + width)
        elif isinstance(effect, LeadscrewPitchError):
            turn = 2.0 * pi * drive / SCREW_PITCH
            drive += (effect.sine_mm * sin(turn) + effect.cosine_mm * cos(turn)) * MILLIMETRE
        elif isinstance(effect, BendingLengthOffset):
            length = max(length + effect.offset_mm * MILLIMETRE, _SHORTEST)
        elif isinstance(effect, UnnamedLaw):
            drive = self._by_law(effect, dt, drive, MILLIMETRE, self._values(drive, length))
        return drive, length

    def _by_law(self, law: UnnamedLaw, dt: float, value: float, unit: float, values: Values) -> float:
        """Return a value with what a law adds to it, or where its play leaves it."""
        one = self._laws[law.id]
        found = one.moved(value, unit, values) if one.rubs else value + one.added(dt, values) * unit
        one.keep()
        return found

    def _between(self, length: float) -> tuple[int, float]:
        """Return the tabulated length below a length, and where it lies up to the next."""
        lengths = self._lengths
        if len(lengths) == 1:
            return 0, 0.0
        left = min(max(bisect_right(lengths, length) - 1, 0), len(lengths) - 2)
        return left, min(max((length - lengths[left]) / (lengths[left + 1] - lengths[left]), 0.0), 1.0)

    def _moved(self, drive: float, left: int, part: float) -> Row:
        """Return the curvature of each station after the drive (m, beyond the dead band) has pushed what it pushes."""
        low = _mixed(self._load, drive, left, part)
        if not self._reverses:
            return low
        high = tuple(map(max, low, _mixed(self._release, drive, left, part)))
        if len(self._parts) == 1:
            moved: Row = tuple(map(min, map(max, self._waiting[0], low), high))
            self._waiting[0] = moved
            return moved
        for place, width in enumerate(self._parts):
            self._waiting[place] = tuple(
                [
                    min(
                        max(state, 0.5 * (below + above) - width * 0.5 * (above - below)),
                        0.5 * (below + above) + width * 0.5 * (above - below),
                    )
                    for state, below, above in zip(self._waiting[place], low, high, strict=True)
                ]
            )
        return tuple([sum(states) / len(self._parts) for states in zip(*self._waiting, strict=True)])

    def _shown(self, place: int, camera: Effect, dt: float, value: float, values: Values) -> float:
        if isinstance(camera, UnnamedLaw):
            return self._by_law(camera, dt, value, 1.0, {**values, "curvature": value})
        if isinstance(camera, CameraScale):
            return value * camera.scale
        if isinstance(camera, CameraOffset):
            return value + camera.offset
        if place not in self._lagging:
            lag = camera if isinstance(camera, SensorLag) else SensorLag()
            self._lagging[place] = _Lag(lag.time_constant_s, lag.delay_s, value)
        return self._lagging[place].after(dt, value)


class _Segment:
    """The stations of a joint as plain numbers: their share of the bend, and how far a bend pulls the tendon."""

    def __init__(self, stations: Stations) -> None:
        self._length, self._rest_path = stations.bending_length, stations.rest_path
        self._share = stations.share.tolist()
        columns = (stations.count, stations.pitch / 2.0, stations.cut, stations.lever_arm)
        self._notches = list(zip(*(column.tolist() for column in columns), strict=True))

    def mean(self, each: Row) -> float:
        """Return the mean curvature, 1/m."""
        return sum(map(float.__mul__, self._share, each))

    def shortening(self, each: Row, length: float) -> float:
        """Return how far the bend pulls the tendon over a bending length (m), as ``Stations.shortening`` has it, m."""
        total = -self._rest_path
        for curvature, (count, half_pitch, cut, arm) in zip(each, self._notches, strict=True):
            half = curvature * half_pitch
            sine = sin(half)
            total += count * (cut * (1.0 - sine / half if half else 0.0) + 2.0 * arm * sine)
        return total * length / self._length


class _Pull:
    """The tendon's tension (N) at each stretch (m): a line, or a table where its material is not linear."""

    def __init__(self, tendon: Tendon, effects: Sequence[Effect], joint: Joint, longest: float) -> None:
        self._stiffness = tendon.stiffness
        self._table: _Side | None = None
        stretching = acting(effects, OnStretch)
        if stretching:
            tension = np.linspace(0.0, 1.0, _TENSIONS) ** 2 * tendon.stiffness * longest
            stretch = tension / tendon.stiffness
            for effect in stretching:
                stretch = effect.stretch(stretch, tension, joint)
            self._table = _side(stretch, tension[:, None])

    def tension(self, stretch: float) -> float:
        """Return the tension, N."""
        return stretch * self._stiffness if self._table is None else self._table.at(stretch)[0]


class _Lag:
    """A camera that answers late: a pure delay, then a first-order lag with the target linear between steps."""

    def __init__(self, time_constant: float, delay: float, start: float) -> None:
        self._time_constant, self._delay = time_constant, delay
        self._clock, self._past = 0.0, [(0.0, start)]
        self._target = self._value = start

    def after(self, dt: float, value: float) -> float:
        """Return what is shown ``dt`` s later, when the true value is ``value``."""
        target = self._delayed(dt, value)
        if self._time_constant <= _FEW:
            self._value = target
        else:
            self._value = relaxed(self._value, self._target, target, dt / self._time_constant)
        self._target = target
        return self._value

    def _delayed(self, dt: float, value: float) -> float:
        if self._delay == 0.0:
            return value
        self._clock += dt
        self._past.append((self._clock, value))
        wanted = self._clock - self._delay
        while len(self._past) > 2 and self._past[1][0] <= wanted:
            self._past.pop(0)
        (before, first), (after, second) = self._past[:2]
        if wanted <= before or after == before:
            return first
        return first + (second - first) * min((wanted - before) / (after - before), 1.0)


def _check(effects: Sequence[Effect]) -> None:
    """Refuse effects that the steps leave out."""
    for effect in effects:
        if _is_left_out(effect):
            raise BadInput(
                "this correction needs more of the history than a step has",
                key=f"corrections.{effect.id}",
                allowed="corrections by friction, play, screw, notches, rest shape, creep, set, scale and lag of the camera; laws"
                " without a name but those by rate, path or run, play of the tendon, and lags in the tubes or in friction",
                hint="coast_cli.effects.forward.predict takes whole histories.",
            )


def _is_left_out(effect: Effect) -> bool:
    slackens = bool(acting([effect], OnSlack))
    if any(acting([effect], stage) for stage in _NOT_STEPPED):
        return True
    if isinstance(effect, UnnamedLaw):
        return effect.variable in _NOT_KNOWN or (slackens and effect.memory == "friction")
    of_drive = acting([effect], OnDrive) and not isinstance(effect, _DRIVES)
    of_camera = acting([effect], OnSensor) and not isinstance(effect, _CAMERAS)
    return bool(of_drive or of_camera or (slackens and not isinstance(effect, _SLACKS)))


def _law_at(effect: Effect, place: str) -> bool:
    return isinstance(effect, UnnamedLaw) and effect.place == place


def _slacks(effects: Sequence[Effect], stiffness: float) -> list[Slack]:
    """Return what adds tendon length by what the tension was."""
    found: list[Slack] = []
    for effect in effects:
        if isinstance(effect, TendonCreep):
            found.append(Creep(effect, stiffness))
        elif isinstance(effect, TendonPermanentSet):
            found.append(PermanentSet(effect))
        elif isinstance(effect, UnnamedLaw) and acting([effect], OnSlack):
            found.append(LawSlack(effect))
    return found


def _range(joint: Joint, lengths: tuple[float, float]) -> tuple[float, float]:
    longest = min(tube.length for tube in (joint.outer, joint.middle) if tube is not None)
    if not 0.0 < lengths[0] <= lengths[1] <= longest * (1.0 + 1e-12):
        allowed = f"the shortest and the longest, above 0 and at most the notched length, {longest:g} m"
        raise UsageError(f"bending_lengths {lengths[0]:g} to {lengths[1]:g} m: allowed: {allowed}.")
    return lengths


def _side(drive: np.ndarray, curvature: np.ndarray) -> _Side:
    return _Side(drive.tolist(), [tuple(row) for row in curvature.tolist()])


def _mixed(sides: Sequence[_Side], drive: float, left: int, part: float) -> Row:
    """Return the curvatures at a drive, between the tables of two bending lengths."""
    near = sides[left].at(drive)
    if part == 0.0:
        return near
    return tuple([one + part * (two - one) for one, two in zip(near, sides[left + 1].at(drive), strict=True)])
