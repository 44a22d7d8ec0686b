"""The fine forward model: a chain from actuator to camera in which every notch bends, sticks and slips by itself.

At each time the actuator tension (or, where friction follows the tendon's own motion, the tension at the segment) is the only
unknown; all memory is explicit in it, so one scalar equation, stroke(tension) = actuator position, closes a step. Friction that
turns round is a propagating capstan front (the tension profile stays inside the cone exp(+-phi) of its driven end), a Dahl
law, or a bank of Maxwell-slip elements. SI throughout. An effect that is absent leaves its stage the identity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from examples.concealed.design import Joint, chord_shortening, ring, sector

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, object]]
TOLERANCE_M = 3e-10


@dataclass
class Trace:
    """What happened at every simulated time of one run: actuator tension (N), notch bends (rad), segment length (m)."""

    tension: Array
    theta: Array
    weight: float
    length: Array
    extra: dict[str, Array] = field(default_factory=dict)


def softplus(x: Array) -> Array:
    return np.logaddexp(0.0, x)


def play(x: Array, width: float) -> Array:
    """Lost motion: the output follows on loading and waits `width` after each reversal."""
    out = np.empty_like(x)
    state = x[0]
    for index, value in enumerate(x):
        state = min(max(state, value), value + width)
        out[index] = state
    return out


class BendingLaw:
    """Elastic moment (per unit EI, 1/m) against curvature: linear, softening, stiffening; smooth and inverted by a table."""

    def __init__(self, effects: Effects, largest: float) -> None:
        self.linear = not ({"tube_superelasticity", "notch_closure"} & effects.keys())
        if self.linear:
            return
        grid = np.linspace(0, 3 * largest, 1501)
        stiffness = np.ones_like(grid)
        if soft := effects.get("tube_superelasticity"):
            stiffness -= (1 - soft["stiffness_ratio"]) / (1 + np.exp(-(grid - soft["knee_curvature_per_m"]) / soft["width_per_m"]))
        if closing := effects.get("notch_closure"):
            stiffness += closing["stiffness_rise"] / (1 + np.exp(-(grid - closing["contact_curvature_per_m"]) / closing["width_per_m"]))
        self.grid = grid
        self.moment = np.concatenate([[0], np.cumsum((stiffness[1:] + stiffness[:-1]) / 2 * np.diff(grid))])

    def __call__(self, moment: Array) -> Array:
        """Curvature (1/m) under `moment` over EI (1/m); odd in its argument."""
        if self.linear:
            return moment
        return np.sign(moment) * np.interp(np.abs(moment), self.moment, self.grid)


class Segment:
    """Bending segment of one run: notch friction, moment balance, snap, contact; explicit in the tension at its entry."""

    def __init__(self, joint: Joint, length: float, effects: Effects, rng: np.random.Generator, largest: float, density: float) -> None:
        self.joint, self.effects, self.length = joint, effects, length
        pitch = joint.middle.pitch
        exact = length / pitch
        self.count = max(4, round(exact))
        self.weight = exact / self.count
        self.pitch = pitch
        spread = 1 + 0.001 * rng.standard_normal(self.count) * (0.0 if joint.tendon_radius == 0 else 1.0)
        self.compliance = spread / spread.mean()
        self.law = BendingLaw(effects, largest)
        self.arm, self.rigidity = joint.arm, joint.rigidity
        self.notch_mu = float(effects.get("distributed_notch_friction", {}).get("friction", 0.0))
        coulomb = effects.get("coulomb_friction")
        self.coulomb = None if coulomb is None else coulomb["moment_n_mm"] * 1e-3 * np.exp(
            coulomb["spread"] * rng.standard_normal(self.count) - coulomb["spread"] ** 2 / 2)
        snap = effects.get("snap_through")
        self.snaps = 0 if snap is None else int(snap["groups"])
        self.snap_group = np.arange(self.count) % max(self.snaps, 1)
        self.snap_order = 1 + 0.04 * np.arange(max(self.snaps, 1))
        weight = 0.0
        if "gravity" in effects:
            weight = sum(_weight(tube, density) for tube in (joint.outer, joint.middle) if tube) * effects["gravity"]["in_plane"]
        self.gravity = weight
        self.tip_load = effects.get("tip_load")
        self.natural = float(effects.get("precurvature", {}).get("curvature_per_m", 0.0))
        self.outside_load = bool(weight) or self.tip_load is not None
        self.cracked = np.ones(self.count)
        self.softening = 1.0
        self.shift = 0.0
        # State committed after each step.
        self.tension = np.zeros(self.count)
        self.elastic = np.zeros(self.count)
        self.theta = np.zeros(self.count)
        self.snapped = np.zeros(max(self.snaps, 1), dtype=bool)
        self.load_moment = np.zeros(self.count)
        self.rest = 0.0
        if self.outside_load or self.natural:
            for _ in range(30):
                self.refresh_load()
                self.theta = self.bend(0.0)[2]
            self.rest = self.chord(self.theta)
            self.elastic = self.bend(0.0)[1]

    def refresh_load(self) -> None:
        """Moment of weight and tip force in the present shape, at mid-notch (N m)."""
        if not self.outside_load:
            return
        step = self.pitch * self.weight
        angle = np.cumsum(self.theta * self.weight) - self.theta * self.weight / 2
        x, y = np.cumsum(np.cos(angle)) * step, np.cumsum(np.sin(angle)) * step
        moment = np.zeros(self.count)
        if self.gravity:
            tail = np.arange(self.count, 0, -1)
            moment -= self.gravity * step * (np.cumsum(x[::-1])[::-1] - tail * x)
        if self.tip_load is not None:
            force, tilt = self.tip_load["force_mn"] * 1e-3, self.tip_load["tilt_rad"]
            moment += force * (np.cos(tilt) * (x[-1] - x) - np.sin(tilt) * (y[-1] - y))
        self.load_moment = moment

    def bend(self, entry: float) -> tuple[Array, Array, Array]:
        """Tension at the notches, elastic moment and bend of each notch for a tension at the segment's entry."""
        theta = self.theta
        if self.notch_mu:
            for _ in range(3):
                phi = self.notch_mu * np.cumsum(np.abs(theta)) * self.weight
                tension = np.clip(self.tension, entry * np.exp(-phi), entry * np.exp(phi))
                elastic = self._elastic(tension)
                theta = self._theta(elastic)
            return tension, elastic, theta
        tension = np.full(self.count, entry)
        elastic = self._elastic(tension)
        return tension, elastic, self._theta(elastic)

    def _elastic(self, tension: Array) -> Array:
        moment = tension * self.arm + self.load_moment
        if self.coulomb is None:
            return moment
        return np.clip(self.elastic, moment - self.coulomb, moment + self.coulomb)

    def _theta(self, elastic: Array) -> Array:
        curvature = self.law(elastic / (self.rigidity * self.softening)) * self.compliance * self.cracked + self.natural + self.shift
        if self.snaps:
            curvature = curvature + self.effects["snap_through"]["jump_per_m"] * self.snapped[self.snap_group]
        return curvature * self.pitch

    def chord(self, theta: Array) -> float:
        return float(chord_shortening(theta, self.joint.middle.cut, self.arm).sum()) * self.weight - self.rest

    def commit(self, tension: Array, elastic: Array, theta: Array) -> None:
        self.tension, self.elastic, self.theta = tension, elastic, theta
        self.refresh_load()

    def snap(self, entry: float) -> bool:
        """Let go (or come back) where the moment passed a threshold; true when something moved."""
        if not self.snaps:
            return False
        snap = self.effects["snap_through"]
        up, down = snap["release_tension_n"] * self.snap_order, snap["return_tension_n"] * self.snap_order
        after = np.where(self.snapped, entry > down, entry > up)
        moved = bool(np.any(after != self.snapped))
        self.snapped = after
        return moved


def _weight(tube: object, density: float) -> float:
    """Weight per length (N/m) of a notched tube at 9.81 m/s^2."""
    area = (tube.uncut * ring(tube)[0] + tube.cut * sector(tube)[0]) / tube.pitch  # type: ignore[attr-defined]
    return 9.81 * density * area


class Transmission:
    """Friction that turns round between actuator and segment: a propagating front, a Dahl law, or Maxwell-slip elements."""

    def __init__(self, joint: Joint, length: float, effect: Mapping[str, object] | None, rng: np.random.Generator) -> None:
        self.law = "none" if effect is None else str(effect["law"])
        self.phi = 0.0 if effect is None else float(effect["log_ratio"])  # type: ignore[arg-type]
        gain = float(joint.gain(length))
        self.gain = gain * np.exp(-self.phi) if effect is not None else gain
        self.compliance = joint.tendon_compliance
        if effect is None:
            return
        if self.law == "front":
            parts = rng.dirichlet(np.full(int(effect["pulleys"]), 4.0))  # type: ignore[call-overload]
            self.cone = np.cumsum(np.repeat(parts, 6) / 6) * self.phi
            self.nodes = np.zeros(self.cone.size)
            self.far = float(effect["far_share"])  # type: ignore[arg-type]
        else:
            scale = float(effect["presliding_um"]) * 1e-6  # type: ignore[arg-type]
            self.limits = scale * np.array([0.3, 0.8, 1.6, 3.0]) if self.law == "maxwell" else np.array([scale])
            self.state = np.ones(self.limits.size)
            self.travel = 0.0

    def slide(self, travel: float) -> Array:
        """Friction state in [-1, 1] after the tendon's end has moved to `travel` (m)."""
        step = travel - self.travel
        if self.law == "maxwell":
            return np.clip(self.state + step / self.limits, -1, 1)
        # Dahl's law integrated exactly over a monotone step.
        target = np.sign(step)
        return target - (target - self.state) * np.exp(-np.abs(step) / self.limits)


class Line:
    """Actuator, tendon and segment of one run, stepped through time."""

    def __init__(self, joint: Joint, length: float, effects: Effects, rng: np.random.Generator, largest: float, density: float) -> None:
        self.joint, self.effects = joint, effects
        self.segment = Segment(joint, length, effects, rng, largest, density)
        self.transmission = Transmission(joint, length, effects.get("capstan_hysteresis"), rng)
        self.largest_tension = 0.0
        creep = effects.get("tendon_creep")
        self.creep = None
        if creep is not None:
            self.tau = creep["time_constant_s"] * np.array([0.4, 1.0, 2.5])
            self.creep_share = creep["stretch_ratio"] * joint.tendon_compliance * np.array([0.25, 0.5, 0.25])
            self.creep = np.zeros(3)
        self.slipped = 0.0
        self.previous = 0.0
        self.speed = 0.0
        self.decay = np.zeros(3)
        self.trial: tuple[object, ...] = ()

    def stroke(self, tension: float) -> float:
        """Actuator position (m) that `tension` asks for; the trial state is kept for `commit`. Monotone in tension."""
        line, segment = self.transmission, self.segment
        nodes = state = None
        if line.law == "front":
            actuator = tension
            nodes = np.clip(line.nodes, actuator * np.exp(-line.cone), actuator * np.exp(line.cone))
            entry = float(nodes[-1]) / line.gain
            mean = actuator * (1 - line.far) + line.far * float(nodes.mean())
        else:
            entry = tension
        notches, elastic, theta = segment.bend(entry)
        travel = segment.chord(theta)
        if line.law == "front":
            pass
        elif line.law == "none":
            actuator = mean = entry * line.gain
        else:
            state = line.slide(travel)
            actuator = mean = entry * line.gain * float(np.exp(line.phi * state.mean()))
        drag = self.effects.get("viscous_friction")
        if drag is not None:
            actuator = mean = max(actuator + drag["drag_n_s_per_mm"] * 1e3 * self.speed, 0.0)
        stretch = mean * line.compliance
        if soft := self.effects.get("tendon_superelasticity"):
            width = soft["width_n"]
            stretch += soft["extra_compliance"] * line.compliance * width * float(softplus((mean - soft["knee_tension_n"]) / width))
        creep = None
        if self.creep is not None:
            creep = self.creep * self.decay + (1 - self.decay) * self.creep_share * (mean + self.mean_before) / 2
            stretch += float(creep.sum())
        slack = self.slipped
        if left := self.effects.get("tendon_permanent_set"):
            width = left["width_n"]
            peak = max(self.largest_tension, actuator)
            slack += left["slack_um_per_n"] * 1e-6 * width * float(
                softplus((peak - left["threshold_n"]) / width) - softplus(np.array(-left["threshold_n"] / width)))
        self.trial = (actuator, mean, entry, nodes, state, notches, elastic, theta, travel, creep)
        return self.joint.deadband + travel + stretch + slack

    mean_before = 0.0

    def commit(self) -> tuple[float, Array]:
        actuator, mean, entry, nodes, state, notches, elastic, theta, travel, creep = self.trial
        self.segment.commit(notches, elastic, theta)
        line = self.transmission
        if nodes is not None:
            line.nodes = nodes
        if state is not None:
            line.state, line.travel = state, travel
        if creep is not None:
            self.creep = creep
        self.mean_before = mean
        self.entry = entry
        self.largest_tension = max(self.largest_tension, actuator)
        return actuator, theta

    def solve(self, position: float, guess: float, slope: float) -> float:
        """Tension (N) at which the line reaches `position` (m): bracketed secant."""
        low, f_low = 0.0, self.stroke(0.0) - position
        if f_low >= 0:
            return 0.0
        high, f_high = np.inf, np.inf
        trial = max(guess, 1e-9)
        for _ in range(60):
            error = self.stroke(trial) - position
            if abs(error) < TOLERANCE_M:
                return trial
            if error < 0:
                low, f_low = trial, error
            else:
                high, f_high = trial, error
            step = trial - error / slope
            if np.isinf(high):
                trial = max(step, trial + 1e-9) if error < 0 else step
                if error < 0:
                    trial = low - f_low / slope * 1.3 + 1e-9
            else:
                secant = low - f_low * (high - low) / (f_high - f_low)
                trial = step if low < step < high and high - low > 1e-3 * high and _ < 3 else secant
                if _ > 6 and _ % 2:
                    trial = (low + high) / 2
            if high - low < 1e-12:
                break
        self.stroke(trial)
        return trial


def simulate(joint: Joint, length: float, drive: Array, time: Array, effects: Effects, rng: np.random.Generator, *,
             largest: float, density: float = 6450.0) -> Trace:
    """Run a joint through `drive` (stroke in m, or actuator tension in N for a joint without tendon) at `time` (s)."""
    line = Line(joint, length, effects, rng, largest, density)
    segment = line.segment
    by_tension = joint.tendon_radius == 0
    position = np.asarray(drive, float)
    # A short approach from rest puts every memory on the loading branch before the first row.
    lead = 12
    start = 0.0 if by_tension else min(position[0], joint.deadband)
    approach = np.linspace(start, position[0], lead, endpoint=False)
    clock = np.concatenate([time[0] - np.linspace(0.5, 0, lead, endpoint=False), time])
    position = actuator_position(np.concatenate([approach, position]), clock, length, effects)
    count = position.size
    tensions, thetas, lengths = np.zeros(count), np.zeros((count, segment.count)), np.full(count, length)
    scale = joint.gain(length) * joint.rigidity / joint.arm
    slope = joint.tendon_compliance + joint.arm * length / scale
    if line.transmission.law != "front":
        slope = slope * line.transmission.gain
    events = _Events(effects, rng, segment.count, time)
    unknown = 0.0
    for k in range(count):
        dt = clock[k] - clock[k - 1] if k else 0.1
        if line.creep is not None:
            line.decay = np.exp(-dt / line.tau)
        line.speed = (position[k] - position[k - 1]) / max(dt, 1e-9) if k else 0.0
        events.apply(segment, clock[k], line)
        if by_tension:
            _drive_tension(line, float(position[k]))
        else:
            step = (position[k] - position[k - 1]) / slope if k else 0.0
            unknown = line.solve(position[k], unknown + step, slope)
            for _ in range(8):
                if not (segment.snap(float(line.trial[2])) or events.slip(line, float(line.trial[0]))):  # type: ignore[arg-type]
                    break
                unknown = line.solve(position[k], unknown, slope)
        tensions[k], thetas[k] = line.commit()
        if "wire_pull_coupling" in effects:
            lengths[k] = length - effects["wire_pull_coupling"]["pull_mm_per_n"] * 1e-3 * tensions[k]
    lengths = lengths + effects.get("bending_length_offset", {}).get("offset_mm", 0.0) * 1e-3
    return Trace(tensions[lead:], thetas[lead:], segment.weight, lengths[lead:])


def _drive_tension(line: Line, tension: float) -> None:
    """A tension-driven step: the front is explicit; a slip law needs the entry tension that gives the actuator's."""
    if line.transmission.law in ("none", "front"):
        line.stroke(tension if line.transmission.law == "front" else tension / line.transmission.gain)
        while line.segment.snap(float(line.trial[2])):  # type: ignore[arg-type]
            line.stroke(tension if line.transmission.law == "front" else tension / line.transmission.gain)
        return
    low = tension * np.exp(-line.transmission.phi) / line.transmission.gain
    high = tension * np.exp(line.transmission.phi) / line.transmission.gain
    for _ in range(36):
        middle = (low + high) / 2
        line.stroke(middle)
        low, high = (middle, high) if line.trial[0] < tension else (low, middle)  # type: ignore[operator]


def actuator_position(position: Array, time: Array, length: float, effects: Effects) -> Array:
    """Where the tendon's proximal end really is: screw error, lost motion, coupling to the inner tube's stage."""
    if screw := effects.get("leadscrew_pitch_error"):
        phase = 2 * np.pi * position / (screw["period_mm"] * 1e-3) + screw["phase_rad"]
        position = position + screw["amplitude_um"] * 1e-6 * (np.sin(phase) + 0.12 * np.sin(2 * phase + 1.0))
    if wrinkle := effects.get("wrinkled_sheath"):
        turns = (np.maximum(position, 0) / (wrinkle["span_mm"] * 1e-3)) ** wrinkle["exponent"] * wrinkle["turns"]
        position = position + wrinkle["amplitude_um"] * 1e-6 * np.sin(2 * np.pi * turns)
    if lost := effects.get("backlash"):
        width = lost["width_mm"] * 1e-3
        position = np.mean([play(position, width * f) for f in (0.92, 1.0, 1.08)], axis=0)
    return position


class _Events:
    """Slow or sudden changes of the segment with time: heat, cracks, slips, hardening, a bumped camera."""

    def __init__(self, effects: Effects, rng: np.random.Generator, count: int, time: Array) -> None:
        self.effects = effects
        self.span = float(time[-1] - time[0])
        self.begin = float(time[0])
        self.crack = effects.get("notch_crack")
        self.where = rng.permutation(count)
        self.left = list(effects.get("termination_slip", {}).get("at_tension_n", ()))
        self.path = 0.0
        self.last = 0.0

    def apply(self, segment: Segment, now: float, line: Line) -> None:
        elapsed = max(now - self.begin, 0.0)
        soft = 1.0
        if drift := self.effects.get("thermal_drift"):
            grown = 1 - np.exp(-elapsed / drift["time_constant_s"])
            if drift["acts_on"] == "stiffness":
                soft *= 1 + drift["change"] * grown
            else:
                segment.shift = drift["change"] * grown
        if room := self.effects.get("room_temperature_cycle"):
            soft *= 1 + room["change"] * np.sin(2 * np.pi * elapsed / room["period_s"])
        if hard := self.effects.get("work_hardening"):
            self.path += abs(float(segment.theta.sum()) - self.last)
            self.last = float(segment.theta.sum())
            soft *= 1 + hard["rise"] * (1 - np.exp(-self.path / hard["path_rad"]))
        segment.softening = soft
        if self.crack and elapsed >= self.crack["at_share"] * self.span:
            broken = self.where[: max(1, round(self.crack["notch_share"] * segment.count))]
            segment.cracked[broken] = self.crack["compliance_ratio"]

    def slip(self, line: Line, tension: float) -> bool:
        """The tendon's end jumps in its glue when tension passes the next threshold."""
        if self.left and tension > self.left[0]:
            self.left.pop(0)
            line.slipped += self.effects["termination_slip"]["step_um"] * 1e-6
            return True
        return False
