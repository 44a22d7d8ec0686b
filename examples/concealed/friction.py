"""What waits when the motion turns round: play with a rolling contact, and friction between actuator and segment."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from examples.concealed.design import Joint

Array = NDArray[np.float64]

# Laws that Transmission knows by effect; a joint has one of them at a time.
FRICTION_EFFECTS = ("capstan_hysteresis", "stribeck_sheath", "drying_sheath")


def rolling_play(x: Array, width: float, sharpness: float) -> Array:
    """Lost motion with a rolling contact: inside the gap the output is carried along by a share that grows at the faces.

    The output y stays in [x, x + width]; with u = (y - x)/width it moves dy = (1 - u)^sharpness dx on loading and
    u^sharpness dx on release, integrated in steps small beside the gap.
    """
    out = np.empty_like(x)
    state = float(x[0])
    last = float(x[0])
    for index, value in enumerate(x.tolist()):
        whole = value - last
        parts = min(int(abs(whole) * sharpness / (0.1 * width)) + 1, 400)
        for part in range(1, parts + 1):
            here = last + whole * part / parts
            u = min(max((state - here + whole / parts) / width, 0.0), 1.0)
            state += whole / parts * ((1 - u) if whole > 0 else u) ** sharpness
            state = min(max(state, here), here + width)
        out[index], last = state, value
    return out


class Transmission:
    """Friction between actuator and segment that turns round with the tendon's motion.

    A propagating capstan front, Dahl's law, a LuGre bristle that breaks away, Maxwell-slip elements; or (outside the
    catalogue) friction that falls with speed or grows with time.
    """

    def __init__(
        self, joint: Joint, length: float, effects: Mapping[str, Mapping[str, object]], rng: np.random.Generator
    ) -> None:
        effect = next((effects[name] for name in FRICTION_EFFECTS if name in effects), None)
        self.law = "none" if effect is None else str(effect["law"])
        self.phi = 0.0 if effect is None else float(effect["log_ratio"])  # type: ignore[arg-type]
        gain = float(joint.gain(length))
        # The configured gain is that of loading, once friction has built up.
        self.gain = gain if self.law in ("none", "drying") else gain * np.exp(-self.phi)
        self.compliance = joint.tendon_compliance
        self.effect: Mapping[str, object] = effect or {}
        self.strength = 1.0
        self.since = 0.0
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
            self.way = 1.0

    def advance(self, elapsed: float, speed: float) -> None:
        """Set what friction is worth at this time (s) and actuator speed (m/s)."""
        if self.law == "drying":
            self.strength = (max(elapsed, 0.0) / self.effect["time_s"]) ** self.effect["exponent"]  # type: ignore[operator]
        elif self.law == "stribeck":
            kinetic = float(self.effect["kinetic_share"])  # type: ignore[arg-type]
            self.strength = kinetic + (1 - kinetic) * np.exp(-abs(speed) * 1e3 / self.effect["knee_mm_per_s"])  # type: ignore[operator]

    def slide(self, travel: float) -> Array:
        """Friction state after the tendon's end has moved to `travel` (m); one is the friction of steady sliding."""
        step = travel - self.travel
        if self.law == "maxwell":
            return np.clip(self.state + step / self.limits, -1, 1)
        target = np.sign(step)
        if self.law == "lugre":
            # Bristles hold more before they slide: the limit falls with the way since the motion turned.
            way = self.since * (target == self.way) + abs(step)
            target = target * (1 + self.effect["stribeck"] * np.exp(-way / (6 * self.limits)))  # type: ignore[operator]
        # ds/dx = (target - s)/limit, integrated exactly over a monotone step.
        return target - (target - self.state) * np.exp(-np.abs(step) / self.limits)

    def keep(self, state: Array, travel: float) -> None:
        """Keep the state of a solved step."""
        step = travel - self.travel
        if step:
            way = float(np.sign(step))
            self.since = (self.since if way == self.way else 0.0) + abs(step)
            self.way = way
        self.state, self.travel = state, travel
