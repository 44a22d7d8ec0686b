"""Lost steps: the motor loses stroke at one moment of a run or at a few, and does not know.

Every run is zeroed anew, so that what one run has lost the next has back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from coast_cli.effects.effect import RUN, History, Parameter
from coast_cli.effects.stages import OnDrive
from coast_cli.units import MILLIMETRE

_RANGE = "whole steps of a motor; forwards where it slips under load"


def _lost(name: str, *, first: bool) -> Parameter:
    return Parameter(name, 0.0, -5.0, 5.0, (0.1,) if first else (0.0,), _RANGE)


def _moment(name: str, *, first: bool) -> Parameter:
    within = "within the run, from its first row; 0 for none"
    return Parameter(name, 0.0, 0.0, 1e6, (0.4 if first else 0.0,), within, "duration", role="moment")


@dataclass(frozen=True)
class LostSteps(OnDrive):
    """Stroke that is missing in one run from up to three moments on."""

    run: float = 0.0
    lost_mm: float = 0.0
    time_s: float = 0.0
    second_lost_mm: float = 0.0
    second_time_s: float = 0.0
    third_lost_mm: float = 0.0
    third_time_s: float = 0.0

    id = "lost_steps"
    title = "motor loses steps"
    component = "actuator"
    scope = "bench"
    equation = "in that run: X1 -> X1 - lost from time_s on, and so on for each further moment"
    source = "stall of stepping motors: Acarnley, Stepping Motors (2002), ch. 5"
    parameters = (
        RUN,
        _lost("lost_mm", first=True),
        _moment("time_s", first=True),
        _lost("second_lost_mm", first=False),
        _moment("second_time_s", first=False),
        _lost("third_lost_mm", first=False),
        _moment("third_time_s", first=False),
    )
    needs = ("stroke", "time")
    unlikely = 6.0  # its run and moment are one in some hundreds
    decided_by = "the same sweep twice, with the carriage read on a scale before and after"

    @classmethod
    def of(cls, run: int, moments: Sequence[tuple[float, float]]) -> LostSteps:
        """Return lost steps of a run from what was lost (mm) and when (s), up to three."""
        return cls(float(run), *(number for moment in moments for number in moment))

    @property
    def moments(self) -> tuple[tuple[float, float], ...]:
        """What was lost (mm), and when (s)."""
        return (
            (self.lost_mm, self.time_s),
            (self.second_lost_mm, self.second_time_s),
            (self.third_lost_mm, self.third_time_s),
        )

    @property
    def idle(self) -> tuple[str, ...]:
        """Moments that were not chosen lose nothing."""
        names = [parameter.name for parameter in self.parameters if parameter.role == "size"]
        return tuple(name for name, (_, moment) in zip(names, self.moments, strict=True) if moment == 0.0)

    def drive(self, history: History) -> History:
        """Take the lost stroke off from its moments on."""
        if history.run != round(self.run) or history.stroke is None or history.time is None or history.time.size == 0:
            return history
        stroke, within = history.stroke, history.time - history.time[0]
        for lost, moment in self.moments:
            if lost != 0.0 and moment > 0.0:
                stroke = stroke - lost * MILLIMETRE * (within >= moment)
        return replace(history, stroke=stroke)
