"""Bending of one notch under its moment: fibre sections with a plateau, contact of the notch faces, jackets.

Moments are divided by EI, so that they are curvatures (1/m) of the linear joint.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from examples.concealed.design import Joint, Tube, sector, series_moment

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, object]]

FIBRES = (np.arange(24) + 0.5) / 24


def closing_curvature(tube: Tube) -> float:
    """Curvature (1/m) at which the faces of a notch touch."""
    return tube.cut / (tube.outer_diameter / 2 + sector(tube)[1]) / tube.pitch


def strain_per_curvature(joint: Joint) -> float:
    """Strain of the outermost fibre of a notch's strip per curvature of the segment (m), the larger of both tubes."""
    worst = 0.0
    for tube in (joint.outer, joint.middle):
        if tube is not None:
            ro, ri = tube.outer_diameter / 2, tube.inner_diameter / 2
            half = np.arccos((tube.depth - ro) / ro)
            _, axis, moment = sector(tube)
            farthest = max(ro - axis, axis - ri * float(np.cos(half)))
            worst = max(worst, farthest * series_moment(tube) / moment)
    return worst


class BendingLaw:
    """Curvature (1/m) under a moment, without memory: fibres on a plateau, faces that touch notch by notch."""

    def __init__(self, joint: Joint, effects: Effects, largest: float, rng: np.random.Generator, count: int) -> None:
        soft, closing = effects.get("tube_superelasticity"), effects.get("notch_closure")
        self.linear = soft is None and closing is None
        if self.linear:
            return
        self.grid = np.linspace(0, 3 * largest, 3001)
        moment = self.grid.copy()
        if soft:
            # Stress over strain of a strip's fibres: elastic up to the knee, then the plateau's slope.
            strain = self.grid[:, None] * strain_per_curvature(joint) * FIBRES
            plateau = np.minimum(strain, soft["knee_strain"] + soft["plateau_slope"] * (strain - soft["knee_strain"]))
            carried = 3 * (FIBRES * plateau).mean(axis=1) / strain_per_curvature(joint)
            moment += soft["share"] * (carried - 3 * (FIBRES**2).mean() * self.grid)
        self.moment = np.repeat(moment[None], 1, axis=0)
        if closing:
            at = closing["contact_curvature_per_m"] * (1 + closing["spread"] * rng.standard_normal((count, 1)))
            past = np.maximum(self.grid - at, 0.0)
            # Line contact of two rough faces: force grows with the power 3/2 of the approach.
            self.moment = moment + closing["stiffness_rise"] * past**1.5 / np.sqrt(0.1 * at)

    def __call__(self, moment: Array) -> Array:
        """Curvature (1/m) of each notch; odd in its argument."""
        if self.linear:
            return moment
        size = np.abs(moment)
        if len(self.moment) == 1:
            return np.sign(moment) * np.interp(size, self.moment[0], self.grid)
        notches = (np.interp(m, table, self.grid) for m, table in zip(size, self.moment, strict=True))
        return np.sign(moment) * np.fromiter(notches, float, size.size)


class Memory:
    """Curvature (1/m) that a notch adds by what it went through: transformed fibres, a jacket that relaxes or softens."""

    def __init__(self, joint: Joint, effects: Effects, count: int) -> None:
        self.loop = effects.get("tube_hysteresis")
        self.relaxing = effects.get("jacket_relaxation")
        self.softening = effects.get("jacket_softening")
        self.idle = not (self.loop or self.relaxing or self.softening)
        if self.loop:
            fibres = np.linspace(0.35, 1.0, 8)
            self.upper = self.loop["knee_strain"] / strain_per_curvature(joint) / fibres
            self.lower = self.loop["lower_plateau"] * self.upper
            self.width = 0.3 * self.upper
            self.weight = self.loop["compliance"] * fibres**2 / np.sum(fibres**2) * self.width
        self.state = (np.zeros((count, 8)), np.zeros((count, 2)), np.zeros(count), np.zeros(count))
        self.trial = self.state
        self.decay = np.ones(2)

    def advance(self, dt: float) -> None:
        """Go to the next time step of `dt` (s)."""
        if self.relaxing:
            self.decay = np.exp(-dt / (self.relaxing["time_constant_s"] * np.array([0.5, 3.0])))

    def added(self, moment: Array) -> Array:
        """Return the added curvature of each notch under `moment`; the trial state is kept for `commit`."""
        transformed, slow, peak, before = self.state
        out = np.zeros_like(moment)
        if self.loop:
            # Each fibre's transformed share stays between its loading line and its lower line of release.
            low = np.clip((moment[:, None] - self.upper) / self.width, 0, 1)
            high = np.clip((moment[:, None] - self.lower) / self.width, 0, 1)
            transformed = np.minimum(np.maximum(transformed, low), high)
            out = out + transformed @ self.weight
        if self.relaxing:
            target = self.relaxing["compliance"] * 0.5 * (moment + before)[:, None] * np.array([0.5, 0.5])
            slow = slow * self.decay + (1 - self.decay) * target
            out = out + slow.sum(axis=1)
        if self.softening:
            peak = np.maximum(peak, moment)
            out = out - moment * self.softening["loss"] * np.expm1(-peak / self.softening["scale_per_m"])
        self.trial = (transformed, slow, peak, moment)
        return out

    def commit(self) -> None:
        """Keep the trial state of the solved step."""
        self.state = self.trial
