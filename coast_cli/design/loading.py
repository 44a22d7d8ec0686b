"""The loading branch of a joint with corrections, as a table that is read both ways: stroke, tension, curvature.

It is the forward model of the diagnosis, pulled once and slowly from rest. What only time, release or the camera would
show does not act on it. Read as straight lines between the same nodes in either direction, the inverse of the forward
table is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from coast_cli.effects.catalogue import in_order
from coast_cli.effects.effect import Effect, History, acting
from coast_cli.effects.stages import OnDrag, OnDrive, OnSlack, OnStretch, OnStructure, OnTubes
from coast_cli.effects.stations import Stations, branch, stations_for
from coast_cli.errors import NotConverged
from coast_cli.mechanics.joint import Joint, StrokeSolution, curvature_from_stroke
from coast_cli.mechanics.rounding import without_rounding
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.verdict import Verdict
from coast_cli.units import MILLIMETRE

_FIRST_LIMIT = 64.0  # 1/m; a table reaches twice as far as the one before
_LARGEST_CURVATURE = 1e5
_STEP, _ACTUATOR_ERROR = 2e-6, 1e-3  # m; nodes of the stroke where the actuator has an error, and its most
_LONGEST_STROKE = 2.0  # m, past any actuator; a million of those nodes
_HELD = 1e-12  # m of stroke, N of tension


@dataclass(frozen=True, slots=True)
class LoadingBranch:
    """One bending length; arrays of (q,), from rest upwards.

    Attributes:
        stroke: commanded, deadband included, m; zeros without a tendon. tension: at the actuator, N.
        stretch: of the tendon, m. curvature: mean of the segment, 1/m.
        held: whether the joint can be held there: no further stroke, and no more tension, was needed before.
    """

    stroke: FloatArray
    tension: FloatArray
    stretch: FloatArray
    curvature: FloatArray
    held: FloatArray

    def at_curvature(self, curvature: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return stroke, tension and stretch; NaN where no stroke holds the curvature."""
        found = [_read(curvature, self.curvature, column) for column in (self.stroke, self.tension, self.stretch)]
        held = np.interp(curvature, self.curvature, self.held) > 1.0 - _HELD
        reached = (curvature >= self.curvature[0] - _HELD) & held
        stroke, tension, stretch = (np.where(reached, column, np.nan) for column in found)
        return stroke, tension, stretch

    def at_stroke(self, stroke: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return curvature, tension and stretch; below the first stroke the joint is at rest."""
        axis = np.maximum.accumulate(self.stroke)
        found = (_read(stroke, axis, column) for column in (self.curvature, self.tension, self.stretch))
        curvature, tension, stretch = found
        return curvature, tension, stretch


def _read(at: FloatArray, axis: FloatArray, column: FloatArray) -> FloatArray:
    return without_rounding(np.interp(at, axis, column), column)


def acting_on_load(effects: Sequence[Effect]) -> tuple[tuple[Effect, ...], tuple[str, ...]]:
    """Return the effects that a slow first pull could show, and notes on those that it cannot."""
    camera = tuple(effect for effect in effects if effect.kind == "sensor")
    timed = tuple(effect for effect in effects if effect.kind != "sensor" and "time" in effect.needs)
    notes = []
    if camera:
        notes.append(f"{_ids(camera)}: of the camera, not of the robot, so left out here.")
    if timed:
        notes.append(f"{_ids(timed)}: acts with time, so left out of a slow first pull.")
    dragging = tuple(effect for effect in acting(effects, OnDrag) if effect not in timed)
    if dragging:
        notes.append(f"{_ids(dragging)}: takes tension by what was before, so left out of a slow first pull.")
    left_out = (*camera, *timed, *dragging)
    return tuple(effect for effect in effects if effect not in left_out), tuple(notes)


def corrected_stroke(
    joint: Joint, effects: Sequence[Effect], bending_length: FloatArray, drive: FloatArray, *, inverse: bool
) -> StrokeSolution:
    """Return stroke, tension and strain of curvatures (1/m), or with ``inverse`` of strokes (m); arrays of (n,).

    NaN stands where no stroke holds a curvature: the joint is bent further at rest, or snaps across it.

    Raises:
        BadInput: strokes without a tendon. NotConverged: a stroke is too large.
    """
    if inverse and joint.tendon is None:
        return curvature_from_stroke(joint, drive, bending_length)
    stroke, curvature, tension, stretch = (np.empty_like(drive) for _ in range(4))
    for length in np.unique(bending_length):
        rows = bending_length == length
        wanted = drive[rows]
        largest = float(wanted.max())
        if inverse:
            table = loading_branch(joint, effects, float(length), stroke=largest)
            stroke[rows] = wanted
            curvature[rows], tension[rows], stretch[rows] = table.at_stroke(wanted)
        else:
            table = loading_branch(joint, effects, float(length), curvature=largest)
            curvature[rows] = wanted
            stroke[rows], tension[rows], stretch[rows] = table.at_curvature(wanted)
    strain = stretch / (1.0 if joint.tendon is None else joint.tendon.length)
    return StrokeSolution(curvature, stroke, tension, strain, Verdict(converged=True))


def loading_branch(
    joint: Joint, effects: Sequence[Effect], bending_length: float, *, curvature: float = 0.0, stroke: float = 0.0
) -> LoadingBranch:
    """Return the branch at a bending length (m), long enough for a curvature (1/m) and a stroke (m).

    Nodes do not depend on how long it is, so that both directions read the same lines.

    Raises:
        NotConverged: no curvature takes up the stroke.
    """
    ordered = in_order(effects)
    for effect in acting(ordered, OnTubes):
        joint = effect.joint(joint)
    length = float(_driven(ordered, np.zeros(1), bending_length).bending_length[0])
    stations = stations_for(joint, ordered, length, "curvature", 1)
    limit, parts = _FIRST_LIMIT, list[_Nodes]()
    while limit <= _LARGEST_CURVATURE:
        nodes = _nodes(stations, ordered, limit)
        if nodes.mean[0] < limit * (1.0 - _HELD):  # else the table ends before the shape at rest
            further = nodes.beyond(parts[-1].mean[-1] if parts else -np.inf)
            parts += [further] if further.mean.size else []
            found = _branch(_joined(parts), stations, joint, ordered, bending_length)
            if found.curvature.max() >= curvature and (joint.tendon is None or found.stroke.max() >= stroke):
                return found
        limit *= 2.0
    wanted = f"a stroke of {stroke / MILLIMETRE:g} mm" if stroke else f"a curvature of {curvature:g} 1/m"
    raise NotConverged(f"{wanted} lies outside what the corrected model reaches: give a smaller one.")


@dataclass(frozen=True, slots=True)
class _Nodes:
    """Tension (N, (q,)) along a load, curvature of each station (1/m, (q, m)) and its mean; ``released`` to zero, (m,)."""

    tension: FloatArray
    each: FloatArray
    mean: FloatArray
    released: FloatArray

    def beyond(self, curvature: float) -> _Nodes:
        """Return the nodes past a mean curvature."""
        past = self.mean > curvature
        return _Nodes(self.tension[past], self.each[past], self.mean[past], self.released)


def _nodes(stations: Stations, effects: Sequence[Effect], limit: float) -> _Nodes:
    tension, each = branch(stations, effects, 1, limit)
    released = branch(stations, effects, -1, limit)[1][0] if any(effect.reverses for effect in effects) else each[0]
    return _Nodes(tension, each, each @ stations.share, released)


def _joined(parts: Sequence[_Nodes]) -> _Nodes:
    tension, each, mean = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("tension", "each", "mean")
    )
    return _Nodes(tension, each, mean, parts[0].released)


def _branch(
    nodes: _Nodes, stations: Stations, joint: Joint, effects: Sequence[Effect], bending_length: float
) -> LoadingBranch:
    """Return the branch of a joint that starts midway between load and release, and waits there until load pulls it on."""
    tension = nodes.tension
    rest = 0.5 * (nodes.each[0] + nodes.released)
    each = np.maximum(nodes.each, rest)
    curvature = each @ stations.share
    if joint.tendon is None:
        nothing = np.zeros_like(tension)
        return LoadingBranch(nothing, tension, nothing, curvature, _held(tension))
    stretch = tension / joint.tendon.stiffness
    for effect in acting(effects, OnStretch):
        stretch = effect.stretch(stretch, tension, joint)
    path = stations.shortening(nodes.each)
    homed = max((effect.homing() for effect in acting(effects, OnStructure)), default=0.0) * path[0]
    behind = joint.deadband + path - homed + stretch
    waits = np.any(nodes.each < rest, axis=1)
    pulled = np.where(waits, np.maximum(behind - joint.deadband + homed - stations.shortening(each), 0.0), stretch)
    tension = np.where(waits, np.interp(pulled, stretch, tension), tension)
    history = History(None, behind, None, np.full_like(behind, bending_length))
    stroke = behind + sum(
        (effect.slack(tension, history, joint) for effect in acting(effects, OnSlack)), np.zeros_like(tension)
    )
    ideal = LoadingBranch(stroke, tension, pulled, curvature, _held(stroke))
    if np.array_equal(_driven(effects, stroke, bending_length).drive, stroke):
        return ideal
    return _through_actuator(ideal, effects, bending_length)


def _through_actuator(ideal: LoadingBranch, effects: Sequence[Effect], bending_length: float) -> LoadingBranch:
    """Return the branch over the commanded stroke, where the actuator's own error comes before the tendon."""
    if float(np.ptp(ideal.stroke)) > _LONGEST_STROKE:
        raise NotConverged(f"the corrected model wants more than {_LONGEST_STROKE:g} m of stroke: give a smaller one.")
    commanded = np.arange(ideal.stroke[0] - _ACTUATOR_ERROR, ideal.stroke.max(), _STEP)
    curvature, tension, stretch = ideal.at_stroke(_driven(effects, commanded, bending_length).drive)
    moving = np.flatnonzero(curvature > curvature[0])
    first = max(int(moving[0]) - 1, 0) if moving.size else 0
    used = slice(first, None)
    return LoadingBranch(
        commanded[used], tension[used], stretch[used], np.maximum.accumulate(curvature[used]), _held(curvature[used])
    )


def _driven(effects: Sequence[Effect], stroke: FloatArray, bending_length: float) -> History:
    history = History(None, stroke, None, np.full_like(stroke, bending_length))
    for effect in acting(effects, OnDrive):
        history = effect.drive(history)
    return history


def _held(drive: FloatArray) -> FloatArray:
    """Return 1 where a drive that only rises holds the state, 0 where the state jumps across."""
    return np.asarray(drive >= np.maximum.accumulate(drive) - _HELD, dtype=float)


def _ids(effects: Sequence[Effect]) -> str:
    return ", ".join(effect.id for effect in effects)
