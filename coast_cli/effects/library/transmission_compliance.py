"""Compliance of a transmission: the cable stretches in proportion to the load that its far end carries."""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.stages import OnDrive, OnStretch
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class TransmissionCompliance(OnStretch, OnDrive):
    """Stroke that the load of the far end takes; where no load was recorded, that load is the tendon's tension."""

    compliance_mm: float = 0.0

    id = "transmission_compliance"
    title = "cable stretches with the load of the far end"
    component = "cable"
    scope = "bench"
    equation = "x = X1 - compliance load"
    source = "elastic cable: Palli and Melchiorri, IEEE Int. Conf. Robotics and Automation (2006) 775"
    parameters = (
        Parameter("compliance_mm", 0.0, -1e5, 1e5, (0.05, -0.05), "mm a unit (N or N m) of load", "compliance"),
    )
    needs = ("far_end",)
    decided_by = "the same sweep at two loads, with the load recorded"

    def drive(self, history: History) -> History:
        """Take off what the cable stretches."""
        if history.load is None or self.compliance_mm == 0.0:
            return history
        lost = self.compliance_mm * MILLIMETRE * history.load
        if history.stroke is not None:
            return replace(history, stroke=history.stroke - lost)
        return replace(history, tension=history.drive - lost)

    def stretch(self, stretch: FloatArray, tension: FloatArray, joint: Joint) -> FloatArray:
        """Add what the tendon's tension stretches of the cable."""
        if self.compliance_mm == 0.0 or joint.tendon is None:
            return stretch
        return stretch + self.compliance_mm * MILLIMETRE * tension
