"""A third forward model of a tendon-driven joint, for tests of laws without a name: fibres with a history, and a clock.

It shares no code and no formula with the package. Strips are cut into fibres that transform between two plateaus, a sheath
drags with speed, a pulley may run out of round, a tendon may wear: each row's curvature is the root of one balance. SI.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from coast_cli.recordings.model import JointRun
from tests.independent_joint import MIDDLE, OUTER, Truth

PITCH_OVER_CUT = 2.0
TRUTH = Truth()


@dataclass(frozen=True)
class World:
    """What the published model leaves out; everything off by default.

    Attributes:
        plateaus: stress over modulus at which fibres transform and come back; none where the first is infinite.
        drag: moment over bending stiffness for 1/m of curvature a second, s. thinning: speed (1/m/s) beyond which it saturates.
        pulley: amplitude (m) and period (m) of the stroke's error. wear: tendon length for a path of the drive.
    """

    plateaus: tuple[float, float] = (np.inf, np.inf)
    drag: float = 0.0
    thinning: float = 1e9
    pulley: tuple[float, float] = (0.0, 1e-3)
    wear: float = 0.0


class _Strip:
    """One strip as fibres: their distance from its axis, their area, and what of each has transformed."""

    def __init__(self, tube, count=60):
        half = np.arccos((tube.depth - tube.ro) / tube.ro)
        angle = half * ((np.arange(count) + 0.5) / count * 2.0 - 1.0)
        y = 0.5 * (tube.ro + tube.ri) * np.cos(angle)
        self.area = np.full(count, tube.strip()[0] / count)
        self.y = y - np.average(y, weights=self.area)
        self.transformed = np.zeros(count)

    def after(self, curvature, plateaus, hardening=0.04):
        """Return what of each fibre's strain has transformed at a strip's curvature, from where it was."""
        strain = np.abs(curvature * self.y)
        low, high = ((strain - level) / (1.0 + hardening) for level in plateaus)
        return np.maximum(np.clip(self.transformed, low, high), 0.0)

    def relief(self, curvature, plateaus):
        """Return the bending moment over the modulus that transformed fibres no longer carry, m^4 a metre."""
        strain = self.after(curvature, plateaus) * np.sign(curvature * self.y)
        return float(np.sum(strain * self.y * self.area))


def played(world, time, stroke, length):
    """Return the curvature (1/m) and the actuator's tension (N) of every row."""
    tubes = (OUTER["OT4"], MIDDLE["MT1"])
    strips = [_Strip(tube) for tube in tubes]
    inertia = sum(tube.series() for tube in tubes)
    middle = MIDDLE["MT1"]
    arm = middle.strip()[1] + middle.ri - 3.8e-5
    gain = TRUTH.gain * TRUTH.eta ** (length / (middle.cut + middle.uncut))
    soft = gain * TRUTH.modulus * inertia / arm / TRUTH.wire
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(stroke)))])
    given = (
        stroke + world.pulley[0] * np.sin(2.0 * np.pi * stroke / world.pulley[1]) - world.wear * path - TRUTH.deadband
    )
    kappa, found = 0.0, []
    for row, pull in enumerate(given):
        step = time[row] - time[row - 1] if row else 1.0

        def carried(k, step=step, before=kappa):
            speed = (k - before) / step
            relief = sum(s.relief(PITCH_OVER_CUT * k, world.plateaus) for s in strips) / inertia
            return k - relief + world.drag * speed / (1.0 + abs(speed) / world.thinning)

        def balance(k, pull=pull, carried=carried):
            return arm * length * k + soft * carried(k) - pull

        kappa = 0.0 if pull <= 0.0 and balance(0.0) > 0.0 else brentq(balance, -20.0, 200.0, xtol=1e-7)
        found.append((kappa, soft * TRUTH.wire * carried(kappa)))
        for strip in strips:
            strip.transformed = strip.after(PITCH_OVER_CUT * kappa, world.plateaus)
    return np.array(found).T


PLANS = ((0.035, 3.8e-3, 1.0), (0.022, 3.0e-3, 4.0), (0.035, 3.4e-3, 0.3), (0.028, 3.6e-3, 2.0), (0.022, 3.0e-3, 0.5))


def recorded(world, *, noise=0.12, seed=0, plans=PLANS, witness=False):
    """Return runs of a world as the reader would: loops with a partial release, each at a rate and a length of its own.

    With ``witness`` the tension is recorded beside the stroke.
    """
    rng = np.random.default_rng(seed)
    runs = []
    for number, (length, top, pace) in enumerate(plans):
        legs = ((0.0, top, 40), (top, 0.5 * top, 20), (0.5 * top, 0.85 * top, 14), (0.85 * top, 0.1 * top, 30))
        stroke = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in legs])
        time = pace * np.arange(stroke.size) + 500.0 * number
        bent, pulled = played(world, time, stroke, length)
        bent = bent + noise * rng.standard_normal(stroke.size)
        pulled = pulled + 0.01 * rng.standard_normal(stroke.size)
        line = np.arange(stroke.size) + 2
        lengths, response = np.full(stroke.size, length), bent[:, np.newaxis]
        runs.append(
            JointRun(
                f"run_{number}",
                "bench.csv",
                line,
                time,
                "OT4",
                "MT1",
                lengths,
                stroke,
                pulled if witness else None,
                response,
                "curvature",
            )
        )
    return runs


def work_of_a_loop(world, top, length, pace=0.5):
    """Return the work (J) that a second loop of the stroke to ``top`` (m) and back takes."""
    way = np.concatenate([np.linspace(0.0, top, 200, endpoint=False), np.linspace(top, 0.0, 200, endpoint=False)])
    stroke = np.concatenate([way, way])
    tension = played(world, pace * np.arange(stroke.size), stroke, length)[1]
    steps = 0.5 * (tension[1:] + tension[:-1]) * np.diff(stroke)
    return float(np.sum(steps[way.size :]))
