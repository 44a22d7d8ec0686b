"""Backlash: play in the actuator's train loses a constant stroke at each reversal.

The stroke that reaches the tendon is the play operator of the commanded one. It is anchored on the loading side, where
the dead band is calibrated: x = clip(x_before, X1, X1 + width). A device without tubes moves to both sides: there the play
lies evenly about the drive, and a run starts where in it its first response says.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from coast_cli.effects.effect import History, Parameter
from coast_cli.effects.memory import follow
from coast_cli.effects.stages import OnDrive
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True)
class Backlash(OnDrive):
    """Lost stroke at each reversal."""

    width_mm: float = 0.0

    id = "backlash"
    title = "play in the actuator"
    component = "actuator"
    equation = "x(t) = clip(x(t-), X1(t), X1(t) + width)"
    source = "play operator: Krasnosel'skii and Pokrovskii, Systems with Hysteresis (1989), ch. 2"
    parameters = (
        Parameter(
            "width_mm", 0.0, 0.0, 50.0, (0.02, 0.08, 0.25, 0.5), "0.01 to 0.5 mm in screws, more in sheaths", "stroke"
        ),
    )
    needs = ("stroke", "release")
    decided_by = "release sweeps from two different strokes, with tension recorded"

    def drive(self, history: History) -> History:
        """Replace the stroke by what is left of it behind the play."""
        if history.stroke is None or self.width_mm == 0.0:
            return history
        width, stroke = self.width_mm * MILLIMETRE, history.stroke
        if history.start is not None:
            low = stroke - 0.5 * width
            return replace(history, stroke=follow(low, low + width, history.start))
        return replace(history, stroke=follow(stroke, stroke + width))
