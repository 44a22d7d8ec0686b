"""The fine forward model: a chain from actuator to camera in which every notch bends, sticks and slips by itself.

At each time the actuator tension (or, where friction follows the tendon's own motion, the tension at the segment)
is the only unknown; all memory is explicit in it, so one scalar equation, stroke(tension) = actuator position,
closes a step. Friction that turns round is a propagating capstan front (the tension profile stays inside the cone
exp(+-phi) of its driven end), a Dahl law, or a bank of Maxwell-slip elements. SI throughout. An effect that is
absent leaves its stage the identity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from examples.concealed.design import Joint
from examples.concealed.segment import Array, Effects, Segment, softplus

TOLERANCE_M = 3e-10


@dataclass
class Trace:
    """What happened at every simulated time of one run: actuator tension (N), notch bends (rad), segment length (m).

    `simulated` is the length (m) whose notches were bent; `length` leaves it where a wire pulls.
    """

    tension: Array
    theta: Array
    weight: float
    length: Array
    simulated: float


def play(x: Array, width: float) -> Array:
    """Lost motion: the output follows on loading and waits `width` after each reversal."""
    out = np.empty_like(x)
    state = x[0]
    for index, value in enumerate(x):
        state = min(max(state, value), value + width)
        out[index] = state
    return out


class Transmission:
    """Friction that turns round between actuator and segment: a propagating front, a Dahl law.

    Or Maxwell-slip elements.
    """

    def __init__(
        self, joint: Joint, length: float, effect: Mapping[str, object] | None, rng: np.random.Generator
    ) -> None:
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

    def __init__(
        self, joint: Joint, length: float, effects: Effects, rng: np.random.Generator, largest: float, density: float
    ) -> None:
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
            stretch += (
                soft["extra_compliance"]
                * line.compliance
                * width
                * float(softplus((mean - soft["knee_tension_n"]) / width))
            )
        creep = None
        if self.creep is not None:
            creep = self.creep * self.decay + (1 - self.decay) * self.creep_share * (mean + self.mean_before) / 2
            stretch += float(creep.sum())
        slack = self.slipped
        if left := self.effects.get("tendon_permanent_set"):
            width = left["width_n"]
            peak = max(self.largest_tension, actuator)
            slack += (
                left["slack_um_per_n"]
                * 1e-6
                * width
                * float(
                    softplus((peak - left["threshold_n"]) / width) - softplus(np.array(-left["threshold_n"] / width))
                )
            )
        self.trial = (actuator, mean, entry, nodes, state, notches, elastic, theta, travel, creep)
        return self.joint.deadband + travel + stretch + slack

    mean_before = 0.0

    def commit(self) -> tuple[float, Array]:
        """Keep the trial state of the solved step."""
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


def simulate(
    joint: Joint,
    length: float,
    drive: Array,
    time: Array,
    effects: Effects,
    rng: np.random.Generator,
    *,
    largest: float,
    density: float = 6450.0,
) -> Trace:
    """Run a joint through `drive` (stroke in m, or actuator tension in N for a joint without tendon) at `time` (s)."""
    # The segment is as long as the inner tube leaves it, whatever the stage says.
    length = length + effects.get("bending_length_offset", {}).get("offset_mm", 0.0) * 1e-3
    line = Line(joint, length, effects, rng, largest, density)
    segment = line.segment
    by_tension = joint.tendon_radius == 0
    position = np.asarray(drive, float)
    # A short approach from rest puts every memory on the loading branch before the first row.
    lead = 12
    start = 0.0 if by_tension else min(position[0], joint.deadband)
    approach = np.linspace(start, position[0], lead, endpoint=False)
    clock = np.concatenate([time[0] - np.linspace(0.5, 0, lead, endpoint=False), time])
    position = actuator_position(np.concatenate([approach, position]), effects)
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
        events.apply(segment, clock[k])
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
    return Trace(tensions[lead:], thetas[lead:], segment.weight, lengths[lead:], length)


def _drive_tension(line: Line, tension: float) -> None:
    """Take a tension-driven step; a slip law needs the entry tension that gives the actuator's."""
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


def actuator_position(position: Array, effects: Effects) -> Array:
    """Where the tendon's proximal end really is: screw error, a wrinkled sheath, lost motion."""
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

    def apply(self, segment: Segment, now: float) -> None:
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
        """Return the tendon's end jumps in its glue when tension passes the next threshold."""
        if self.left and tension > self.left[0]:
            self.left.pop(0)
            line.slipped += self.effects["termination_slip"]["step_um"] * 1e-6
            return True
        return False
