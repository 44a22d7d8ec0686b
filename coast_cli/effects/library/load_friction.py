"""Friction of a transmission: a constant part, and one in proportion to the load, against the motion of the drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.memory import follow
from coast_cli.effects.stages import OnDevice
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

_STIFFEST = 1e-6  # mm (N) of drive, below which friction turns at once


@dataclass(frozen=True)
class LoadFriction(OnDevice):
    """Force that friction takes from the drive; it turns round over a short way of the drive, as contacts creep.

    Both parts are negative where a force counts against the drive's own direction.
    """

    constant_n: float = 0.0
    per_load: float = 0.0
    turns_within_mm: float = 0.02

    id = "load_friction"
    title = "friction, constant and in proportion to the load"
    component = "bearings, cable"
    stage = "transmission"
    scope = "bench"
    equation = "F -> F + (constant + per_load |load|) s, s' = X1'/turns_within up to s = +-1 along the motion"
    source = "Coulomb friction of loaded bearings; its turn: Dahl, AIAA J. 14 (1976) 1675"
    parameters = (
        Parameter("constant_n", 0.0, -1e5, 1e5, (0.3, 0.1), "a part of the force", "response"),
        Parameter(
            "per_load",
            0.0,
            -1e3,
            1e3,
            (0.0,),
            "N for one N, or one N m, of load: up to half of its lever",
            needs="load",
        ),
        Parameter(
            "turns_within_mm", 0.02, 0.0, 1e3, (0.02,), "a small part of the way, mm (N)", "stroke", role="shape"
        ),
    )
    needs = ("release", "force")
    decided_by = "the same sweep at two loads, with the load recorded"

    def carry(self, response: FloatArray, history: History) -> FloatArray:
        """Add friction along the motion, which the drive must overcome."""
        if response.size == 0 or (self.constant_n == 0.0 and self.per_load == 0.0):
            return response
        size = np.full(response.size, self.constant_n)
        if history.load is not None:
            size += self.per_load * np.abs(history.load)
        drive = history.drive
        half = max(self.turns_within_mm, _STIFFEST) * (MILLIMETRE if history.stroke is not None else 1.0)
        turned = 0.0
        if history.first_response is not None:
            turned = float(np.clip((history.first_response - response[0]) / (size[0] or 1e-300), -1.0, 1.0))
        way = (drive - follow(drive - half, drive + half, drive[0] - turned * half)) / half
        return np.asarray(response + size * way)
