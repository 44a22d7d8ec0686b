"""The strokes that take a corrected joint through a history of curvatures: the forward model of the diagnosis, inverted.

Between the branch of load and that of release the joint waits, so the stroke for a curvature depends on where the joint
comes from. Row by row, each station moves only where a bound pushes it; what then depends on the stroke is a table that
rises, and is read backwards. Where a range of strokes would do, the drive moves least. The forward model itself then
corrects what tables of other nodes, or a rounded wait, leave over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.catalogue import in_order
from coast_cli.effects.effect import Effect, History, acting
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.memory import follow
from coast_cli.effects.stages import OnDrive, OnSlack, OnStretch, OnStructure, OnTubes
from coast_cli.effects.stations import Stations, branch, stations_for
from coast_cli.mechanics.joint import Joint, Tendon
from coast_cli.mechanics.section import FloatArray

_MOST_LENGTHS = 17
_SAME = 1e-9  # relative, of curvatures
_STEP, _MARGIN = 2e-6, 1e-3  # m; nodes of the commanded stroke, and how far they reach past it
_CORRECTIONS, _LEFT = 60, 0.05  # by the forward model, and what may be left over, 1/m: its tables differ by as much
_MOST_PLAY = 0.2  # m; more than any effect's range


@dataclass(frozen=True, slots=True)
class Driven:
    """A history of the drive and what it does, row by row, (n,).

    Attributes:
        stroke: commanded X1, m. tension: at the actuator, N. stretch: of the tendon, m. NaN where nothing holds.
        curvature: that the forward model predicts for these strokes and lengths, 1/m.
        bending_length: commanded X2, m.
    """

    stroke: FloatArray
    tension: FloatArray
    stretch: FloatArray
    curvature: FloatArray
    bending_length: FloatArray


def drive_along(
    joint: Joint, tendon: Tendon, effects: Sequence[Effect], curvature: FloatArray, bending_length: FloatArray
) -> Driven:
    """Return the strokes that hold curvatures (1/m) one after the other at bending lengths (m, above 0), both (n,).

    The joint starts at rest with the tendon just taut. Effects that need a clock must not be among them.
    """
    ordered = in_order(effects)
    changed = joint
    for effect in acting(ordered, OnTubes):
        changed = effect.joint(changed)
    bounds = _bounds(changed, tendon, ordered, curvature, bending_length)
    drive, tension = _through_structure(bounds, changed, tendon, ordered, curvature, bending_length)
    held = np.isfinite(drive)
    behind = _filled(drive, joint.deadband)
    known = _filled(tension, 0.0)
    history = History(None, behind, None, bending_length)
    behind = behind + sum(
        (effect.slack(known, history, changed) for effect in acting(ordered, OnSlack)), np.zeros_like(behind)
    )
    length = np.maximum(2.0 * bending_length - _driven(ordered, behind, bending_length).bending_length, _STEP)
    first = _through_actuator(ordered, behind, length)
    slope = np.maximum(behind - joint.deadband, 0.0) / np.maximum(np.abs(curvature), 1.0)
    commanded, predicted, tension = _corrected(joint, effects, first, length, np.where(held, curvature, np.nan), slope)
    stretch = _stretched(tension, tendon, ordered, changed)
    stroke, tension, stretch = (np.where(held, column, np.nan) for column in (commanded, tension, stretch))
    return Driven(stroke, tension, stretch, predicted, length)


@dataclass(frozen=True, slots=True)
class _Bounds:
    """What load and release hold, (lengths, drives, stations), at bending lengths and drives (m) that rise."""

    lengths: FloatArray
    drives: FloatArray
    low: FloatArray
    high: FloatArray
    stations: tuple[Stations, ...]

    def between(self, length: float) -> tuple[int, int, float]:
        """Return the nodes on both sides of a length and the share of the second."""
        if self.lengths.size == 1:
            return 0, 0, 0.0
        left = int(np.clip(np.searchsorted(self.lengths, length, side="right") - 1, 0, self.lengths.size - 2))
        step = self.lengths[left + 1] - self.lengths[left]
        return left, left + 1, float(np.clip((length - self.lengths[left]) / step, 0.0, 1.0))


def _bounds(
    joint: Joint, tendon: Tendon, effects: Sequence[Effect], curvature: FloatArray, bending_length: FloatArray
) -> _Bounds:
    lengths = np.unique(bending_length)
    if lengths.size > _MOST_LENGTHS:
        lengths = np.linspace(lengths[0], lengths[-1], _MOST_LENGTHS)
    reverses = any(effect.reverses for effect in effects)
    homed = max((effect.homing() for effect in acting(effects, OnStructure)), default=0.0)
    found, sides = [], []
    for length in lengths.tolist():
        stations = stations_for(joint, effects, length, "curvature", 1)
        pair = []
        for direction in (1, -1) if reverses else (1,):
            tension, each = branch(stations, effects, direction, _limit(curvature))
            if direction > 0:
                stations = replace(stations, rest_path=homed * float(stations.shortening(each[0])))
            stretch = _stretched(tension, tendon, effects, joint)
            axis = joint.deadband - stations.rest_path + stations.shortening(each) + stretch
            up = np.maximum.accumulate(axis) if direction > 0 else np.minimum.accumulate(axis[::-1])[::-1]
            pair.append((up, each))
        found.append(replace(stations, rest=0.5 * (pair[0][1][0] + pair[-1][1][0])))
        sides.append((pair[0], pair[-1]))
    drives = np.unique(np.concatenate([axis for pair in sides for axis, _ in pair]))
    low, high = (np.stack([_on(drives, *pair[side]) for pair in sides]) for side in (0, 1))
    return _Bounds(lengths, drives, low, np.maximum(low, high), tuple(found))


def _corrected(
    joint: Joint,
    effects: Sequence[Effect],
    stroke: FloatArray,
    bending_length: FloatArray,
    curvature: FloatArray,
    slope: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return strokes (m), predicted curvatures (1/m) and tensions (N) after the forward model has had the last word.

    What it says is left over moves each stroke by ``slope`` (m per 1/m), halved where it went too far, until nothing is
    or it gets no better.
    """
    layout = Layout("curvature", 1, _limit(curvature[np.isfinite(curvature)]))
    best: tuple[FloatArray, FloatArray, FloatArray] | None = None
    least, before = np.inf, np.zeros_like(curvature)
    for _ in range(_CORRECTIONS):
        found = predict(joint, effects, [History(None, stroke, None, bending_length)], layout)[0]
        predicted = found.response[:, 0]
        left = np.where(np.isfinite(curvature), curvature - predicted, 0.0)
        error = float(np.mean(np.abs(left)))
        if best is None or error < least:
            best, least = (stroke, predicted, found.tension), error
        wrong = np.abs(left) > _LEFT
        if not wrong.any():
            break
        slope, before = np.where(left * before < 0.0, 0.5 * slope, slope), left
        stroke = stroke + np.where(wrong, left * slope, 0.0)
    return best or (stroke, predicted, found.tension)


def _through_structure(
    bounds: _Bounds,
    joint: Joint,
    tendon: Tendon,
    effects: Sequence[Effect],
    curvature: FloatArray,
    bending_length: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the stroke behind actuator and slack (m) and the tension (N); NaN where nothing holds."""
    state = np.asarray(bounds.stations[0].rest)
    share = bounds.stations[0].share
    drive = joint.deadband
    pull = np.linspace(0.0, 1.0, 513) ** 2 * (bounds.drives[-1] - bounds.drives[0] + joint.deadband) * tendon.stiffness
    pulled = _stretched(pull, tendon, effects, joint)
    strokes, tensions = (np.full(curvature.size, np.nan) for _ in range(2))
    for row, (wanted, length) in enumerate(zip(curvature.tolist(), bending_length.tolist(), strict=True)):
        left, right, part = bounds.between(length)
        low, high = ((1.0 - part) * side[left] + part * side[right] for side in (bounds.low, bounds.high))
        mean = np.maximum.accumulate(np.clip(state, low, high) @ share)
        least, most = _strokes_of(mean, bounds.drives, wanted)
        if least is None or most is None:
            continue
        drive = min(max(drive, least), most)
        below, above = (_on(np.array([drive]), bounds.drives, side)[0] for side in (low, high))
        state = np.clip(state, below, above)
        sides = [
            float(one.shortening(state)) * length / one.bending_length - one.rest_path
            for one in (bounds.stations[left], bounds.stations[right])
        ]
        stretch = max(drive - joint.deadband - (1.0 - part) * sides[0] - part * sides[1], 0.0)
        strokes[row], tensions[row] = drive, float(np.interp(stretch, pulled, pull))
    return strokes, tensions


def _strokes_of(mean: FloatArray, drives: FloatArray, wanted: float) -> tuple[float, float] | tuple[None, None]:
    """Return the least and the largest drive at which a rising mean is as wanted; None where it never is."""
    same = _SAME * (1.0 + abs(wanted))
    first = int(np.searchsorted(mean, wanted - same, side="left"))
    last = int(np.searchsorted(mean, wanted + same, side="right"))
    if first == mean.size or last == 0:
        return None, None

    def crossing(right: int) -> float:
        if right in (0, mean.size):
            return float(drives[min(right, mean.size - 1)])
        rise = mean[right] - mean[right - 1]
        part = float(np.clip((wanted - mean[right - 1]) / rise, 0.0, 1.0)) if rise > 0.0 else 1.0
        return float(drives[right - 1] + part * (drives[right] - drives[right - 1]))

    return crossing(first), crossing(last)


def _through_actuator(effects: Sequence[Effect], behind: FloatArray, bending_length: FloatArray) -> FloatArray:
    """Return the commanded strokes that arrive behind the actuator: its error on the way up, and on the way down."""
    if np.array_equal(_driven(effects, behind, bending_length).drive, behind):
        return behind
    top, bottom, reach = float(behind.max()) + _MARGIN, float(behind.min()) - _MARGIN, _MARGIN
    while True:
        commanded = np.arange(bottom - reach, top, _STEP)
        length = np.full(2 * commanded.size, bending_length[0])
        both = _driven(effects, np.concatenate((commanded, commanded[::-1])), length).drive
        up, down = both[: commanded.size], both[: commanded.size - 1 : -1]
        if down[0] <= bottom or reach > _MOST_PLAY:
            break
        reach *= 2.0
    up, down = np.maximum.accumulate(up), np.minimum.accumulate(down[::-1])[::-1]
    rising, falling = np.interp(behind, up, commanded), np.interp(behind, down, commanded)
    step = np.diff(behind, prepend=-np.inf)
    return follow(np.where(step > 0.0, rising, falling), np.where(step < 0.0, falling, rising))


def _driven(effects: Sequence[Effect], stroke: FloatArray, bending_length: FloatArray) -> History:
    history = History(None, stroke, None, bending_length)
    for effect in acting(effects, OnDrive):
        history = effect.drive(history)
    return history


def _stretched(tension: FloatArray, tendon: Tendon, effects: Sequence[Effect], joint: Joint) -> FloatArray:
    stretch = tension / tendon.stiffness
    for effect in acting(effects, OnStretch):
        stretch = effect.stretch(stretch, tension, joint)
    return stretch


def _on(axis: FloatArray, at: FloatArray, values: FloatArray) -> FloatArray:
    """Return the columns of ``values``, given at ``at``, at the places ``axis``."""
    return np.stack([np.interp(axis, at, values[:, column]) for column in range(values.shape[1])], axis=1)


def _filled(values: FloatArray, start: float) -> FloatArray:
    """Return values with NaN replaced by what stood before, as the drive stays there."""
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(values.size), -1))
    return np.where(last < 0, start, values[last])


def _limit(curvature: FloatArray) -> float:
    """Return how far tables must reach, 1/m: past what release would still hold at the largest stroke."""
    return 3.0 * float(np.abs(curvature).max(initial=0.0)) + 5.0
