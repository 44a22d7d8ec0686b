"""Which pairs would jump, by what, at which stroke and how far: forecasts of ``mechanics.snap`` for a bench.

The bending segment is what the middle tube has beyond the inner tube's tip, its last X2; the outer tube lies over it. Its
rest shape is equation (8) of P for that length, clamped at the inner tube's tip. The tendon pulls towards the notches of
the middle tube, the way that its natural curvature bends it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.limits import some_joint
from coast_cli.design.reach import require_covered
from coast_cli.errors import NotConverged
from coast_cli.mechanics.beam import NO_EQUILIBRIUM
from coast_cli.mechanics.joint import friction_gain
from coast_cli.mechanics.pairs import pair_table
from coast_cli.mechanics.section import FloatArray, strip_across
from coast_cli.mechanics.snap import (
    Crossing,
    RollingPair,
    TendonInBore,
    crossing,
    largest_roll_index,
    roll_begins,
    rolled,
)
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.spec.build import Design
from coast_cli.units import DEGREE, MILLIMETRE

POISSON = 0.33  # of nitinol
LENGTH, CURVATURE = 0.04, 40.0  # m, 1/m: the point of the paper's largest stroke, where [checks] names none
FORECAST = "forecasts from the energy of ideal segments, checked against chains of links but against no robot."


@dataclass(frozen=True)
class Snaps:
    """Forecasts of every pair, shape (middle tubes, outer tubes); NaN where nothing jumps, or a beam was not solved.

    Attributes:
        bending_length: X2, m. rest: curvature of the segment without tension, 1/m, positive towards the tendon.
        crossing: of the tendon through its bore. crossing_stroke: commanded, m.
        roll_index: largest on the way to the curvature that is looked at. roll_bend: at which it first passes 1, 1/m.
        roll_stroke: commanded there, m. roll: largest roll of the tips against each other on that way, rad.
    """

    bending_length: float
    rest: FloatArray
    crossing: Crossing
    crossing_stroke: FloatArray
    roll_index: FloatArray
    roll_bend: FloatArray
    roll_stroke: FloatArray
    roll: FloatArray

    @property
    def margin(self) -> FloatArray:
        """How far the nearer of both forecasts is from a jump: 1 for not at all, below 0 where it jumps."""
        return np.asarray(1.0 - np.maximum(self.crossing.index, self.roll_index))

    @property
    def by_roll(self) -> NDArray[np.bool_]:
        """Whether roll is the nearer forecast."""
        return np.asarray(self.roll_index > self.crossing.index)

    @property
    def stroke(self) -> FloatArray:
        """Commanded stroke at which the nearer forecast jumps, m."""
        return np.where(self.by_roll, self.roll_stroke, self.crossing_stroke)

    @property
    def crossing_jump(self) -> FloatArray:
        """Bend that the tendon's crossing lets go, rad."""
        return (self.crossing.after - self.crossing.before) * self.bending_length

    @property
    def jump(self) -> FloatArray:
        """How far the nearer forecast goes: bend of a crossing, roll of the tips, rad."""
        return np.where(self.by_roll, self.roll, self.crossing_jump)


def snaps(design: Design, bending_length: float | None = None) -> Snaps | None:
    """Return the forecasts of every pair of a design, or None without a pair, a [joint] or a [tendon].

    Args:
        bending_length: X2, m; None is that of ``checks.max_stroke_mm``, else 40 mm, at most the notched length.
    """
    config = design.config
    if config.joint is None or config.tendon is None or not design.outer or not design.middle:
        return None
    point = None if config.checks is None else config.checks.max_stroke_mm
    asked = LENGTH if point is None else point.bending_length_mm * MILLIMETRE
    longest = min(tube.length for tube in (*design.outer, *design.middle))
    length = min(asked if bending_length is None else bending_length, longest)
    return _snaps(design, length, CURVATURE if point is None else point.curvature_per_m)


def _snaps(design: Design, length: float, largest: float) -> Snaps:
    joint = some_joint(design.config)
    tendon = joint.tendon
    if tendon is None:
        raise design.config.refuse((), "a forecast of jumps needs a [tendon] table")
    require_covered(joint, length)
    own = [replace(joint, middle=tube) for tube in design.middle]
    rest, outer, middle = _sections(design, length, joint.youngs_modulus)
    gain, arm = (
        np.array(column)[:, None] for column in ([friction_gain(o, length) for o in own], [o.lever_arm for o in own])
    )
    play = np.array([tube.inner_radius - tendon.radius for tube in design.middle])[:, None]
    rigidity, stiffness = outer[0] + middle[0], tendon.stiffness / gain
    spread = np.broadcast_arrays(rest, rigidity, length, arm - play, play, stiffness)
    found = crossing(TendonInBore(*spread))
    natural = [np.array([-tube.natural_curvature for tube in tubes]) for tubes in (design.outer, design.middle)]
    plane, across, torsion = zip(outer, middle, strict=True)
    pairs = RollingPair((natural[0][None, :], natural[1][:, None]), plane, across, torsion, length)
    index, at = largest_roll_index(pairs, largest)
    begins, roll = np.full(rest.shape, np.nan), np.full(rest.shape, np.nan)
    for here in zip(*np.nonzero(index > 1.0), strict=True):
        one = _picked(pairs, here)
        begins[here], roll[here] = roll_begins(one, float(at[here])), rolled(one, float(at[here]))
    path = (begins - pairs.rest) * (rigidity / arm / stiffness + length * arm)
    return Snaps(length, rest, found, joint.deadband + found.stroke, index, begins, joint.deadband + path, roll)


def _sections(design: Design, length: float, modulus: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the rest curvature of each segment (1/m, NaN where unsolved), and the rigidities of its tubes, (3, m, o)."""
    shape = len(design.middle), len(design.outer)
    rest, outer, middle = np.full(shape, np.nan), np.empty((3, *shape)), np.empty((3, *shape))
    ends = np.array([tube.length for tube in design.middle])
    for end in np.unique(ends):
        rows = np.flatnonzero(ends == end)
        ones = [_last(tube, float(end), length) for tube in design.outer]
        twos = [_last(design.middle[row], float(end), length) for row in rows]
        solved = pair_table(ones, twos, design.gravity)
        over = np.minimum(*np.meshgrid([tube.length for tube in ones], [tube.length for tube in twos]))
        rest[rows] = np.where(solved.converged, -solved.signed_precurvature / over, np.nan)
        outer[:, rows] = np.transpose([_rigidities(tube, modulus) for tube in ones])[:, None, :]
        middle[:, rows] = np.transpose([_rigidities(tube, modulus) for tube in twos])[:, :, None]
    return rest, outer, middle


def _picked(pairs: RollingPair, here: tuple[int, ...]) -> RollingPair:
    """Return one pair of many."""
    shape = pairs.rigidity[0].shape

    def own(both: tuple[FloatArray, FloatArray]) -> tuple[float, float]:
        first, second = (float(np.broadcast_to(part, shape)[here]) for part in both)
        return first, second

    return RollingPair(own(pairs.natural), own(pairs.rigidity), own(pairs.across), own(pairs.torsion), pairs.length)


def _last(tube: NotchedTube, end: float, length: float) -> NotchedTube:
    """Return what a tube has over the last ``length`` before ``end`` from the clamp (m), in whole notches, at least one."""
    ends = np.cumsum(tube.pitch)
    slack = 1e-6 * length
    chosen = (ends <= end + slack) & (ends > end - length + slack)
    chosen[np.argmin(np.abs(ends - end))] = True
    spread = np.broadcast_to(tube.end_length, tube.depth.shape)
    depth, cut, uncut, spread = (part[chosen] for part in (tube.depth, tube.cut, tube.uncut, spread))
    return replace(tube, depth=depth, cut=cut, uncut=uncut, end_length=spread)


def _rigidities(tube: NotchedTube, modulus: float) -> tuple[float, float, float]:
    """Return rigidity in the plane of the notches, across it, and in torsion, all in series, N m^2."""
    across, torsion = strip_across(tube.outer_radius, tube.inner_radius, tube.depth, tube.section)
    ring = float(tube.row.ring.second_moment[0, 0])

    def series(strip: FloatArray) -> float:
        return tube.length / float(np.sum(tube.cut / strip + tube.uncut / ring))

    polar = tube.length / float(np.sum(tube.cut / torsion + tube.uncut / (2.0 * ring)))
    plane = tube.rigidity_series / tube.youngs_modulus
    return modulus * plane, modulus * series(across), modulus / (2.0 * (1.0 + POISSON)) * polar


def snap_rows(design: Design, bending_length: float | None = None) -> list[dict[str, Any]]:
    """Return two rows a pair, one for each mechanism, in the order of the samples S1, S2, ...

    Raises:
        BadInput: there is no pair, no [joint] or no [tendon].
        NotConverged: a beam under gravity was not solved.
    """
    found = snaps(design, bending_length)
    if found is None:
        allowed = "[outer], [middle], [joint] and [tendon] tables"
        raise design.config.refuse((), "a forecast of jumps needs pairs, a joint and its tendon", allowed=allowed)
    if np.isnan(found.rest).any():
        raise NotConverged(f"a segment of {found.bending_length / MILLIMETRE:g} mm: {NO_EQUILIBRIUM}.")
    rows = []
    for row, middle in enumerate(design.middle):
        for column, outer in enumerate(design.outer):
            here = row, column
            pair = {
                "sample": f"S{row * len(design.outer) + column + 1}",
                "outer": outer.name,
                "middle": middle.name,
                "bending_length_mm": found.bending_length / MILLIMETRE,
                "rest_curvature_per_m": float(found.rest[here]),
                "leading_tube": "outer" if found.rest[here] < 0.0 else "middle",
            }
            jump = found.crossing
            values = (1.0 - jump.index[here], found.crossing_stroke[here] / MILLIMETRE, jump.before[here])
            rows.append(pair | _forecast("crossing", *values, jump.after[here], found.crossing_jump[here] / DEGREE))
            values = (1.0 - found.roll_index[here], found.roll_stroke[here] / MILLIMETRE, found.roll_bend[here])
            rows.append(pair | _forecast("roll", *values, np.nan, found.roll[here] / DEGREE))
    return rows


def _forecast(mechanism: str, margin: float, stroke: float, before: float, after: float, jump: float) -> dict[str, Any]:
    known = {"margin": margin, "stroke_mm": stroke, "before_per_m": before, "after_per_m": after, "jump_deg": jump}
    return {"mechanism": mechanism} | {name: float(x) if np.isfinite(x) else None for name, x in known.items()}
