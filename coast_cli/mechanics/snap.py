"""Forecasts of a pair that jumps: the tendon that crosses its bore, and the outer tube that rolls about the middle one.

Both act while the tendon pulls a pair straight that the outer tube bends the other way, and on nothing else that the
joint model has. They are forecasts: derived here from the energy of an elastic segment of constant sections, checked
against chains of links (``tests/validation/test_snap_chain.py``), and not against a robot.

*Crossing.* Where the pair is bent away from its tendon, the taut tendon lies on the far wall of the middle tube's bore, at a
smaller lever arm. With h its place in the bore (|h| <= play, h = play at both ends), curvature k = rest + T (axis + h)/EI and
tendon equilibrium h'' = -k, i.e. h'' + q^2 (h + axis) = -rest with q^2 = T/EI: the tube buckles against its own tendon. The
straight state exists from q_B^2 = -rest/(axis + play) on; if then q_B L > pi, the segment is still bent away there. It
jumps when the two arcs of tendon that cross the bore, one from each end, meet: at rising tension, or, in a long segment,
after they have travelled inwards at the tension q^2 = -rest/axis.
Clearance between the tubes adds no jump of its own: the energy of two beams one in the other is convex in the plane.

*Roll.* As for concentric tubes (Dupont, Lock, Itkowitz and Butler, IEEE T-RO 26, 2010; Webster, Romano and Cowan, IEEE
T-RO 25, 2009): opposed curvatures wish to roll by half a turn and torsion resists, which holds while
L sqrt(S/G) < pi/2. Here the sections are notched, so they also resist a bend across their notches, and the tendon turns with
the middle tube: S = (m - k B_outer)(m + k B_middle)/(B_outer + B_middle), m = EI_outer (k - k_outer), B the rigidity
across, 1/G = 1/GJ_outer + 1/GJ_middle. Without notches and tendon it is their c.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from coast_cli.mechanics.section import FloatArray

Number = Any  # a float, or an array of the shape of the pairs
_FIELDS = ("rest", "rigidity", "length", "axis", "play", "stiffness")
_HALVINGS = 44
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)


@dataclass(frozen=True, slots=True)
class TendonInBore:
    """A segment and its tendon; SI, numbers or arrays of one shape.

    Attributes:
        rest: curvature without tension, 1/m; below zero the segment is bent away from the tendon.
        rigidity: N m^2. length: m. axis: from the tube's axis to the neutral axis, away from the tendon, m.
        play: how far the tendon can move to either side of the tube's axis, m.
        stiffness: of the tendon at the segment: its own over the friction gain, N/m.
    """

    rest: FloatArray
    rigidity: FloatArray
    length: FloatArray
    axis: FloatArray
    play: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True, slots=True)
class Crossing:
    """A forecast jump of the tendon; NaN where none is.

    Attributes:
        index: length over the shortest that jumps: no jump up to 1. tension: at the segment, N.
        stroke: that the tendon has taken from the rest shape, m. before, after: mean curvature, 1/m, at that stroke.
    """

    index: FloatArray
    tension: FloatArray
    stroke: FloatArray
    before: FloatArray
    after: FloatArray


def crossing(segment: TendonInBore) -> Crossing:
    """Return the jump of each segment whose tendon crosses its bore."""
    rest, _, length, axis, play, _ = spread = np.broadcast_arrays(*(getattr(segment, name) for name in _FIELDS))
    index = np.asarray(length * np.sqrt(np.maximum(-rest, 0.0) / (axis + play)) / np.pi)
    found = np.full((4, *index.shape), np.nan)
    long = index > 1.0
    if long.any():
        found[:, long] = _jumping(TendonInBore(*(column[long] for column in spread)))
    return Crossing(index, *found)


def _jumping(segment: TendonInBore) -> FloatArray:
    """Return tension, stroke and curvatures of segments long enough to jump, shape (4, n); NaN where the stroke holds it."""
    away, arm = -segment.rest, segment.axis + segment.play
    wave = _jump(away, segment, np.sqrt(away / arm))
    tension = segment.rigidity * wave**2
    mean, path = _at_the_jump(away, segment, wave)
    rest_path = -segment.length * away * _mean_arm_at_rest(away, segment)
    stroke = tension / segment.stiffness + path - rest_path
    pulled = (stroke + rest_path + segment.length * arm * away) / (
        1.0 / segment.stiffness + segment.length * arm**2 / segment.rigidity
    )
    after = -away + pulled * arm / segment.rigidity
    return np.where(after > mean, np.stack((tension, stroke, mean, after)), np.nan)


def _balance(away: FloatArray, segment: TendonInBore, wave: FloatArray) -> FloatArray:
    """Return the place in the bore at which the segment would be straight, m."""
    return np.asarray(away / wave**2 - segment.axis)


def _arc(away: FloatArray, segment: TendonInBore, wave: FloatArray) -> FloatArray:
    """Return the length over which the tendon goes from one wall to the other, m."""
    balance = _balance(away, segment, wave)
    return np.asarray(np.arccos(np.clip((balance - segment.play) / (balance + segment.play), -1.0, 1.0)) / wave)


def _jump(away: FloatArray, segment: TendonInBore, straight: FloatArray) -> FloatArray:
    """Return q at the jump: two arcs fill the segment, or each is half a wave and travels."""
    low, high = straight, np.sqrt(away / segment.axis)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        short = 2.0 * _arc(away, segment, middle) < segment.length
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return np.asarray(high)


def _at_the_jump(away: FloatArray, segment: TendonInBore, wave: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return mean curvature (1/m) and tendon path (m) just before the jump: two arcs that meet, the rest has crossed."""
    arc = np.minimum(_arc(away, segment, wave), 0.5 * segment.length)
    balance = _balance(away, segment, wave)
    along = 0.5 * arc * (_NODES[:, None] + 1.0).reshape(-1, *np.ones(np.ndim(arc), dtype=int))
    swing = balance + segment.play
    place, slope = balance - swing * np.cos(wave * along), wave * swing * np.sin(wave * along)
    weight = _WEIGHTS.reshape(-1, *np.ones(np.ndim(arc), dtype=int)) * arc  # both arcs
    crossed = segment.length - 2.0 * arc

    def bend(at: FloatArray) -> FloatArray:
        return -away + wave**2 * (segment.axis + at)

    flat = bend(segment.play)
    mean = (flat * crossed + (weight * bend(place)).sum(axis=0)) / segment.length
    path = flat * (segment.axis + segment.play) * crossed
    path = path + (weight * (bend(place) * (segment.axis + place) - 0.5 * slope**2)).sum(axis=0)
    return np.asarray(mean), np.asarray(path)


def _mean_arm_at_rest(away: FloatArray, segment: TendonInBore) -> FloatArray:
    """Return the mean lever arm (tendon path over bend) of a slack tendon drawn taut in the rest shape, m."""
    play, length = segment.play, segment.length
    arc = np.minimum(2.0 * np.sqrt(play / away), 0.5 * length)
    lying = length - 2.0 * arc
    floor = np.where(lying > 0.0, -play, play - away * length**2 / 8.0)
    path = (floor * lying + 2.0 * (floor * arc + away * arc**3 / 6.0)) + away * arc**3 / 3.0
    return np.asarray(segment.axis + path / length)


@dataclass(frozen=True, slots=True)
class RollingPair:
    """Two tubes one in the other, bent in one plane by natural curvatures and by the tendon in the middle one; SI.

    Numbers, or arrays of one shape for many pairs.

    Attributes:
        natural: curvatures of outer and middle tube towards the tendon, 1/m. rigidity, across, torsion: of each: in the
            plane of its notches and across it, and in torsion, N m^2. length: m.
    """

    natural: tuple[Number, Number]
    rigidity: tuple[Number, Number]
    across: tuple[Number, Number]
    torsion: tuple[Number, Number]
    length: float

    @property
    def rest(self) -> Number:
        """Curvature without tension, 1/m."""
        (one, two), (first, second) = self.rigidity, self.natural
        return (one * first + two * second) / (one + two)

    @property
    def shear(self) -> Number:
        """Torsional rigidity of both tubes against each other, N m^2."""
        one, two = self.torsion
        return one * two / (one + two)


def roll_index(pair: RollingPair, curvature: Number) -> FloatArray:
    """Return L sqrt(S/G)/(pi/2) where the tendon holds a curvature (1/m): the pair stays in its plane up to 1."""
    moment = pair.rigidity[0] * (curvature - pair.natural[0])
    one, two = pair.across
    wish = (moment - curvature * one) * (moment + curvature * two) / (one + two)
    return np.asarray(pair.length * np.sqrt(np.maximum(wish, 0.0) / pair.shear) / (0.5 * np.pi))


def largest_roll_index(pair: RollingPair, largest: float) -> tuple[FloatArray, FloatArray]:
    """Return the largest index on the way from rest to a curvature (1/m), and the curvature where it is."""
    plane, (one, two) = pair.rigidity[0], pair.across
    with np.errstate(divide="ignore", invalid="ignore"):
        turning = plane * pair.natural[0] * (2.0 * plane - one + two) / (2.0 * (plane - one) * (plane + two))
    end = np.maximum(largest, pair.rest)
    bends = np.stack(np.broadcast_arrays(pair.rest, end, np.clip(np.nan_to_num(turning), pair.rest, end)))
    found = np.stack([roll_index(pair, bend) for bend in bends])
    best = np.argmax(found, axis=0)[None]
    return np.take_along_axis(found, best, axis=0)[0], np.take_along_axis(bends, best, axis=0)[0]


def roll_begins(pair: RollingPair, at: float, count: int = 4097) -> float:
    """Return the curvature (1/m) from rest to ``at``, where the index is above 1, at which it passes 1."""
    bends = np.linspace(pair.rest, at, count)
    index = roll_index(pair, bends)
    first = int(np.argmax(index > 1.0))
    return float(bends[0] if first == 0 else np.interp(1.0, index[first - 1 : first + 1], bends[first - 1 : first + 1]))


def rolled(pair: RollingPair, curvature: float, count: int = 721) -> float:
    """Return the roll of the tips against each other (rad) that the tendon's moment at ``curvature`` leads to; 0 for none.

    The energy at each roll is that of the best bend in space; the length that a tip roll takes is then an integral.
    """
    tip = np.linspace(0.0, np.pi, count)[1:-1]
    moment = sum(pair.rigidity) * (curvature - pair.rest)
    phase = 0.25 * np.pi * (_NODES + 1.0)
    along = tip[:, None] * np.sin(phase)
    fallen = _energy(pair, along, moment) - _energy(pair, tip, moment)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = tip[:, None] * np.cos(phase) / np.sqrt(2.0 * np.where(fallen > 0.0, fallen, np.nan) / pair.shear)
    length = 0.25 * np.pi * rate @ _WEIGHTS
    if not float(roll_index(pair, np.asarray(curvature))) > 1.0:
        return 0.0
    reached = np.flatnonzero(~(length < pair.length))
    if reached.size == 0:
        return float(np.pi)
    last = int(reached[0])
    if last == 0 or not np.isfinite(length[last]):
        return float(tip[last])
    part = (pair.length - length[last - 1]) / (length[last] - length[last - 1])
    return float(tip[last - 1] + part * (tip[last] - tip[last - 1]))


def _energy(pair: RollingPair, roll: FloatArray, moment: float) -> FloatArray:
    """Return the bending energy (N) at each roll of the outer tube against the middle one, at the best bend in space."""
    (outer, middle), (over, under) = pair.rigidity, pair.across
    sine, cosine = np.sin(roll), np.cos(roll)
    xx = outer * cosine**2 + over * sine**2 + middle
    yy = outer * sine**2 + over * cosine**2 + under
    xy = (outer - over) * sine * cosine
    pull_x = outer * pair.natural[0] * cosine + middle * pair.natural[1] + moment
    pull_y = outer * pair.natural[0] * sine
    gained = yy * pull_x**2 - 2.0 * xy * pull_x * pull_y + xx * pull_y**2
    return np.asarray(-0.5 * gained / (xx * yy - xy**2))
