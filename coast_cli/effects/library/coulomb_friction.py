"""Coulomb friction: a constant friction moment between the tubes resists every change of bend.

A photographed pair stays a little where it came from, whichever way up it lies.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from coast_cli.effects.effect import Parameter, Segment
from coast_cli.effects.shape_stages import Loads, OnPair
from coast_cli.effects.stages import OnStructure
from coast_cli.mechanics.section import FloatArray

_LUMPS = 6
_QUANTILES = np.array([NormalDist().inv_cdf((place + 0.5) / _LUMPS) for place in range(_LUMPS)])


@dataclass(frozen=True)
class CoulombFriction(OnStructure, OnPair):
    """Constant friction moment, given as the curvature that it can hold; it may differ from place to place.

    Of a photographed pair it is the curvature that it does hold, in the frame of the bench; positive bends upward.
    """

    holds_per_m: float = 0.0
    spread: float = 0.0
    held_per_m: float = 0.0

    id = "coulomb_friction"
    title = "constant friction between the tubes"
    component = "tubes"
    equation = (
        "load: M = M_elastic + Mc; release: M = M_elastic - Mc, Mc = EI holds_per_m, log-normal along the segment"
    )
    source = "Coulomb's law; friction of nested tubes: Lock and Dupont, ICRA 2011"
    parameters = (
        Parameter("holds_per_m", 0.0, 0.0, 500.0, (0.01, 0.04, 0.12), "a part of the curvature reached", "curvature"),
        Parameter("spread", 0.0, 0.0, 1.0, (0.25,), "of ln Mc from notch to notch; burrs and fits vary", role="shape"),
    )
    needs = ("release",)
    reverses = True
    decided_by = "release sweeps from two strokes, small and large, with tension recorded: this loop keeps its width"
    on_shapes = {
        "equation": "k(s) = k_pair(s) + held, the same for both ways up",
        "source": "Coulomb's law; friction of nested tubes: Lock and Dupont, ICRA 2011",
        "parameters": (Parameter("held_per_m", 0.0, -30.0, 30.0, (0.3,), "a part of the tubes' natural curvature"),),
        "needs": (),
        "unlikely": 2.0,
        "decided_by": "the pair turned over, brought to rest from above and from below",
    }

    @property
    def lumps(self) -> int:
        """Parts of the segment that stick and slip by themselves."""
        return _LUMPS if self.spread > 0.0 else 1

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Add the friction moment against the motion."""
        part = np.ones(1)
        if moment.shape[0] == _LUMPS and self.spread > 0.0:
            part = np.exp(self.spread * _QUANTILES)
            part = part / part.mean()
        return moment + direction * self.holds_per_m * part[:, np.newaxis] * segment.rigidity

    def loads(self, loads: Loads) -> Loads:
        """Hold the curvature of a photographed pair."""
        return replace(loads, held_curvature=loads.held_curvature + self.held_per_m)
