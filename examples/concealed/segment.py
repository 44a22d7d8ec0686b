"""The bending segment, notch by notch: moment balance, friction along the tendon, friction between tubes, snap.

Weight.

Everything is explicit in the tension at the segment's entry; what remembers is committed once a step is solved. SI.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from examples.concealed.bending import BendingLaw, Memory
from examples.concealed.design import Joint, Tube, chord_shortening, ring, sector

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, object]]


class Segment:
    """Bending segment of one run, explicit in the tension at its entry."""

    def __init__(
        self, joint: Joint, length: float, effects: Effects, rng: np.random.Generator, largest: float, density: float
    ) -> None:
        self.joint, self.effects, self.length = joint, effects, length
        pitch = joint.middle.pitch
        exact = length / pitch
        self.count = max(4, round(exact))
        self.weight = exact / self.count
        self.pitch = pitch
        spread = 1 + 0.001 * rng.standard_normal(self.count) * (0.0 if joint.tendon_radius == 0 else 1.0)
        self.compliance = spread / spread.mean()
        if along := effects.get("stiffness_along"):
            # Counted from the tip: the inner tube uncovers more of the proximal part when it is drawn back.
            behind = length * (1 - (np.arange(self.count) + 0.5) / self.count)
            band = np.exp(-(((behind * 1e3 - along["at_mm"]) / along["width_mm"]) ** 2))
            self.compliance = self.compliance * (1 + along["change"] * band)
        self.law = BendingLaw(joint, effects, largest, rng, self.count)
        self.memory = Memory(joint, effects, self.count)
        self.arm, self.rigidity = joint.arm, joint.rigidity
        self.notch_mu = np.zeros(0)
        if rubbing := effects.get("distributed_notch_friction"):
            uneven = np.exp(rubbing["spread"] * rng.standard_normal(self.count))
            self.notch_mu = rubbing["friction"] * uneven / uneven.mean()
        coulomb = effects.get("coulomb_friction")
        self.coulomb = (
            None
            if coulomb is None
            else coulomb["moment_n_mm"]
            * 1e-3
            * np.exp(coulomb["spread"] * rng.standard_normal(self.count) - coulomb["spread"] ** 2 / 2)
        )
        snap = effects.get("snap_through")
        self.snaps = 0 if snap is None else int(snap["groups"])
        self.snap_group = np.arange(self.count) % max(self.snaps, 1)
        self.snap_order = 1 + 0.04 * np.arange(max(self.snaps, 1))
        weight = 0.0
        if "gravity" in effects:
            weight = (
                sum(_weight(tube, density) for tube in (joint.outer, joint.middle) if tube)
                * effects["gravity"]["in_plane"]
            )
        self.gravity = weight
        self.tip_load = effects.get("tip_load")
        self.natural = np.zeros(self.count)
        if rest := effects.get("precurvature"):
            share = (np.arange(self.count) + 0.5) / self.count
            self.natural += rest["curvature_per_m"] * (1 + rest["lean"] * (2 * share - 1))
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
        if self.outside_load or self.natural.any():
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
        if self.notch_mu.size:
            for _ in range(3):
                phi = np.cumsum(self.notch_mu * np.abs(theta)) * self.weight
                tension = np.clip(self.tension, entry * np.exp(-phi), entry * np.exp(phi))
                elastic = self._elastic(tension)
                theta = self._theta(elastic)
            return tension, elastic, theta
        tension = np.full(self.count, entry)
        elastic = self._elastic(tension)
        return tension, elastic, self._theta(elastic)

    def _elastic(self, tension: Array) -> Array:
        moment = tension * self.arm + self.load_moment
        limit = self.coulomb
        if pressed := self.effects.get("pressed_tubes"):
            limit = pressed["share"] * moment**2 / (pressed["full_n_mm"] * 1e-3)
        if limit is None:
            return moment
        return np.clip(self.elastic, moment - limit, moment + limit)

    def _theta(self, elastic: Array) -> Array:
        moment = elastic / (self.rigidity * self.softening)
        curvature = self.law(moment) * self.compliance * self.cracked + self.natural + self.shift
        if not self.memory.idle:
            curvature = curvature + self.memory.added(moment)
        if self.snaps:
            curvature = curvature + self.effects["snap_through"]["jump_per_m"] * self.snapped[self.snap_group]
        return curvature * self.pitch

    def chord(self, theta: Array) -> float:
        """Return the tendon's shortening over the segment (m), from the shape at rest."""
        return float(chord_shortening(theta, self.joint.middle.cut, self.arm).sum()) * self.weight - self.rest

    def commit(self, tension: Array, elastic: Array, theta: Array) -> None:
        """Keep the trial state of the solved step."""
        self.tension, self.elastic, self.theta = tension, elastic, theta
        self.memory.commit()
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


def _weight(tube: Tube, density: float) -> float:
    """Weight per length (N/m) of a notched tube at 9.81 m/s^2."""
    area = (tube.uncut * ring(tube)[0] + tube.cut * sector(tube)[0]) / tube.pitch
    return 9.81 * density * area
