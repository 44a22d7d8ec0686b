"""Tendon creep: the stretch grows while the tension is held, with a time constant (a standard linear solid)."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.memory import relax
from coast_cli.effects.stages import OnSlack
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class TendonCreep(OnSlack):
    """Delayed elongation, a fraction of the elastic one."""

    fraction: float = 0.0
    time_constant_s: float = 10.0

    id = "tendon_creep"
    title = "tendon creeps under load"
    component = "tendon"
    equation = "z' = (fraction F/k - z)/time_constant; stretch = F/k + z"
    source = "standard linear solid: Findley, Lai and Onaran, Creep and Relaxation (1976), sec. 5.7"
    parameters = (
        Parameter("fraction", 0.0, 0.0, 1.5, (0.1,), "delayed over elastic stretch"),
        Parameter(
            "time_constant_s",
            10.0,
            0.05,
            5000.0,
            (0.02, 0.06, 0.2, 0.6),
            "seconds to an hour",
            "duration",
            role="shape",
        ),
    )
    needs = ("stroke", "time")
    decided_by = "a hold of 60 s at the largest stroke, then release and a hold at zero, with tension recorded"

    def slack(self, tension: FloatArray, history: History, joint: Joint) -> FloatArray:
        """Return the delayed elongation."""
        if history.time is None or joint.tendon is None or self.fraction == 0.0:
            return 0.0 * tension
        target = self.fraction * tension / joint.tendon.stiffness
        return relax(target, history.time, self.time_constant_s, 0.0)
