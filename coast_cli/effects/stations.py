"""Stations along the bending segment: one where all notches are alike, one a notch where they differ or are observed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.effects.effect import Effect, Segment, acting
from coast_cli.effects.stages import OnBranches, OnStructure, OnTransmission
from coast_cli.errors import BadInput
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

_TABLE = 385
_OWN_BEND_SWEEPS = 3
_NEGATIVE = 0.35  # tables reach this part of the limit on the negative side, for a bend against the tendon
_GRID = np.linspace(-_NEGATIVE, 1.0, _TABLE)
_TENSIONS = np.linspace(0.0, 1.0, _TABLE) ** 1.5


@dataclass(frozen=True, slots=True)
class Stations:
    """The segment as m stations from clamp to tip.

    Attributes:
        segment: the moment law's view, shapes (m, 1). bending_length: m. count: notches each station stands for, (m,).
        pitch, cut, lever_arm: m, shape (m,). share: of the segment's bend, (m,), sums to one.
        friction_gain: ln(actuator tension / tension at the segment) of the base model, on load and by it on release.
        resolved: whether every station is one notch. rest_path: tendon path at rest that the stroke does not count, m.
        rest: curvature before the drive moves, midway between what load and release would hold when slack, 1/m, (m,).
        drifted_rest: curvature at rest that a drift of the material has added, 1/m.
        alone: where the middle tube bends without the outer one, (m,); None where nowhere.
    """

    segment: Segment
    bending_length: float
    count: FloatArray
    pitch: FloatArray
    cut: FloatArray
    lever_arm: FloatArray
    share: FloatArray
    friction_gain: float
    resolved: bool
    rest_path: float = 0.0
    rest: FloatArray | None = None
    drifted_rest: float = 0.0
    alone: NDArray[np.bool_] | None = None

    @property
    def rigidity(self) -> float:
        """Of the segment as a whole, N m^2: the mean of its stations, or in series where the outer tube ends on the way."""
        each = self.segment.rigidity[:, 0]
        return float(np.mean(each) if self.alone is None else 1.0 / np.sum(self.share / each))

    @property
    def reach(self) -> float:
        """How far the softest station is bent over the mean of them, where the outer tube ends on the way; else 1."""
        return 1.0 if self.alone is None else self.rigidity / float(np.min(self.segment.rigidity))

    def carried(self, curvature: FloatArray) -> FloatArray:
        """Return the moment over the rigidity (1/m) that holds curvatures (q,) at each station, (q,) or (m, q)."""
        joint = self.segment.joint
        together = joint.softening.carried(curvature)
        if self.alone is None or joint.free is None:
            return together
        return np.where(self.alone[:, np.newaxis], joint.free.softening.carried(curvature), together)

    def shortening(self, curvature: FloatArray) -> FloatArray:
        """Return how far the bend pulls the tendon, m, for curvature (..., m): P (9), chord across each cut."""
        half = curvature * self.pitch / 2.0
        sine = np.sin(half)
        each = self.cut * (1.0 - sine / np.where(half == 0.0, 1.0, half) - (half == 0.0)) + 2.0 * self.lever_arm * sine
        return np.asarray(each @ self.count)


def stations_for(
    joint: Joint,
    effects: Sequence[Effect],
    length: float,
    kind: str,
    columns: int,
    drifted: tuple[float, float] = (1.0, 0.0),
) -> Stations:
    """Return the stations of a joint at one bending length (m).

    Args:
        kind, columns: what is observed; "notch" with k columns wants the k distal notches one by one.
        drifted: factor on the rigidity and curvature at rest, for a drift of the material.
    """
    tube, one_by_one = joint.middle, False
    radius = 0.0 if joint.tendon is None else joint.tendon.radius
    gain = joint.pulley_friction * joint.wrap_angle + length / joint.pitch * np.log(joint.notch_friction)
    if kind == "notch" or tube.is_graded:
        wanted = columns if kind == "notch" else min(max(round(length / joint.pitch), 1), tube.count)
        chosen = slice(tube.count - wanted, tube.count)
        count = np.ones(wanted)
        one_by_one = tube.is_graded or joint.free is not None or any(effect.varies_along for effect in effects)
        if one_by_one:
            pitch, cut, depth_axis = tube.pitch[chosen], tube.cut[chosen], tube.notch.neutral_axis[chosen]
            inertia = tube.series_second_moment[chosen]
        else:
            chosen = slice(tube.count - 1, tube.count)
            count = np.array([float(wanted)])
            pitch, cut, depth_axis = tube.pitch[chosen], tube.cut[chosen], tube.notch.neutral_axis[chosen]
            inertia = tube.series_second_moment[chosen]
    else:
        lumps = max((effect.lumps for effect in acting(effects, OnBranches)), default=1)
        chosen = slice(tube.count - 1, tube.count)
        count = np.full(lumps, length / joint.pitch / lumps)
        pitch, cut = np.full(lumps, joint.pitch), np.full(lumps, joint.cut)
        depth_axis = np.full(lumps, float(np.mean(tube.notch.neutral_axis)))
        inertia = np.full(lumps, tube.series_second_moment[-1])
    alone = None
    if joint.outer is not None:
        beside: FloatArray | float = joint.outer.rigidity_series / joint.outer.youngs_modulus
        if joint.outer_cover is not None:
            alone, count, (pitch, cut, depth_axis, inertia) = _divided(
                joint.outer_cover, length, count, (pitch, cut, depth_axis, inertia), whole=one_by_one
            )
            beside = np.where(alone, 0.0, beside)
        inertia = inertia + beside
    bend_weight = count * pitch
    segment = Segment(
        rigidity=(drifted[0] * joint.youngs_modulus * inertia)[:, np.newaxis],
        bending_length=length,
        joint=joint,
        strain_per_curvature=_of_each(tube.strain_per_curvature, chosen, pitch.size),
        closing_curvature=_of_each(joint.closing_curvature, chosen, pitch.size),
        position=None if pitch.size == 1 else (np.cumsum(bend_weight) - 0.5 * bend_weight)[:, np.newaxis],
    )
    return Stations(
        segment=segment,
        bending_length=length,
        count=count,
        pitch=pitch,
        cut=cut,
        lever_arm=depth_axis + tube.inner_radius - radius,
        share=bend_weight / bend_weight.sum(),
        friction_gain=float(gain),
        resolved=bool(np.all(count == 1.0)),
        drifted_rest=drifted[1],
        alone=alone,
    )


def require_one_shape(joint: Joint, shortest: float, longest: float) -> None:
    """Refuse bending lengths (m) of one history between which the covered share of the segment changes.

    Raises:
        BadInput: the outer tube covers a part of the longest only.
    """
    if joint.free is not None and longest > joint.free.cover and longest > shortest:
        raise BadInput(
            "X2 cannot slide where the outer tube covers a part of the segment only",
            key="joint.outer_cover_mm",
            found=f"X2 from {shortest / MILLIMETRE:g} to {longest / MILLIMETRE:g} mm in one history",
            allowed="one X2 for each history, or none above outer_cover_mm",
        )


def _divided(
    cover: float, length: float, count: FloatArray, columns: tuple[FloatArray, ...], *, whole: bool
) -> tuple[NDArray[np.bool_], FloatArray, tuple[FloatArray, ...]]:
    """Return where the middle tube bends alone, the notches of each station, and further columns, (m,) or (2 m,).

    Args:
        cover: where the outer tube ends, m from the clamp. length: of the segment, which the stations end with, m.
        columns: the pitch first. whole: whether stations are notches that stay whole; else each becomes two, of which one
            may stand for nothing.
    """
    step = count * columns[0]
    ends = length - np.cumsum(step[::-1])[::-1] + step
    if whole:
        return ends - 0.5 * step > cover, count, columns
    covered = np.clip((cover - ends + step) / step, 0.0, 1.0)
    count = np.stack((covered * count, (1.0 - covered) * count), axis=1).reshape(-1)
    return np.tile([False, True], covered.size), count, tuple(np.repeat(column, 2) for column in columns)


def branch(
    stations: Stations, effects: Sequence[Effect], direction: int, curvature_limit: float
) -> tuple[FloatArray, FloatArray]:
    """Return actuator tension (q,) and curvature of each station (q, m) along load (+1) or release (-1)."""
    joint = stations.segment.joint
    exponent = stations.friction_gain + sum(
        effect.friction(direction, joint, stations.bending_length) for effect in acting(effects, OnTransmission)
    )
    gain = float(np.exp(exponent))
    curvature = curvature_limit * stations.reach * _GRID
    moment = stations.segment.rigidity * stations.carried(curvature - stations.drifted_rest)
    for effect in acting(effects, OnStructure):
        moment = effect.moment(moment, np.broadcast_to(curvature, moment.shape), direction, stations.segment)
    if stations.pitch.size == 1:
        rest = float(np.interp(0.0, np.maximum.accumulate(moment[0]), curvature))
        held = np.concatenate(([rest], curvature[curvature > rest]))
        pull = np.concatenate(([0.0], moment[0][curvature > rest]))
        return np.maximum(pull, 0.0) / stations.lever_arm[0] * gain, held[:, np.newaxis]
    return _along(stations, effects, direction, curvature, moment, gain)


def _along(
    stations: Stations,
    effects: Sequence[Effect],
    direction: int,
    curvature: FloatArray,
    moment: FloatArray,
    gain: float,
) -> tuple[FloatArray, FloatArray]:
    """Follow the tension from clamp to tip; each notch takes its part of it by the angle that it has bent."""
    monotone = np.maximum.accumulate(moment, axis=1)
    if direction < 0:
        monotone = np.minimum.accumulate(moment[:, ::-1], axis=1)[:, ::-1]
    friction, own = max((effect.notch_friction() for effect in acting(effects, OnTransmission)), default=(0.0, 0.0))
    ends = monotone[:, -1] / stations.lever_arm
    largest = float(np.max(ends) if stations.alone is None else np.min(ends)) * gain  # no table may end on the way
    tension = _TENSIONS * largest
    here = tension / gain
    bent = np.empty((_TABLE, stations.pitch.size))
    for place in range(stations.pitch.size):
        arm, step = stations.lever_arm[place], stations.count[place] * stations.pitch[place]
        kappa = np.interp(here * arm, monotone[place], curvature)
        share = own if stations.resolved else 0.5
        for _ in range(_OWN_BEND_SWEEPS if friction * share else 0):
            inside = here * np.exp(-direction * friction * share * np.abs(kappa) * step)
            kappa = np.interp(inside * arm, monotone[place], curvature)
        bent[:, place] = kappa
        here = here * np.exp(-direction * friction * np.abs(kappa) * step)
    return tension, bent


def _of_each(values: FloatArray, chosen: slice, size: int) -> FloatArray:
    """Return what the chosen notches have, shape (size, 1)."""
    return np.broadcast_to(values[chosen], (size,))[:, np.newaxis]
