"""Tube hysteresis: nitinol strips load along an upper stress plateau and come back along a lower one.

The base of both is the stress-strain curve of ``mechanics.superelastic`` put into the sections of the joint's own tubes;
the plateaus of tubes that have a curve of their own are replaced by the fitted ones.
Between the plateaus the segment unloads elastically, which friction does not let it do: that tells the two apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter, Segment
from coast_cli.effects.memory import follow
from coast_cli.effects.plateau import fitted_tubes, softened
from coast_cli.effects.stages import OnSettling, OnStructure
from coast_cli.mechanics.bending_law import interpolated
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.release import LoadAndRelease
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MEGAPASCAL

_SHARES = np.linspace(0.0, 1.0, 33)


@dataclass(frozen=True)
class TubeHysteresis(OnStructure, OnSettling):
    """The superelastic loop of the notched tubes."""

    upper_plateau_mpa: float = 450.0
    lower_plateau_mpa: float = 180.0
    stiffness_lost: float = 0.0

    id = "tube_hysteresis"
    title = "superelastic loop of the tubes"
    component = "tubes"
    equation = (
        "sigma = upper_plateau + (1 - stiffness_lost) E (strain - upper_plateau/E) on load, lower by upper_plateau - "
        "lower_plateau on release, elastic between; M = integral of sigma y over strip and ring"
    )
    source = "flag-shaped law: Auricchio and Taylor, Comput. Methods Appl. Mech. Eng. 143 (1997) 175"
    parameters = (
        Parameter(
            "upper_plateau_mpa",
            450.0,
            1.0,
            3000.0,
            (0.4, 0.7),
            "nitinol 360 to 650 MPa",
            "stress",
            role="shape",
        ),
        Parameter("lower_plateau_mpa", 180.0, 0.5, 2000.0, (0.2,), "nitinol 110 to 240 MPa", "stress", role="shape"),
        Parameter("stiffness_lost", 0.0, 0.0, 0.98, (0.8,), "plateau slope 3 to 10 % of E"),
    )
    needs = ("release",)
    decided_by = (
        "release from two strokes, below and above the knee, with tension recorded: only the larger one opens a loop"
    )

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Take off what the upper plateau no longer carries; what release adds is remembered by ``settle``."""
        if self.stiffness_lost == 0.0:
            return moment
        return moment + segment.rigidity * softened(segment.joint, self._tubes(segment.joint), curvature)

    def settle(self, curvature: FloatArray, history: History, joint: Joint, rigidity: float, arm: float) -> FloatArray:
        """Let the curvature (n, m) come back along the lower plateau: what has transformed waits between two bounds."""
        peak = np.maximum.accumulate(curvature, axis=0)
        if self.stiffness_lost == 0.0 or curvature.shape[0] == 0 or not np.any(curvature < peak):
            return curvature
        tubes, size = self._tubes(joint), (curvature.size, 1)
        path, pull = _compliances(history, joint, rigidity, arm)
        path, pull = (np.broadcast_to(part[:, None], curvature.shape).reshape(size) for part in (path, pull))
        load, top = curvature.reshape(size), np.maximum(peak, 1e-9).reshape(-1)
        carried = sum(part * (tube.load.carried(load.T).T - load) for part, tube in tubes) + load
        elastic = (path * load + pull * carried) / (path + pull)
        coming = sum(part * (tube.released(top, _SHARES) - _SHARES) for part, tube in tubes) + _SHARES
        behind = (path * _SHARES + pull * coming) / (path + pull)
        behind = np.maximum.accumulate(behind + 1e-9 * _SHARES, axis=1)
        back = top[:, None] * interpolated(elastic / top[:, None], behind, np.broadcast_to(_SHARES, behind.shape))
        low, high = (load - elastic).reshape(curvature.shape), (back - elastic).reshape(curvature.shape)
        waiting = follow(low, np.maximum(low, high), np.zeros(low.shape[1:]))
        return np.asarray(elastic.reshape(curvature.shape) + waiting)

    def _tubes(self, joint: Joint) -> list[tuple[float, LoadAndRelease]]:
        upper, lower = self.upper_plateau_mpa * MEGAPASCAL, self.lower_plateau_mpa * MEGAPASCAL
        return fitted_tubes(joint, upper, lower, self.stiffness_lost)


def _compliances(history: History, joint: Joint, rigidity: float, arm: float) -> tuple[FloatArray, FloatArray]:
    """Return how much drive one 1/m of curvature takes by the tendon's path, and by its stretch, row by row."""
    length = history.bending_length
    if history.stroke is None or joint.tendon is None:
        return np.zeros_like(length), np.ones_like(length)
    gain = np.exp(joint.pulley_friction * joint.wrap_angle) * joint.notch_friction ** (length / joint.pitch)
    return length * arm, gain * rigidity / arm / joint.tendon.stiffness
