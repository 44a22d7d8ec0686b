"""The forward model: what the segment does when the drive has a history, with any set of effects.

Every monotone branch has a closed form once it is tabulated against the segment's own bend: moment, tension, tendon
path. Load and release each give one table; between them the state waits (``memory.follow``), which covers friction,
play and snap-through alike. Tendon memory (creep, set) shortens the effective stroke and is iterated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from coast_cli.effects.catalogue import in_order
from coast_cli.effects.effect import Effect, History, Motion, acting
from coast_cli.effects.library.tip_load import TipLoad
from coast_cli.effects.memory import follow, waiting_parts
from coast_cli.effects.stages import (
    OnBranches,
    OnDrag,
    OnDrift,
    OnDrive,
    OnLoadCell,
    OnSensor,
    OnSettling,
    OnSlack,
    OnStretch,
    OnStructure,
    OnTubes,
)
from coast_cli.effects.stations import Stations, branch, require_one_shape, stations_for
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray

ResponseKind = Literal["curvature", "bend", "notch", "position", "force"]

# Distinct bending lengths tabulated one by one; a run that slides X2 continuously is interpolated between this many.
_MOST_LENGTHS = 9
_MOST_FORCES = 5  # between which bounds under a force at the tip go in a line
_SLACK_SWEEPS = 12
_SLACK_TOLERANCE = 1e-8  # m, far under any screw's step


@dataclass(frozen=True, slots=True)
class Prediction:
    """What the model expects to be recorded: ``response`` (n, k) in SI, ``tension`` (n,) in N at the actuator."""

    response: FloatArray
    tension: FloatArray


@dataclass(frozen=True, slots=True)
class Layout:
    """What is observed: the kind of response, and of how many notches where it is notch by notch."""

    kind: ResponseKind
    columns: int = 1
    curvature_limit: float = 100.0


def predict(
    joint: Joint, effects: Sequence[Effect], runs: Sequence[History], layout: Layout, tables: Tables | None = None
) -> list[Prediction]:
    """Return the prediction of every run, in order; what a run leaves behind is carried to the next.

    Args:
        joint: with its base parameters. effects: any set, in any order. runs: drive histories, SI.
        layout: what is observed, and the largest curvature (1/m) that tables must reach.
        tables: what earlier calls have tabulated, to be used again and added to.
    """
    ordered = in_order(effects)
    tables = tables if tables is not None else Tables()
    tables.begin()
    for effect in acting(ordered, OnTubes):
        joint = effect.joint(joint)
    predictions = []
    earlier = 0.0
    for run in runs:
        prediction = _predict_run(joint, ordered, replace(run, earlier_tension=earlier), layout, tables)
        earlier = max(earlier, float(np.max(prediction.tension, initial=0.0)))
        predictions.append(prediction)
    return predictions


@dataclass(frozen=True, slots=True)
class _Branches:
    """What a joint's structure holds at one bending length, whatever its tendon: load first, then release where it differs.

    Attributes:
        sides: of each direction the actuator's tension (q,), curvature of each station (q, m), tendon shortening (q,).
        joint: kept alive, as its tubes' identities are part of what the table is found by.
    """

    stations: Stations
    sides: tuple[tuple[FloatArray, FloatArray, FloatArray], ...]
    joint: Joint


class Tables:
    """Branches that were tabulated before; a fit moves many parameters that they do not depend on."""

    _MOST = 600

    def __init__(self) -> None:
        self._found: dict[tuple[object, ...], _Branches] = {}
        self._axes: dict[tuple[int, bool], _Tables] = {}

    def begin(self) -> None:
        """Forget what depends on the tendon and on the zero of the stroke: a prediction with other parameters begins."""
        self._axes.clear()

    def axes(
        self,
        joint: Joint,
        effects: Sequence[Effect],
        length: float,
        layout: Layout,
        drifted: tuple[float, float],
        *,
        stroke_driven: bool,
    ) -> _Tables:
        """Return load and release branch over the drive, for the joint and effects of this prediction."""
        branches = self.branches(joint, effects, length, layout, drifted)
        key = (id(branches), stroke_driven)
        if key not in self._axes:
            self._axes[key] = _tabulate(joint, effects, branches, stroke_driven=stroke_driven)
        return self._axes[key]

    def branches(
        self, joint: Joint, effects: Sequence[Effect], length: float, layout: Layout, drifted: tuple[float, float]
    ) -> _Branches:
        """Return the branches of a joint at one bending length (m), tabulated now or before."""
        shaping = tuple(acting(effects, OnBranches))
        radius = None if joint.tendon is None else joint.tendon.radius
        key = (
            joint.youngs_modulus,
            joint.pulley_friction,
            joint.wrap_angle,
            joint.notch_friction,
            radius,
            id(joint.middle),
            id(joint.outer),
            shaping,
            length,
            layout.kind,
            layout.columns,
            layout.curvature_limit,
            drifted,
        )
        if key not in self._found:
            if len(self._found) >= self._MOST:
                self._found.clear()
                self._axes.clear()  # found by the identity of branches that are gone now
            stations = stations_for(joint, shaping, length, layout.kind, layout.columns, drifted)
            sides = []
            for direction in (1, -1) if any(effect.reverses for effect in shaping) else (1,):
                tension, curvature = branch(stations, shaping, direction, layout.curvature_limit)
                sides.append((tension, curvature, stations.shortening(curvature)))
            self._found[key] = _Branches(stations, tuple(sides), joint)
        return self._found[key]


@dataclass(frozen=True, slots=True)
class _Tables:
    """Load and release branch at one bending length: drive beyond the dead band, curvature of each station."""

    stations: Stations
    load_drive: FloatArray
    load_curvature: FloatArray
    release_drive: FloatArray
    release_curvature: FloatArray


def _predict_run(
    joint: Joint,
    effects: Sequence[Effect],
    commanded: History,
    layout: Layout,
    tables: Tables,
) -> Prediction:
    history = commanded
    for drive in acting(effects, OnDrive):
        history = drive.drive(history)
    low, high, stations = _bounds(joint, effects, history, history.drive, layout, tables)
    curvature, tension = _with_memory(joint, effects, history, layout, tables, low, high, stations)
    response = _observe(curvature, stations, history.bending_length, layout)
    for camera in acting(effects, OnSensor):
        response = camera.sense(response, commanded)
    for cell in acting(effects, OnLoadCell):
        tension = cell.weigh(tension, commanded)
    return Prediction(response, tension)


def _with_memory(
    joint: Joint,
    effects: Sequence[Effect],
    history: History,
    layout: Layout,
    tables: Tables,
    low: FloatArray,
    high: FloatArray | None,
    stations: Stations,
) -> tuple[FloatArray, FloatArray]:
    """Return curvature and tension of a run; what the tendon and the segment remember takes from the drive until all agree."""
    driven = history.stroke is not None
    slackening = acting(effects, OnSlack) if driven else []
    dragging, settling = acting(effects, OnDrag), acting(effects, OnSettling)
    stiffness = np.inf if joint.tendon is None else joint.tendon.stiffness
    slack, taken = np.zeros_like(history.drive), np.zeros_like(history.drive)
    for sweep in range(_SLACK_SWEEPS):
        curvature = _state(low, high, stations, effects)
        rigidity, arm = stations.rigidity, float(np.mean(stations.lever_arm))
        for effect in settling:
            curvature = effect.settle(curvature, history, joint, rigidity, arm)
        if driven:
            tension = _tension(joint, effects, history.drive - slack, curvature, stations, history.bending_length)
        else:
            tension = history.drive
        if not slackening and not dragging:
            break
        slack = sum((effect.slack(tension, history, joint) for effect in slackening), np.zeros_like(tension))
        motion = Motion(history, tension, curvature @ stations.share, _tension_per_curvature(joint, history, stations))
        drag = sum((effect.drag(motion) for effect in dragging), np.zeros_like(tension))
        wanted = slack + drag / stiffness if driven else drag
        step = wanted - taken
        taken = taken + (step if sweep < _SLACK_SWEEPS // 3 else 0.5 * step)
        if float(np.max(np.abs(step), initial=0.0)) < _SLACK_TOLERANCE:
            break
        low, high, stations = _bounds(joint, effects, history, history.drive - taken, layout, tables)
    return curvature, tension


def _tension_per_curvature(joint: Joint, history: History, stations: Stations) -> FloatArray:
    """Return the tension at the actuator (N) that one 1/m of curvature costs at each row, N m, shape (n,)."""
    gain = np.exp(
        joint.pulley_friction * joint.wrap_angle + history.bending_length / joint.pitch * np.log(joint.notch_friction)
    )
    return np.asarray(gain * stations.rigidity / float(np.mean(stations.lever_arm)))


def _state(low: FloatArray, high: FloatArray | None, stations: Stations, effects: Sequence[Effect]) -> FloatArray:
    """Return the curvature of each station; without a release branch of its own there is nothing to wait for."""
    if high is None:
        return low
    high = np.maximum(low, high)
    rounding = max((effect.rounding for effect in acting(effects, OnBranches)), default=0.0)
    if rounding == 0.0:
        return follow(low, high, stations.rest)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    parts = [follow(middle - part * half, middle + part * half, stations.rest) for part in waiting_parts(rounding)]
    return np.asarray(np.mean(parts, axis=0))


def _bounds(
    joint: Joint,
    effects: Sequence[Effect],
    history: History,
    drive: FloatArray,
    layout: Layout,
    tables: Tables,
) -> tuple[FloatArray, FloatArray | None, Stations]:
    """Return the curvature (n, m) that load and release hold at each row, and the stations they stand for."""
    if history.tip_force is not None:
        return _at_forces(joint, effects, history, drive, layout, tables)
    reverses = any(effect.reverses for effect in effects)
    drifting = _drifting(effects, history)
    if drifting is None:
        return _at_lengths(joint, effects, history, drive, layout, tables, (1.0, 0.0), reverses)
    effect, drift = drifting
    first, last = float(drift.min()), float(drift.max())
    low_0, high_0, stations = _at_lengths(
        joint, effects, history, drive, layout, tables, effect.drifted(first), reverses
    )
    if last - first < 1e-12:
        return low_0, high_0, stations
    low_1, high_1, _ = _at_lengths(joint, effects, history, drive, layout, tables, effect.drifted(last), reverses)
    part = ((drift - first) / (last - first))[:, np.newaxis]
    high = None if high_0 is None or high_1 is None else high_0 + part * (high_1 - high_0)
    return low_0 + part * (low_1 - low_0), high, stations


def _at_forces(
    joint: Joint, effects: Sequence[Effect], history: History, drive: FloatArray, layout: Layout, tables: Tables
) -> tuple[FloatArray, FloatArray | None, Stations]:
    """Return the same under the force at the tip (N) that was recorded: between a few forces bounds go in a line."""
    forces, free = history.tip_force, replace(history, tip_force=None)
    if forces is None or forces.size == 0:
        return _bounds(joint, effects, free, drive, layout, tables)
    low, high = float(forces.min()), float(forces.max())
    nodes = np.unique(np.linspace(low, high, _MOST_FORCES if high > low else 1))
    below, above, stations = [], [], []
    for node, row in zip(nodes.tolist(), np.eye(nodes.size), strict=True):
        lower, upper, found = _bounds(joint, (*effects, TipLoad(1e3 * node)), free, drive, layout, tables)
        weight = np.interp(forces, nodes, row)[:, np.newaxis]
        below.append(weight * lower)
        above += [] if upper is None else [weight * upper]
        stations.append(found)
    return np.sum(below, axis=0), np.sum(above, axis=0) if above else None, stations[0]


def _drifting(effects: Sequence[Effect], history: History) -> tuple[OnDrift, FloatArray] | None:
    """Return the effect that changes the structure slowly, and how far it has come at each row."""
    if history.time is None or history.time.size == 0:
        return None
    found = ((effect, effect.drift(history.time)) for effect in acting(effects, OnDrift))
    return next(((effect, drift) for effect, drift in found if drift is not None), None)


def _at_lengths(
    joint: Joint,
    effects: Sequence[Effect],
    history: History,
    drive: FloatArray,
    layout: Layout,
    tables: Tables,
    drifted: tuple[float, float],
    reverses: bool,  # noqa: FBT001 -- private, and always passed by the two lines above
) -> tuple[FloatArray, FloatArray | None, Stations]:
    lengths = history.bending_length
    distinct = np.unique(np.round(lengths, 7))
    if distinct.size > _MOST_LENGTHS:
        distinct = np.linspace(distinct[0], distinct[-1], _MOST_LENGTHS)
    driven = history.stroke is not None
    found = [tables.axes(joint, effects, length, layout, drifted, stroke_driven=driven) for length in distinct.tolist()]
    if driven:
        drive = drive - joint.deadband
    if len(found) == 1:
        return _look_up(found[0], drive, reverses)
    require_one_shape(joint, float(distinct[0]), float(distinct[-1]))
    left = np.clip(np.searchsorted(distinct, lengths + 1e-9, side="right") - 1, 0, distinct.size - 2)
    part = np.clip((lengths - distinct[left]) / (distinct[left + 1] - distinct[left]), 0.0, 1.0)
    low = np.zeros((drive.size, found[0].load_curvature.shape[1]))
    high = np.zeros_like(low) if reverses else None
    for place, table in enumerate(found):
        share = np.where(left == place, 1.0 - part, 0.0) + np.where(left + 1 == place, part, 0.0)
        rows = np.flatnonzero(share)
        if rows.size == 0:
            continue
        below, above, _ = _look_up(table, drive[rows], reverses)
        low[rows] += share[rows, np.newaxis] * below
        if high is not None and above is not None:
            high[rows] += share[rows, np.newaxis] * above
    return low, high, found[0].stations


def _look_up(
    tables: _Tables,
    drive: FloatArray,
    reverses: bool,  # noqa: FBT001 -- private
) -> tuple[FloatArray, FloatArray | None, Stations]:
    def at(axis: FloatArray, values: FloatArray) -> FloatArray:
        out = np.empty((drive.size, values.shape[1]))
        for j in range(values.shape[1]):
            out[:, j] = np.interp(drive, axis, values[:, j])
        return out

    low = at(tables.load_drive, tables.load_curvature)
    high = at(tables.release_drive, tables.release_curvature) if reverses else None
    return low, high, tables.stations


def _tabulate(joint: Joint, effects: Sequence[Effect], branches: _Branches, *, stroke_driven: bool) -> _Tables:
    """Return both branches at one bending length, each as a strictly usable axis: a jump is where it cannot hold."""
    sides = []
    rest = 0.0
    homed = max((effect.homing() for effect in acting(effects, OnStructure)), default=0.0)
    for direction, (tension, curvature, shortening) in zip((1, -1), branches.sides, strict=False):
        if stroke_driven:
            if direction > 0:
                rest = homed * float(shortening[0])
            axis = shortening - rest + _stretch(joint, effects, tension)
        else:
            axis = tension
        axis = np.maximum.accumulate(axis) if direction > 0 else np.minimum.accumulate(axis[::-1])[::-1]
        sides.append((axis, curvature))
    stations = replace(branches.stations, rest_path=rest, rest=0.5 * (sides[0][1][0] + sides[-1][1][0]))
    return _Tables(stations, *sides[0], *sides[-1])


def _stretch(joint: Joint, effects: Sequence[Effect], tension: FloatArray) -> FloatArray:
    if joint.tendon is None:
        return np.zeros_like(tension)
    stretch = tension / joint.tendon.stiffness
    for effect in acting(effects, OnStretch):
        stretch = effect.stretch(stretch, tension, joint)
    return stretch


def _tension(
    joint: Joint,
    effects: Sequence[Effect],
    stroke: FloatArray,
    curvature: FloatArray,
    stations: Stations,
    lengths: FloatArray,
) -> FloatArray:
    """Return the actuator's tension (N) from what the tendon is stretched by, given the curvature of each station."""
    if joint.tendon is None:
        return np.zeros_like(stroke)
    short = (stations.shortening(curvature) - stations.rest_path) * (lengths / stations.bending_length)
    stretch = np.maximum(stroke - joint.deadband - short, 0.0)
    if not acting(effects, OnStretch):
        return stretch * joint.tendon.stiffness
    grid = np.linspace(0.0, float(np.max(stretch, initial=0.0)) * joint.tendon.stiffness * 1.01 + 1e-12, 257)
    return np.interp(stretch, _stretch(joint, effects, grid), grid)


def _observe(curvature: FloatArray, stations: Stations, lengths: FloatArray, layout: Layout) -> FloatArray:
    """Return what a perfect camera reads, (n, k): mean curvature, bend of the segment, or bend notch by notch."""
    if layout.kind == "notch":
        bend = curvature * stations.pitch
        return bend if bend.shape[1] == layout.columns else np.repeat(bend, layout.columns, axis=1)
    mean = curvature @ stations.share
    return np.asarray((mean * lengths if layout.kind == "bend" else mean)[:, np.newaxis])
