"""A law without a name for shapes: what is added at one stage, as a function of the place along the tube or in the picture.

The form is a short Legendre series over the length of the tube, or a wave; what the base model has free already (a constant
natural curvature, a constant compliance) is not in it. Beyond the length that was seen the law stays as at its end.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, Self, get_args

import numpy as np

from coast_cli.effects.effect import Effect, Parameter
from coast_cli.effects.shape_stages import OnImage, OnPieces, Photographed, Pieces
from coast_cli.effects.unnamed import DamagedLaw, UnnamedLaw
from coast_cli.mechanics.section import FloatArray

ShapePlace = Literal["tube", "environment", "camera"]
Adds = Literal["curvature", "compliance", "force", "height"]
ShapeVariable = Literal["arc_length", "picture_x"]
ShapeMemory = Literal["none", "period"]

STAGE_OF: Mapping[Adds, ShapePlace] = {
    "curvature": "tube",
    "compliance": "tube",
    "force": "environment",
    "height": "camera",
}
VARIABLE_OF: Mapping[Adds, ShapeVariable] = {
    "curvature": "arc_length",
    "compliance": "arc_length",
    "force": "arc_length",
    "height": "picture_x",
}
# What the base model has free already is left out of the series: its constant.
_FIRST: Mapping[Adds, int] = {"curvature": 1, "compliance": 1, "force": 0, "height": 0}
_WORDS: Mapping[Adds, str] = {
    "curvature": "natural curvature",
    "compliance": "ln of the compliance",
    "force": "force on the tube",
    "height": "height in the picture",
}
_GRAVITY = 9.81
_LARGEST = 1e6
_MOST_LOG = 4.0
_PERIOD_REACH = 1.3


@dataclass(frozen=True)
class ShapeLaw(OnPieces, OnImage):
    """One law of shapes, with its fitted amplitudes.

    Attributes:
        adds: what, which also says at which stage. high: length over which the series runs, from 0, m.
        weights: amplitudes, 1/m of curvature, ln of compliance, N/m of force (downward), m of height.
        tube: on which it sits, 0 on every one. period: of a wave, m; 0 where the law is a series.
        limit: largest amplitude that a fit may give. number: of the law in its model, from 1.
    """

    adds: Adds
    high: float
    weights: tuple[float, ...]
    tube: float = 0.0
    period: float = 0.0
    limit: float = _LARGEST
    number: int = 1

    equation = "g(s): a short Legendre series along the tube"
    source = "system identification with a grammar of laws: Brunton, Proctor and Kutz, PNAS 113 (2016) 3932"
    decided_by = "the same tube turned over, then clamped half as long: what moves with it, is the tube's own"

    @property
    def id(self) -> str:  # type: ignore[override]
        """``unnamed_1`` or ``unnamed_2``."""
        return f"unnamed_{self.number}"

    @property
    def title(self) -> str:  # type: ignore[override]
        """What it adds, in short."""
        return f"law without a name: {_WORDS[self.adds]} along the tube"

    @property
    def place(self) -> ShapePlace:
        """Stage at which it enters."""
        return STAGE_OF[self.adds]

    @property
    def variable(self) -> ShapeVariable:
        """On what it depends."""
        return VARIABLE_OF[self.adds]

    @property
    def memory(self) -> ShapeMemory:
        """Whether it is a wave; nothing of a shape at rest remembers."""
        return "period" if self.period else "none"

    @property
    def component(self) -> str:  # type: ignore[override]
        """The component that stands at its stage."""
        return self.place

    @property
    def kind(self) -> Literal["physics", "sensor"]:  # type: ignore[override]
        """Whether it belongs to the tube and its surroundings or to what looks at them."""
        return "sensor" if self.place == "camera" else "physics"

    @property
    def stage(self) -> Literal["structure", "sensor"]:  # type: ignore[override]
        """The stage in the order of action."""
        return "sensor" if self.place == "camera" else "structure"

    @property
    def scope(self) -> Literal["tube", "bench", "camera"]:  # type: ignore[override]
        """What it belongs to."""
        return "tube" if self.place == "tube" else "camera" if self.place == "camera" else "bench"

    @property
    def parameters(self) -> tuple[Parameter, ...]:  # type: ignore[override]
        """Amplitudes, and the period of a wave."""
        source = "as large as the misfit that it must explain"
        found = [
            Parameter(f"weight_{k}", 0.0, -self.limit, self.limit, (value or 0.1 * self.limit,), source)
            for k, value in enumerate(self.weights)
        ]
        if self.period:
            low, high = self.period / _PERIOD_REACH, self.period * _PERIOD_REACH
            found.append(Parameter("period", self.period, low, high, (self.period,), "around its start", role="shape"))
        return tuple(found)

    @classmethod
    def null(cls) -> Self:
        """Return a law that adds nothing."""
        return cls("curvature", 1.0, (0.0,))

    def values(self) -> tuple[float, ...]:
        """Return amplitudes and period, in declared order."""
        return (*self.weights, self.period) if self.period else self.weights

    def numbers(self) -> dict[str, float]:
        """Return its parameters by name."""
        return dict(zip((p.name for p in self.parameters), self.values(), strict=True))

    def with_numbers(self, numbers: Mapping[str, float]) -> Self:
        """Return the law with some of them replaced."""
        return self.with_values(np.array(list((self.numbers() | dict(numbers)).values())))

    def with_values(self, values: FloatArray) -> Self:
        """Return the law with amplitudes, and the period of a wave, replaced."""
        found = tuple(float(value) for value in values)
        count = len(self.weights)
        return replace(self, weights=found[:count], period=found[count] if self.period else 0.0)

    def fitted(self) -> tuple[Parameter, ...]:  # type: ignore[override]
        """Return the parameters that a fit moves: all."""
        return self.parameters

    def fitted_values(self) -> FloatArray:
        """Return their values."""
        return np.array(self.values())

    def with_fitted(self, values: FloatArray) -> Self:
        """Return the law with them replaced."""
        return self.with_values(values)

    @property
    def variant(self) -> tuple[str, float]:
        """Its id and the tube it sits on."""
        return self.id, self.tube

    def widths(self, seen: Photographed) -> FloatArray:  # type: ignore[override]
        """Return the prior width of each parameter."""
        found = [self.limit / (4.0 * (1 + k)) for k in range(len(self.weights))]
        return np.array([*found, 0.3 * self.period] if self.period else found)

    def one_sided(self) -> bool:  # type: ignore[override]
        """Return that the law can be turned round."""
        return False

    def table(self) -> dict[str, Any]:
        """Return the law as a table of a model file."""
        return {
            "recording": "shapes",
            "stage": self.place,
            "variable": self.variable,
            "adds": self.adds,
            "tube": self.tube,
            "period": self.period,
            "high": self.high,
            "weights": list(self.weights),
        }

    @classmethod
    def from_table(cls, table: Mapping[str, Any], number: int) -> Self:
        """Return the law of a model file's table.

        Raises:
            DamagedLaw: a key is missing or unknown, or a value cannot be; the message says which.
        """
        names = ("recording", "stage", "variable", "adds", "tube", "period", "high", "weights")
        for name in (*table, *names):
            if name not in names or name not in table:
                said = "missing" if name in names else "no key of a law without a name"
                raise DamagedLaw(name, f"is {said}")
        adds = table["adds"]
        if adds not in get_args(Adds):
            raise DamagedLaw("adds", f"is {adds!r}; allowed: {', '.join(get_args(Adds))}")
        for name, wanted in (("stage", STAGE_OF), ("variable", VARIABLE_OF)):
            if table[name] != wanted[adds]:
                raise DamagedLaw(name, f"is {table[name]!r}; that of {adds} is {wanted[adds]}")
        weights = table["weights"]
        if not isinstance(weights, list | tuple) or not 1 <= len(weights) <= 64 or not all(map(_is_number, weights)):
            raise DamagedLaw("weights", "must be a list of 1 to 64 finite numbers")
        for name in ("tube", "period", "high"):
            if not _is_number(table[name]) or table[name] < 0.0 or (name == "high" and table[name] == 0.0):
                raise DamagedLaw(name, f"must be a number {'above 0' if name == 'high' else 'from 0 on'}")
        if table["period"] and len(weights) != 2:
            raise DamagedLaw("weights", "of a wave must be two: of its sine and its cosine")
        tube, period, high = (float(table[name]) for name in ("tube", "period", "high"))
        return cls(adds, high, tuple(map(float, weights)), tube, period, number=number)

    @property
    def low(self) -> float:
        """Where the series begins, m."""
        return 0.0

    @property
    def setting(self) -> float:
        """The period of a wave, m."""
        return self.period

    def basis(self, place: FloatArray) -> FloatArray:
        """Return the series at places (...), m, shape (..., k)."""
        if self.period:
            turn = 2.0 * np.pi * np.asarray(place) / self.period
            return np.stack([np.sin(turn), np.cos(turn)], axis=-1)
        first = _FIRST[self.adds]
        inside = 2.0 * np.clip(place, 0.0, self.high) / self.high - 1.0
        return np.asarray(np.polynomial.legendre.legvander(inside, len(self.weights) - 1 + first)[..., first:])

    def of(self, place: FloatArray) -> FloatArray:
        """Return what the law adds at places along the tube or in the picture, m, in its own unit."""
        return np.asarray(self.basis(place) @ np.array(self.weights))

    def acts_at(self, stage: type[Effect]) -> bool:
        """Return whether it acts on tubes, or on the picture."""
        return (stage is OnImage) == (self.place == "camera")

    def pieces(self, pieces: Pieces) -> Pieces:
        """Add natural curvature, compliance or force along the tube."""
        added = self.of(pieces.middle)
        if self.adds == "curvature":
            return replace(pieces, natural=pieces.natural + added)
        if self.adds == "compliance":
            return replace(pieces, rigidity=pieces.rigidity * np.exp(-np.clip(added, -_MOST_LOG, _MOST_LOG)))
        return replace(pieces, weight=pieces.weight + added / _GRAVITY)

    def see(self, x: FloatArray, y: FloatArray, centre: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Add height in the picture."""
        return x, y + self.of(x)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


Law = UnnamedLaw | ShapeLaw
