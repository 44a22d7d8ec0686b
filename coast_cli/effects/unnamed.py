"""A law without a name: where it enters, on what it depends, how it remembers, and its form.

Every effect of the catalogue is a point of this grammar, so a law of it stands in the contest beside the names and says,
where none of them is right, what the recording shows: g(y), with y made of one variable by one kind of memory, entering at
one stage. The form is a short Legendre series over the range that was seen; outside it the law stays as at the range's end.
Its amplitudes are in the stage's unit (``UNITS``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, Self, get_args

import numpy as np

from coast_cli.effects.effect import Effect, History, Motion, Need, Parameter, Segment
from coast_cli.effects.memory import follow, relax
from coast_cli.effects.stages import (
    OnBranches,
    OnDrag,
    OnDrive,
    OnLoadCell,
    OnSensor,
    OnSlack,
    OnStretch,
    OnStructure,
    OnTransmission,
)
from coast_cli.errors import shortened, shown
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

Place = Literal["drive", "tendon", "transmission", "structure", "sensor", "load_cell"]
Variable = Literal["stroke", "tension", "curvature", "bending_length", "position", "time", "rate", "path", "run"]
Memory = Literal["none", "friction", "relaxation", "maximum", "path", "step", "period"]

# What a law adds, by stage, and the unit of its amplitude.
ADDS: Mapping[Place, str] = {
    "drive": "stroke",
    "tendon": "tendon length",
    "transmission": "ln of the tension ratio",
    "structure": "curvature that the bending moment stands for",
    "sensor": "response",
    "load_cell": "tension reading",
}
UNITS: Mapping[Place, str] = {
    "drive": "mm",
    "tendon": "mm",
    "transmission": "1",
    "structure": "per_m",
    "sensor": "si",
    "load_cell": "n",
}
COMPONENTS: Mapping[Place, str] = {
    "drive": "actuator",
    "tendon": "tendon",
    "transmission": "pulleys, notches",
    "structure": "tubes",
    "sensor": "camera",
    "load_cell": "load cell",
}
_LARGEST = 1e6
_MOST_WEIGHTS = 64
_SIGNED_MEMORIES = ("relaxation",)
# Memories whose setting a fit moves, and by which factor at most.
_SET_FREE: Mapping[Memory, float] = {"relaxation": 5.0, "period": 1.06}


class DamagedLaw(ValueError):
    """A model file's table that holds no law: ``key`` is what is wrong in it."""

    def __init__(self, key: str, why: str) -> None:
        super().__init__(f"{shortened(key, 60)} {why}")
        self.key = key


@dataclass(frozen=True)
class UnnamedLaw(OnDrive, OnStretch, OnSlack, OnTransmission, OnStructure, OnDrag, OnSensor, OnLoadCell):
    """One law of the grammar, with its fitted amplitudes.

    Attributes:
        number: of the law in its model, from 1. place: stage at which it enters. variable, memory: what it depends on.
        setting: of the memory: time constant (s), moment (s), period (in the variable's SI unit), 1 for a largest tension that
            earlier runs left behind too, or, of friction that is not tabulated, the play (of the drive) in which it turns.
        low, high: range of the remembered variable that was seen, SI. weights: amplitudes, in the stage's unit.
        limit: largest amplitude that a fit may give.
    """

    place: Place
    variable: Variable
    memory: Memory
    setting: float
    low: float
    high: float
    weights: tuple[float, ...]
    limit: float = _LARGEST
    number: int = 1

    @property
    def id(self) -> str:  # type: ignore[override]
        """``unnamed_1`` or ``unnamed_2``."""
        return f"unnamed_{self.number}"

    @property
    def title(self) -> str:  # type: ignore[override]
        """What it adds, in short."""
        return f"law without a name: {ADDS[self.place]} by {self.variable.replace('_', ' ')}"

    @property
    def component(self) -> str:  # type: ignore[override]
        """The component that stands at its stage."""
        return COMPONENTS[self.place]

    @property
    def kind(self) -> Literal["physics", "sensor"]:  # type: ignore[override]
        """Whether it belongs to the robot or to what looks at it."""
        return "sensor" if self.place in ("sensor", "load_cell") else "physics"

    @property
    def stage(self) -> Literal["drive", "tendon", "transmission", "structure", "sensor"]:  # type: ignore[override]
        """The stage in the order of action; a load cell reads last, as a camera does."""
        return "sensor" if self.place == "load_cell" else self.place

    @property
    def needs(self) -> tuple[Need, ...]:  # type: ignore[override]
        """A clock, where the law depends on time or speed."""
        timed = self.variable in ("time", "rate", "run") or self.memory == "relaxation"
        return ("time",) if timed else ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:  # type: ignore[override]
        """Amplitudes, and the setting of a memory that has one."""
        dissipates = self.memory == "friction"
        low = 0.0 if dissipates and len(self.weights) == 1 else -self.limit
        source = "as large as the misfit that it must explain"
        found = [
            Parameter(f"weight_{k}", 0.0, low, self.limit, (value or 0.1 * self.limit,), source)
            for k, value in enumerate(self.weights)
        ]
        if self.memory in _SET_FREE:
            reach = _SET_FREE[self.memory]
            around = self.setting / reach, self.setting * reach
            found.append(Parameter("setting", self.setting, *around, (self.setting,), "around its start", role="shape"))
        return tuple(found)

    equation = "g(y): a short Legendre series in the remembered variable y"
    source = "system identification with a grammar of laws: Brunton, Proctor and Kutz, PNAS 113 (2016) 3932"
    decided_by = "the same sweep at another rate, another bending length and another stroke, with tension recorded"

    @classmethod
    def null(cls) -> Self:
        """Return a law that adds nothing."""
        return cls("drive", "stroke", "none", 0.0, 0.0, 1.0, (0.0,))

    def values(self) -> tuple[float, ...]:
        """Return amplitudes and setting, in declared order."""
        return (*self.weights, self.setting) if self.memory in _SET_FREE else self.weights

    def numbers(self) -> dict[str, float]:
        """Return its parameters by name."""
        return dict(zip((p.name for p in self.parameters), self.values(), strict=True))

    def with_numbers(self, numbers: Mapping[str, float]) -> Self:
        """Return the law with some of them replaced."""
        return self.with_values(np.array(list((self.numbers() | dict(numbers)).values())))

    def with_values(self, values: FloatArray) -> Self:
        """Return the law with amplitudes, and the setting where it is fitted, replaced."""
        found = tuple(float(value) for value in values)
        setting = found[len(self.weights)] if len(found) > len(self.weights) else self.setting
        return replace(self, weights=found[: len(self.weights)], setting=setting)

    def table(self) -> dict[str, Any]:
        """Return the law as a table of a model file."""
        return {
            "stage": self.place,
            "variable": self.variable,
            "memory": self.memory,
            "setting": self.setting,
            "low": self.low,
            "high": self.high,
            "weights": list(self.weights),
        }

    @classmethod
    def from_table(cls, table: Mapping[str, Any], number: int) -> Self:
        """Return the law of a model file's table.

        Raises:
            DamagedLaw: a key is missing or unknown, or a value cannot be; it says which, and why.
        """
        wanted = {"stage": Place, "variable": Variable, "memory": Memory}
        names = (*wanted, "setting", "low", "high", "weights")
        for name in table:
            if name not in names:
                raise DamagedLaw(name, f"is no key of a law without a name; allowed: {', '.join(names)}")
        for name in names:
            if name not in table:
                raise DamagedLaw(name, "is missing")
        for name, choices in wanted.items():
            if table[name] not in get_args(choices):
                raise DamagedLaw(name, f"is {shown(table[name])}; allowed: {', '.join(get_args(choices))}")
        for name in ("setting", "low", "high"):
            if not _is_number(table[name]):
                raise DamagedLaw(name, f"is {shown(table[name])}; allowed: a finite number")
        weights = table["weights"]
        if not isinstance(weights, list | tuple) or not 1 <= len(weights) <= _MOST_WEIGHTS:
            raise DamagedLaw("weights", f"is not a list of 1 to {_MOST_WEIGHTS} numbers")
        if not all(_is_number(value) and abs(value) <= _LARGEST for value in weights):
            raise DamagedLaw("weights", f"holds what is no number from {-_LARGEST:g} to {_LARGEST:g}")
        setting, low, high = (float(table[name]) for name in ("setting", "low", "high"))
        amplitudes = tuple(float(value) for value in weights)
        place, variable, memory = (table[name] for name in wanted)
        law = cls(place, variable, memory, setting, low, high, amplitudes, number=number)
        law._check()
        return law

    def _check(self) -> None:
        """Refuse what each key allows and all together do not."""
        if not self.high > self.low:
            raise DamagedLaw("high", f"is {self.high:g}; allowed: above low, {self.low:g}")
        if self.memory in _SET_FREE and not self.setting > 0.0:
            raise DamagedLaw("setting", f"is {self.setting:g}; allowed with memory {self.memory}: above 0")
        if self.memory == "step" and len(self.weights) != 1:
            raise DamagedLaw("weights", "is not one number, as a step has")
        if self.variable == "position" and not self._tabulated:
            raise DamagedLaw("variable", "is position; allowed with stage structure or transmission, without a lag")
        if self.variable == "curvature" and self.place in ("drive", "tendon", "load_cell"):
            raise DamagedLaw("variable", f"is curvature, which the stage {self.place} does not know")

    # What the law adds.

    def basis(self, remembered: FloatArray) -> FloatArray:
        """Return the series at values of the remembered variable (...), shape (..., k)."""
        return basis(remembered, self.low, self.high, len(self.weights), self.memory, self.setting, self.place)

    def of(self, remembered: FloatArray) -> FloatArray:
        """Return what the law adds at values of the remembered variable, in the stage's unit."""
        added = np.asarray(self.basis(remembered) @ np.array(self.weights))
        return np.maximum(added, 0.0) if self.memory == "friction" else added

    def outside(self, remembered: FloatArray) -> float:
        """Return the fraction of values that lie outside the range that was seen."""
        margin = 0.02 * (self.high - self.low)
        off = (remembered < self.low - margin) | (remembered > self.high + margin)
        return float(np.mean(off)) if off.size else 0.0

    @property
    def reverses(self) -> bool:  # type: ignore[override]
        """Whether load and release follow branches of their own."""
        return self.memory == "friction" and self.place in ("transmission", "structure")

    @property
    def varies_along(self) -> bool:  # type: ignore[override]
        """Whether notches bend differently by their place."""
        return self.variable == "position"

    @property
    def _tabulated(self) -> bool:
        return (
            self.place in ("transmission", "structure")
            and self.memory in ("none", "friction", "period")
            and self.variable in ("curvature", "bending_length", "position")
        )

    def acts_at(self, stage: type[Effect]) -> bool:
        """Return whether it acts at a stage: the one where it enters, by the branches where these can hold it."""
        if stage is OnBranches:
            return self._tabulated
        return stage is self._acts

    @property
    def _acts(self) -> type[Effect]:
        if self.place == "tendon":
            by_tension = self.variable == "tension" and self.memory in ("none", "period")
            return OnStretch if by_tension else OnSlack
        if self.place not in ("transmission", "structure"):
            return {"drive": OnDrive, "sensor": OnSensor, "load_cell": OnLoadCell}[self.place]
        if not self._tabulated:
            return OnDrag
        return OnTransmission if (self.place, self.variable) == ("transmission", "bending_length") else OnStructure

    def _series(self, history: History, tension: FloatArray, curvature: FloatArray | None) -> FloatArray:
        return variable_of(self.variable, history, tension, curvature, self.memory)

    def drive(self, history: History) -> History:
        """Add to the stroke, or to the tension where that drives."""
        unit = MILLIMETRE if history.stroke is not None else 1.0
        series = self._series(history, history.drive, None)
        if self.memory == "friction":
            half = self.of(series) * unit
            moved = follow(history.drive - half, history.drive + half)
        else:
            moved = history.drive + self.of(remember(series, history, self.memory, self.setting)) * unit
        return replace(history, stroke=moved) if history.stroke is not None else replace(history, tension=moved)

    def stretch(self, stretch: FloatArray, tension: FloatArray, joint: Joint) -> FloatArray:
        """Add elongation that the tension of the moment makes."""
        return np.maximum.accumulate(stretch + self.of(tension) * MILLIMETRE)

    def slack(self, tension: FloatArray, history: History, joint: Joint) -> FloatArray:
        """Return tendon length (m) that time, path or the tension so far has added."""
        series = self._series(history, tension, None)
        if self.memory == "friction":
            half, elastic = self.of(series) * MILLIMETRE, 0.0 * tension
            if joint.tendon is not None:
                elastic = tension / joint.tendon.stiffness
            return follow(elastic - half, elastic + half) - elastic
        return self.of(remember(series, history, self.memory, self.setting)) * MILLIMETRE

    def friction(self, direction: int, joint: Joint, bending_length: float) -> float:
        """Return the exponent that the bending length alone decides."""
        added = float(self.of(np.array([bending_length]))[0])
        return direction * added if self.memory == "friction" else added

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Add moment by curvature, place or bending length; a tension ratio by curvature acts as a factor on it."""
        if self.variable == "curvature":
            added = self.of(curvature)
        else:
            place = segment.position if self.variable == "position" else None
            at = np.array([[segment.bending_length]]) if place is None else place
            added = np.broadcast_to(self.of(at), curvature.shape)
        sign = direction if self.memory == "friction" else 1
        if self.place == "transmission":
            return np.asarray(moment * np.exp(np.clip(sign * added, -3.0, 3.0)))
        return np.asarray(moment + sign * added * segment.rigidity)

    def drag(self, motion: Motion) -> FloatArray:
        """Return the tension (N, at the actuator) that the law takes, row by row."""
        series = self._series(motion.history, motion.tension, motion.curvature)
        added = self.of(remember(series, motion.history, self.memory, self.setting))
        if self.memory == "friction":
            added = added * rubbing(motion.history, max(self.setting, 1e-9))
        if self.place == "transmission":
            return np.asarray(motion.tension * np.expm1(np.clip(added, -3.0, 3.0)))
        return np.asarray(added * motion.tension_per_curvature)

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Add to the response."""
        out = np.empty_like(response)
        for column in range(response.shape[1]):
            here = response[:, column]
            series = self._series(history, history.drive, here)
            if self.memory == "friction":
                half = self.of(series)
                out[:, column] = follow(here - half, here + half)
            else:
                out[:, column] = here + self.of(remember(series, history, self.memory, self.setting))
        return out

    def weigh(self, tension: FloatArray, history: History) -> FloatArray:
        """Add to what the load cell reads."""
        series = self._series(history, tension, None)
        return np.asarray(tension + self.of(remember(series, history, self.memory, self.setting)))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def variable_of(
    variable: Variable, history: History, tension: FloatArray, curvature: FloatArray | None, memory: Memory = "none"
) -> FloatArray:
    """Return a variable's value at every row of a run, SI, shape (n,).

    Args:
        tension: own tension, or the drive where the law acts before there is one. curvature: own response, where known.
        memory: friction depends on the speed whatever its sign.
    """
    clock = np.arange(tension.shape[0], dtype=np.float64) if history.time is None else history.time
    if variable == "curvature":
        return tension if curvature is None else curvature
    if variable == "tension":
        return tension
    if variable == "bending_length":
        return history.bending_length
    if variable == "time":
        return clock
    if variable == "rate":
        rate = drive_rate(history.drive, clock)
        return np.abs(rate) if memory == "friction" else rate
    if variable == "path":
        return travelled(history.drive)
    if variable == "run":
        return np.full(tension.shape[0], float(history.run))
    return history.drive


def rubbing(history: History, play: float) -> FloatArray:
    """Return the state of motion (n,): 1 on load, -1 on release, and what lies between while a play of the drive turns."""
    return np.asarray((history.drive - follow(history.drive - play, history.drive + play)) / play)


def drive_rate(drive: FloatArray, clock: FloatArray) -> FloatArray:
    """Return the speed of the drive with its sign (per s), the mean of the steps to and from each row, shape (n,)."""
    if drive.size < 2:
        return np.zeros_like(drive)
    step = np.diff(drive) / np.maximum(np.diff(clock), 1e-9 + 1e-6 * float(np.median(np.abs(np.diff(clock)))))
    return np.concatenate([step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]])


def travelled(series: FloatArray) -> FloatArray:
    """Return the path that a series has travelled by each row, shape (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.abs(np.diff(series)))]) if series.size else series


def remember(series: FloatArray, history: History, memory: Memory, setting: float) -> FloatArray:
    """Return the remembered variable y of a series (n,): itself, its lag, its largest value, its path, or a step."""
    if memory == "relaxation":
        if history.time is None or series.size == 0:
            return np.zeros_like(series)
        return relax(series, history.time, setting, series[0]) - series
    if memory == "maximum":
        before = setting * history.earlier_tension
        return np.asarray(np.maximum(np.maximum.accumulate(series), before))
    if memory == "path":
        return travelled(series)
    if memory == "step":
        return (series > setting).astype(np.float64)
    return series


def basis(
    remembered: FloatArray, low: float, high: float, count: int, memory: Memory, setting: float, place: Place
) -> FloatArray:
    """Return ``count`` functions of the remembered variable (...), shape (..., count).

    Legendre polynomials over the range; those of a drive or tendon vanish at its low end, where the dead band stands for
    them, and those of a lag or a rate vanish at zero. A period has sines and cosines, a step is its own function.
    """
    if memory == "step":
        return np.asarray(remembered, dtype=np.float64)[..., np.newaxis]
    if memory == "period":
        turn = 2.0 * np.pi * remembered / setting
        waves = [f(k * turn) for k in range(1, (count + 1) // 2 + 1) for f in (np.sin, np.cos)]
        return np.stack(waves[:count], axis=-1)
    if memory in _SIGNED_MEMORIES:
        reach = max(abs(low), abs(high), 1e-300)
        x = np.clip(remembered, low, high) / reach
        return np.stack([x ** (k + 1) for k in range(count)], axis=-1)
    x = 2.0 * (np.clip(remembered, low, high) - low) / max(high - low, 1e-300) - 1.0
    anchored = place in ("drive", "tendon", "transmission") and memory != "friction"
    polynomials = np.polynomial.legendre.legvander(x, count if anchored else count - 1)
    if not anchored:
        return np.asarray(polynomials)
    signs = (-1.0) ** np.arange(1, count + 1)
    return np.asarray(polynomials[..., 1:] - signs)
