"""A second forward model of a tendon-driven joint, for tests alone: it shares no code and no formula table with the package.

The joint is stepped through its history one sample at a time. At each step the segment first sticks; only when the
tension leaves the band that friction can hold does it slip, to the curvature at which the balance is restored (a root,
bracketed). Sections are integrated numerically, knees are sharp, creep and lag are stepped finely. SI throughout.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq

DENSITY = 6450.0
SCREW = 0.635e-3


@dataclass(frozen=True)
class Tube:
    """A notched tube: radii, depth, cut and uncut lengths (m)."""

    ro: float
    ri: float
    depth: float
    cut: float = 0.3e-3
    uncut: float = 0.3e-3

    def strip(self, *, flat: bool = False):
        """Area, neutral axis and second moment of what a notch leaves, by quadrature; radial walls or a flat cut."""
        if flat:
            edge = np.linspace(self.depth - self.ro, self.ro, 20001)
            y = 0.5 * (edge[1:] + edge[:-1])
            bore = np.sqrt(np.maximum(self.ri**2 - y**2, 0.0))
            weight = 2.0 * (np.sqrt(self.ro**2 - y**2) - bore) * np.diff(edge)
        else:
            half = np.arccos((self.depth - self.ro) / self.ro)
            r = self.ri + (np.arange(400) + 0.5) / 400 * (self.ro - self.ri)
            angle = -half + (np.arange(400) + 0.5) / 400 * 2.0 * half
            y = np.outer(r, np.cos(angle)).ravel()
            weight = np.repeat(r, 400) * (self.ro - self.ri) / 400 * 2.0 * half / 400
        area = weight.sum()
        axis = (weight @ y) / area
        return area, axis, weight @ (y - axis) ** 2

    def series(self, *, flat=False, end_share=0.0):
        """Second moment of the average compliance over a pitch."""
        full = np.pi / 4.0 * (self.ro**4 - self.ri**4)
        delta = end_share * self.ro * np.interp(self.depth / self.ro, [1.2, 1.57, 1.75, 1.88], [0.9, 0.73, 0.58, 0.47])
        return (self.cut + self.uncut) / (self.uncut / full + (self.cut + delta) / self.strip(flat=flat)[2])

    @property
    def mass(self):
        """Mass a metre."""
        full = np.pi * (self.ro**2 - self.ri**2)
        return DENSITY * (full * self.uncut + self.strip()[0] * self.cut) / (self.cut + self.uncut)


OUTER = {"OT1": Tube(2.5e-4, 2e-4, 3.14e-4), "OT2": Tube(2.5e-4, 2e-4, 3.5e-4), "OT4": Tube(2.5e-4, 2e-4, 4e-4)}
MIDDLE = {"MT1": Tube(1.8e-4, 1.4e-4, 2.43e-4), "MT3": Tube(1.8e-4, 1.4e-4, 2.87e-4)}


@dataclass(frozen=True)
class Left:
    """What the published model leaves out; everything off by default."""

    release_ratio: float = 1.0  # tension that holds a curvature on release over that on loading
    friction_moment: float = 0.0
    gap: float = 0.0
    screw: tuple[float, float] = (0.0, 0.0)  # amplitude, phase
    wire_knee: tuple[float, float] = (1e9, 0.0)  # tension, how many times softer beyond, less one
    creep: tuple[float, float] = (0.0, 1.0)  # share of the elastic stretch, time constant
    set_per_newton: tuple[float, float] = (0.0, 0.0)  # slack over tension, threshold
    tube_knee: tuple[float, float] = (1e9, 0.0)  # curvature, share of stiffness lost
    closure: tuple[float, float] = (1e9, 0.0)  # curvature, stiffness added
    snap: tuple[float, float, float] = (1e9, 1.0, 0.0)  # moment at which it lets go, and comes back; jump of curvature
    rest: float = 0.0
    tip_force: float = 0.0
    tilt: float = 0.0
    length_error: float = 0.0
    flat: bool = False
    end_share: float = 0.0
    drift: tuple[float, float, float] = (0.0, 0.0, 1.0)  # of stiffness, of the zero, time constant
    lag: float = 0.0
    scale: float = 1.0
    offset: float = 0.0
    bump: tuple[float, float, float] = (0.0, 0.0, 1.0)  # height, stroke, width: no effect of any catalogue
    ripple: tuple[float, float] = (0.0, 1.0)  # height, period in stroke other than the screw's: nor is this


@dataclass(frozen=True)
class Truth:
    """The joint that is recorded and what is left out of its model."""

    left: Left = field(default_factory=Left)
    modulus: float = 42.6e9
    deadband: float = 1.2e-3
    gain: float = float(np.exp(0.2965 * np.pi))
    eta: float = 1.0063
    wire: float = 53.965e9 * np.pi * 3.8e-5**2 / 0.38868


class _Segment:
    """The bending segment and its tendon at one time step: what holds a curvature, and where it sticks or slips."""

    def __init__(self, truth: Truth, outer: Tube, middle: Tube, length: float):
        left = truth.left
        self.left, self.truth, self.middle, self.length = left, truth, middle, length
        inertia = sum(tube.series(flat=left.flat, end_share=left.end_share) for tube in (outer, middle))
        self.arm = middle.strip()[1] + middle.ri - 3.8e-5
        self.pitch = middle.cut + middle.uncut
        self.bending = truth.modulus * inertia
        self.gain = truth.gain * truth.eta ** (length / self.pitch)
        self.place = (np.arange(40) + 0.5) / 40 * length
        self.weight = 9.81 * left.tilt * (outer.mass + middle.mass) if left.tilt else 0.0
        self.snapped = False
        loaded = bool(left.tip_force or left.tilt)
        self.kappa = brentq(lambda k: self.held(k, self.bending), -150.0, 150.0) if loaded else left.rest

    def shortening(self, kappa):
        """Tendon path that the bend takes, notch by notch along chords."""
        turn = kappa * self.pitch
        if abs(turn) < 1e-9:
            return self.length * self.arm * kappa
        chord = 2.0 * (self.middle.cut / turn - self.arm) * np.sin(turn / 2.0)
        return self.length / self.pitch * (self.middle.cut - chord)

    def outside(self, kappa):
        """Mean moment of loads along the arc."""
        if not (self.left.tip_force or self.weight):
            return 0.0
        step = self.length / 40
        x = np.cumsum(np.cos(kappa * self.place)) * step
        found = self.left.tip_force * np.mean(x[-1] - x)
        if self.weight:
            tail = np.cumsum(x[::-1])[::-1] * step - x * (self.length - self.place)
            found += self.weight * np.mean(tail)
        return found

    def held(self, kappa, stiffness):
        """Moment that the tendon must give to hold a curvature, friction aside."""
        left = self.left
        elastic = kappa - left.rest - (left.snap[2] if self.snapped else 0.0)
        elastic -= left.tube_knee[1] * max(kappa - left.tube_knee[0], 0.0)
        elastic += left.closure[1] * max(kappa - left.closure[0], 0.0)
        return stiffness * elastic - self.outside(kappa)

    def pull(self, space):
        """Tension of the wire when the actuator has taken up ``space`` and the bend its part of it."""
        stretch = space - self.shortening(self.kappa)
        force = self.truth.wire * max(stretch, 0.0)
        knee, softer = self.left.wire_knee
        return force if force <= knee else knee + (force - knee) / (1.0 + softer)

    def _slip(self, space, stiffness, gain, friction, reach):
        def balance(kappa):
            self.kappa = kappa
            return self.pull(space) - gain * (self.held(kappa, stiffness) + friction) / self.arm

        low, high = sorted((self.kappa, self.kappa + reach))
        self.kappa = brentq(balance, low, high, xtol=1e-9)

    def settle(self, space, stiffness):
        """Stick, or slip to where the balance is restored; let go or come back where the outer tube does. Return N."""
        left, rub = self.left, self.left.friction_moment
        for _ in range(3):
            force, moment = self.pull(space), self.held(self.kappa, stiffness)
            if force > self.gain * (moment + rub) / self.arm:
                self._slip(space, stiffness, self.gain, rub, 300.0)
            elif force < self.gain * left.release_ratio * (moment - rub) / self.arm:
                self._slip(space, stiffness, self.gain * left.release_ratio, -rub, -300.0)
            moment = self.held(self.kappa, stiffness)
            lets_go = moment < left.snap[1] if self.snapped else moment > left.snap[0]
            if not lets_go:
                break
            self.snapped = not self.snapped
        return self.pull(space)


def simulate(truth: Truth, outer: str, middle: str, length: float, time, stroke, earlier: float = 0.0):
    """Return curvature (1/m) as seen, tension (N) and the largest tension so far, sample by sample."""
    left = truth.left
    segment = _Segment(truth, OUTER[outer], MIDDLE[middle], length + left.length_error)
    curvature, tension, largest = np.empty(len(time)), np.empty(len(time)), earlier
    creep, before, carriage = 0.0, time[0], stroke[0]
    aged = 1.0 - np.exp(-time / left.drift[2])
    for row, (now, x1) in enumerate(zip(time, stroke, strict=True)):
        carriage = min(max(carriage, x1), x1 + left.gap)
        x = carriage + left.screw[0] * np.sin(2.0 * np.pi * carriage / SCREW + left.screw[1])
        stiffness = segment.bending * (1.0 + left.drift[0] * aged[row])
        for _ in range(6 if left.set_per_newton[0] else 1):
            slack = left.set_per_newton[0] * max(largest - left.set_per_newton[1], 0.0)
            force = segment.settle(x - truth.deadband - slack - creep, stiffness)
            largest = max(largest, force)
        if left.creep[0]:
            creep += (1.0 - np.exp(-(now - before) / left.creep[1])) * (left.creep[0] * force / truth.wire - creep)
        before = now
        curvature[row], tension[row] = segment.kappa, force
    return _seen(left, curvature, aged, time, stroke), tension, largest


def _seen(left: Left, curvature, aged, time, stroke):
    """Return what the camera makes of the curvature."""
    value = curvature + left.bump[0] * np.exp(-0.5 * ((stroke - left.bump[1]) / left.bump[2]) ** 2)
    value += left.ripple[0] * np.sin(2.0 * np.pi * stroke / left.ripple[1])
    if left.lag:
        for row in range(1, value.size):
            part = 1.0 - np.exp(-(time[row] - time[row - 1]) / left.lag)
            value[row] = value[row - 1] + part * (value[row] - value[row - 1])
    return left.scale * (value + left.drift[1] * aged) + left.offset


def wrist(friction: float, tension, notches: int = 5, modulus: float = 45e9):
    """Return the bend (rad) of each notch of a tension-driven tube; each sticks or slips by itself, clamp first.

    Friction rubs on both edges of a notch, half of its bend each; what it takes from the tension is what it has to.
    """
    tube = Tube(0.81e-3, 0.70e-3, 1.4e-3, 0.8e-3, 1.2e-3)
    _, axis, inertia = tube.strip()
    arm, spring = axis + tube.ri, modulus * inertia / tube.cut
    bent = np.zeros((len(tension), notches))
    angle = np.zeros(notches)
    for row, force in enumerate(tension):
        here = max(float(force), 0.0)
        for place in range(notches):
            low, high = here * arm / spring, here * arm / spring
            for _ in range(30):
                low = here * arm / spring * np.exp(-friction * low / 2.0)
                high = here * arm / spring * np.exp(friction * high / 2.0)
            angle[place] = min(max(angle[place], low), high)
            pulls = angle[place] * spring / arm
            mobilised = np.log(here / pulls) * 2.0 if pulls > 0.0 and here > 0.0 else 0.0
            here *= np.exp(-np.clip(mobilised, -friction * angle[place], friction * angle[place]))
        bent[row] = angle
    return bent


def stroke_for(curvature: float, length: float, truth: Truth, outer: str = "OT4", middle: str = "MT1") -> float:
    """Return the stroke (m) at which the model with nothing left out reaches a curvature."""
    o, m = OUTER[outer], MIDDLE[middle]
    arm, pitch = m.strip()[1] + m.ri - 3.8e-5, m.cut + m.uncut
    force = truth.gain * truth.eta ** (length / pitch) * truth.modulus * (o.series() + m.series()) * curvature / arm
    turn = curvature * pitch
    short = length / pitch * (m.cut - 2.0 * (m.cut / turn - arm) * np.sin(turn / 2.0))
    return truth.deadband + short + force / truth.wire


def sweep(top: float, rate: float, step: float, holds: float = 0.0):
    """Return time (s) and stroke (m): up to ``top``, halfway back, up again, a hold, down to zero, a hold."""
    legs = [(0.0, top), (top, 0.45 * top), (0.45 * top, 0.8 * top), (0.8 * top, 0.0)]
    stroke = [np.linspace(a, b, max(2, round(abs(b - a) / step)), endpoint=False) for a, b in legs]
    still = max(0, round(holds * rate / step))
    stroke.insert(1, np.full(still, top))
    path = np.concatenate([*stroke, np.zeros(1 + still // 2)])
    return np.arange(path.size) * step / rate, path


def noise(rng, size: int, level: float, colour: str):
    """Return noise of a level: white, first-order autoregressive with memory 0.8, or white upon a slow walk."""
    white = rng.standard_normal(size)
    if colour == "white":
        return level * white
    if colour == "ar":
        out = np.empty(size)
        value = white[0]
        for row, new in enumerate(white):
            value = 0.8 * value + 0.6 * new if row else new
            out[row] = value
        return level * out
    walk = np.cumsum(rng.standard_normal(size))
    walk -= np.linspace(walk[0], walk[-1], size)
    return level * (0.85 * white + 0.5 * walk / max(walk.std(), 1e-12))
