"""The fine forward model: a chain from actuator to camera in which every notch bends, sticks and slips by itself.

At each time the actuator tension (or, where friction follows the tendon's own motion, the tension at the segment)
is the only unknown; all memory is explicit in it, so one scalar equation, stroke(tension) = actuator position,
closes a step. `drive` holds what happens before the tendon, `strand` the tendon, `friction` the way to the segment,
`segment` and `bending` the notches, `camera` and `faults` what is seen. SI throughout. An effect that is absent leaves
its stage the identity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from examples.concealed.design import Joint
from examples.concealed.drive import actuator_position
from examples.concealed.faults import breathing
from examples.concealed.friction import Transmission
from examples.concealed.segment import Array, Effects, Segment
from examples.concealed.strand import Strand

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


class Line:
    """Actuator, tendon and segment of one run, stepped through time."""

    def __init__(
        self, joint: Joint, length: float, effects: Effects, rng: np.random.Generator, largest: float, density: float
    ) -> None:
        self.joint, self.effects = joint, effects
        self.segment = Segment(joint, length, effects, rng, largest, density)
        self.transmission = Transmission(joint, length, effects, rng)
        self.strand = Strand(joint.tendon_compliance, effects)
        self.position = self.speed = 0.0
        self.trial: tuple[object, ...] = ()

    def advance(self, position: float, speed: float, dt: float, elapsed: float) -> None:
        """Go to the next time step: commanded position (m) and speed (m/s), step and time since the start (s)."""
        self.position, self.speed = position, speed
        self.transmission.advance(elapsed, speed)
        self.strand.advance(dt, speed)
        self.segment.memory.advance(dt)

    def stroke(self, tension: float) -> float:
        """Actuator position (m) that `tension` asks for; the trial state is kept for `commit`. Monotone in tension."""
        line, segment = self.transmission, self.segment
        nodes = state = None
        if line.law == "front":
            nodes = np.clip(line.nodes, tension * np.exp(-line.cone), tension * np.exp(line.cone))
            entry = float(nodes[-1]) / line.gain
        else:
            entry = tension
        notches, elastic, theta = segment.bend(entry)
        travel = segment.chord(theta)
        if nodes is not None:
            actuator = tension
            mean = actuator * (1 - line.far) + line.far * float(nodes.mean())
        elif line.law == "none":
            actuator = mean = entry * line.gain
        else:
            state = line.slide(travel)
            actuator = mean = entry * line.gain * float(np.exp(line.phi * line.strength * state.mean()))
        ratio, drag = self._sheath(theta)
        actuator, mean = max(actuator * ratio + drag, 0.0), max(mean * ratio + drag, 0.0)
        stretch = mean * line.compliance + self.strand.beyond_hooke(mean, actuator)
        self.trial = (actuator, nodes, state, notches, elastic, theta, travel)
        return self.joint.deadband + travel + stretch

    def _sheath(self, theta: Array) -> tuple[float, float]:
        """Return what multiplies and what is added (N) to the tension between segment and actuator, without memory."""
        ratio, drag = 1.0, 0.0
        if kinked := self.effects.get("kinked_sheath"):
            bend = float(theta.sum()) * self.segment.weight / kinked["full_rad"]
            ratio *= float(np.exp(kinked["log_ratio"] * min(bend * bend, 4.0)))
        if round_ := self.effects.get("eccentric_pulley"):
            turn = 2 * np.pi * self.position / (round_["period_mm"] * 1e-3) + round_["phase_rad"]
            ratio *= 1 + round_["amplitude"] * float(np.sin(turn))
        if oil := self.effects.get("viscous_friction"):
            # A lubricant that thins as it is sheared (Carreau).
            fast = (self.speed * 1e3 / oil["knee_mm_per_s"]) ** 2
            drag += oil["drag_n_s_per_mm"] * self.speed * 1e3 * (1 + fast) ** ((oil["thinning"] - 1) / 2)
        return ratio, drag

    def commit(self) -> tuple[float, Array]:
        """Keep the trial state of the solved step."""
        actuator, nodes, state, notches, elastic, theta, travel = self.trial
        self.segment.commit(notches, elastic, theta)
        if nodes is not None:
            self.transmission.nodes = nodes
        if state is not None:
            self.transmission.keep(state, travel)
        self.strand.commit()
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
    run: int = -1,
) -> Trace:
    """Run a joint through `drive` (stroke in m, or actuator tension in N for a joint without tendon) at `time` (s).

    `run` is the run's number, for faults of one run.
    """
    # The segment is as long as the inner tube leaves it, whatever the stage says.
    length = length + effects.get("bending_length_offset", {}).get("offset_mm", 0.0) * 1e-3
    if (label := effects.get("bending_length_label")) and label["run"] == run:
        length = length + label["label_off_mm"] * 1e-3
    line = Line(joint, length, effects, rng, largest, density)
    segment = line.segment
    by_tension = joint.tendon_radius == 0
    position = np.asarray(drive, float)
    # A short approach from rest puts every memory on the loading branch before the first row.
    lead = 12
    start = 0.0 if by_tension else min(position[0], joint.deadband)
    approach = np.linspace(start, position[0], lead, endpoint=False)
    clock = np.concatenate([time[0] - np.linspace(0.5, 0, lead, endpoint=False), time])
    commanded = np.concatenate([approach, position])
    position = actuator_position(commanded, clock, effects, run)
    count = position.size
    tensions, thetas, lengths = np.zeros(count), np.zeros((count, segment.count)), np.full(count, length)
    scale = joint.gain(length) * joint.rigidity / joint.arm
    slope = joint.tendon_compliance + joint.arm * length / scale
    if line.transmission.law != "front":
        slope = slope * line.transmission.gain
    # The approach belongs to no recording: its speed would be an accident of its length.
    speed = np.concatenate([np.zeros(lead), np.gradient(commanded[lead:], time)])
    events = _Events(effects, rng, segment.count, time, largest)
    unknown = 0.0
    for k in range(count):
        line.advance(commanded[k], speed[k], clock[k] - clock[k - 1] if k else 0.1, clock[k] - time[0])
        events.apply(segment, clock[k])
        if by_tension:
            _drive_tension(line, float(position[k]))
        else:
            step = (position[k] - position[k - 1]) / slope if k else 0.0
            unknown = line.solve(position[k], unknown + step, slope)
            for _ in range(8):
                if not segment.snap(float(line.trial[3].mean())):  # type: ignore[attr-defined]
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
        while line.segment.snap(float(line.trial[3].mean())):  # type: ignore[attr-defined]
            line.stroke(tension if line.transmission.law == "front" else tension / line.transmission.gain)
        return
    low = tension * np.exp(-line.transmission.phi) / line.transmission.gain
    high = tension * np.exp(line.transmission.phi) / line.transmission.gain
    for _ in range(36):
        middle = (low + high) / 2
        line.stroke(middle)
        low, high = (middle, high) if line.trial[0] < tension else (low, middle)  # type: ignore[operator]


class _Events:
    """Slow or sudden changes of the segment with time: heat, a crack, hardening, breathing."""

    def __init__(self, effects: Effects, rng: np.random.Generator, count: int, time: Array, largest: float) -> None:
        self.effects = effects
        self.begin, self.span, self.last_time = float(time[0]), float(time[-1] - time[0]), float(time[0])
        self.crack = effects.get("notch_crack")
        self.where = rng.permutation(count)
        self.largest = largest
        self.housing = self.tube = 0.0
        self.path = self.last = 0.0

    def apply(self, segment: Segment, now: float) -> None:
        elapsed = max(now - self.begin, 0.0)
        soft, shift = 1.0, 0.0
        if drift := self.effects.get("thermal_drift"):
            self._warm(drift, max(now - self.last_time, 0.0))
            if drift["acts_on"] == "stiffness":
                soft *= 1 + drift["change"] * self.tube
            else:
                shift += drift["change"] * self.tube
        if (swing := self.effects.get("periodic_disturbance")) and swing["acts_on"] == "structure":
            shift += swing["amplitude"] * self.largest * float(breathing(np.array(now), swing))
        if hard := self.effects.get("work_hardening"):
            self.path += abs(float(segment.theta.sum()) - self.last)
            self.last = float(segment.theta.sum())
            soft *= 1 + hard["rise"] * (1 - np.exp(-self.path / hard["path_rad"]))
        segment.softening, segment.shift, self.last_time = soft, shift, max(now, self.begin)
        if self.crack and elapsed >= self.crack["at_share"] * self.span:
            broken = self.where[: max(1, round(self.crack["notch_share"] * segment.count))]
            segment.cracked[broken] = self.crack["compliance_ratio"]

    def _warm(self, drift: object, dt: float) -> None:
        """Warm two masses in a row for `dt` (s) towards one."""
        before = self.housing
        self.housing = 1 - (1 - before) * np.exp(-dt / drift["housing_s"])
        mean = (before + self.housing) / 2
        self.tube = mean + (self.tube - mean) * np.exp(-dt / drift["tube_s"])
