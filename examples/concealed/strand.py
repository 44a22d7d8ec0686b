"""The tendon's stretch beyond Hooke: plateau, creep, set, compliance of the cable, strands that lie down or rub.

Explicit in the tension; what remembers is committed once a step is solved. SI.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from examples.concealed.friction import Array

Effects = Mapping[str, Mapping[str, object]]
LIMITS = np.array([0.25, 0.6, 1.0, 1.6])


class Strand:
    """The tendon of one run."""

    def __init__(self, compliance: float, effects: Effects) -> None:
        self.compliance, self.effects = compliance, effects
        self.largest = self.before = 0.0
        self.creep = np.zeros(3)
        self.rubbing = np.zeros(LIMITS.size)
        self.decay, self.speed = np.zeros(3), 0.0
        self.trial: tuple[float, float, Array, Array] = (0.0, 0.0, self.creep, self.rubbing)
        self.idle = not effects.keys() & {
            "tendon_superelasticity",
            "tendon_creep",
            "tendon_permanent_set",
            "transmission_compliance",
            "braid_bedding",
            "braid_friction",
            "cable_speed_stiffening",
        }

    def advance(self, dt: float, speed: float) -> None:
        """Go to the next time step of `dt` (s) at an actuator speed (m/s)."""
        self.speed = abs(speed) * 1e3
        if creep := self.effects.get("tendon_creep"):
            self.decay = np.exp(-dt / (creep["time_constant_s"] * np.array([0.4, 1.0, 2.5])))

    def beyond_hooke(self, tension: float, actuator: float) -> float:
        """Return the elongation (m) beyond Hooke's at a mean tension and the actuator's (N)."""
        if self.idle:
            return 0.0
        out = self._elastic(tension)
        creep, rubbing, peak = self.creep, self.rubbing, max(self.largest, actuator)
        if slow := self.effects.get("tendon_creep"):
            share = slow["stretch_ratio"] * self.compliance * np.array([0.25, 0.5, 0.25])
            creep = self.creep * self.decay + (1 - self.decay) * share * (tension + self.before) / 2
            out += float(creep.sum())
        if left := self.effects.get("tendon_permanent_set"):
            past = max(peak - left["threshold_n"], 0.0) / left["scale_n"]
            out += left["slack_um_per_n"] * 1e-6 * left["scale_n"] * past ** left["power"]
        if braid := self.effects.get("braid_friction"):
            limits = braid["limits_n"] * LIMITS
            rubbing = np.clip(self.rubbing, tension - limits, tension + limits)
            out += braid["share"] * self.compliance * float(rubbing.mean())
        self.trial = (peak, tension, creep, rubbing)
        return float(out)

    def _elastic(self, tension: float) -> float:
        """Return the elongation (m) that remembers nothing."""
        out = 0.0
        if soft := self.effects.get("tendon_superelasticity"):
            # Grains yield one by one, evenly between two tensions: the mean of max(T - knee, 0) over them.
            low, high = (soft["knee_tension_n"] * (1 + side * soft["spread"]) for side in (-1, 1))
            inside = min(max(tension - low, 0.0), high - low)
            past = inside**2 / (2 * (high - low)) + max(tension - high, 0.0)
            out += soft["extra_compliance"] * self.compliance * past
        if cable := self.effects.get("transmission_compliance"):
            hard = 1 - cable["hardening"] * tension / (tension + cable["scale_n"])
            out += cable["compliance_ratio"] * self.compliance * tension * hard
        if bed := self.effects.get("braid_bedding"):
            out += bed["slack_um"] * 1e-6 * -float(np.expm1(-tension / bed["scale_n"]))
        if fast := self.effects.get("cable_speed_stiffening"):
            out -= fast["rise"] * self.compliance * tension * self.speed / (self.speed + fast["knee_mm_per_s"])
        return out

    def commit(self) -> None:
        """Keep the trial state of the solved step."""
        self.largest, self.before, self.creep, self.rubbing = self.trial
