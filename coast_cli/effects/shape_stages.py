"""The stages at which effects of photographed tubes and pairs act: a tube's pieces, a pair's assembly, the bench, the picture.

``stages.OnTubes``, the geometry itself, comes before them. Each stage is a base class with a method that is the identity
unless overridden. What all of them owe to a fit (where it starts, what a number costs) stands in ``OnShapes``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar, Self

import numpy as np

from coast_cli.effects.effect import Effect, Parameter, RecordingKind, Scale, Stage
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE, MILLINEWTON

# Which tube an effect sits on; it is chosen by comparison and never fitted.
TUBE = Parameter(
    "tube", 0.0, 0.0, 10_000.0, (0.0,), "0: every tube; k: the k-th of the file, outer tubes first", role="tube"
)
# Whether each tube may differ from what an effect has for all of them by a share of it; chosen in the same way.
BY_TUBE = Parameter(
    "by_tube", 0.0, 0.0, 1.0, (0.0, 1.0), "1: each tube's own differs from it by a few per cent", role="by_tube"
)

# Natural curvature that an effect is in proportion to, tube by tube; chosen in the same way.
OF_CURVATURE = Parameter("of_per_m", 0.0, 0.0, 1000.0, (0.0,), "0: the same on every tube", role="found")
_SPOTS = 12
_SPREAD = 1.2  # mm to either side, over which what sits in one place is spread


@dataclass(frozen=True, slots=True)
class Pieces:
    """One tube piece by piece (uncut, cut, ...), shape (2n,).

    Attributes:
        length: m. rigidity: flexural, N m^2. weight: mass per length, kg/m.
        natural: curvature added to the tube's own, on the side to which that points, 1/m.
        offset: of the strip's axis from the tube's, m; 0 on rings. own: factor on the tube's own natural curvature.
    """

    length: FloatArray
    rigidity: FloatArray
    weight: FloatArray
    natural: FloatArray
    offset: FloatArray
    own: FloatArray

    @property
    def middle(self) -> FloatArray:
        """Arc length of the middle of each piece, m."""
        middle: FloatArray = np.cumsum(self.length) - self.length / 2.0
        return middle


@dataclass(frozen=True, slots=True)
class Loads:
    """What the bench does to the beam, in its frame: x along the clamp, gravity along -y.

    Attributes:
        base_angle: of the clamped tangent, rad. upward_force: at the tip, N. gravity: share of g in the plane.
        held_curvature: curvature that friction between two tubes holds, 1/m, on pairs only.
        axis_share: share of the strip's offset by which the line lengthens or shortens with bend.
        roll: of the middle tube against its assembled position, rad, on pairs only.
    """

    base_angle: float = 0.0
    upward_force: float = 0.0
    gravity: float = 1.0
    held_curvature: float = 0.0
    axis_share: float = 0.0
    roll: float = 0.0


@dataclass(frozen=True, slots=True)
class Photographed:
    """What a set of shapes holds, for choosing starts.

    Attributes:
        tubes: number (as in ``TUBE``) and name of every tube photographed. alone: numbers of those seen outside a pair.
        length: of the longest, m. weight: of the heaviest, N. pairs: whether there is an assembled pair.
        natural: the largest natural curvature of the tubes, 1/m, as a size. mass: of the heaviest, kg.
    """

    tubes: Mapping[int, str]
    alone: frozenset[int]
    length: float
    weight: float
    pairs: bool
    natural: float = 0.0
    mass: float = 1e-6

    @property
    def scales(self) -> Mapping[Scale, float]:
        """What the starts of a parameter may be multiples of."""
        return {"": 1.0, "weight": self.weight / MILLINEWTON, "gradient": MILLIMETRE / self.length}


def spots(seen: Photographed) -> list[float]:
    """Return arc lengths (mm) all along the tube from which a place is looked for."""
    found: list[float] = ((np.arange(_SPOTS) + 0.5) / _SPOTS * seen.length / MILLIMETRE).tolist()
    return found


def hump(pieces: Pieces, arc_length_mm: float) -> FloatArray:
    """Return a triangle round an arc length as its mean over each piece, 1/m; its integral along the tube is one."""
    ends = np.concatenate(([0.0], np.cumsum(pieces.length)))
    off = np.clip((ends - arc_length_mm * MILLIMETRE) / (_SPREAD * MILLIMETRE), -1.0, 1.0)
    below = np.where(off < 0.0, 0.5 * (1.0 + off) ** 2, 1.0 - 0.5 * (1.0 - off) ** 2)
    return np.asarray(np.diff(below) / pieces.length)


class OnShapes(Effect):
    """Anything that acts on photographed tubes.

    ``changes_tubes`` marks effects of the geometry itself, which shows on tubes that were photographed alone; ``is_local`` those
    shorter than a few pitches; ``of_stock`` those that a corrected configuration holds as numbers of the tubes themselves.
    ``order`` is the power of its amplitude with which a small effect grows.
    """

    stage: ClassVar[Stage] = "structure"
    recordings: ClassVar[tuple[RecordingKind, ...]] = ("shapes",)
    changes_tubes: ClassVar[bool] = False
    is_local: ClassVar[bool] = False
    of_stock: ClassVar[bool] = False
    order: ClassVar[int] = 1

    @classmethod
    def fitted(cls) -> tuple[Parameter, ...]:
        """Return the parameters that a fit moves."""
        return tuple(p for p in cls.parameters_on("shapes") if p.role in ("size", "shape"))

    @property
    def variant(self) -> tuple[str, float]:
        """Its id and what was chosen for it: the number of the tube it sits on, or whether tubes differ; 0 by default."""
        return self.id, float(getattr(self, "tube", getattr(self, "by_tube", 0.0)))

    def fitted_values(self) -> FloatArray:
        """Return their values."""
        return np.array([getattr(self, parameter.name) for parameter in self.fitted()])

    def with_fitted(self, values: FloatArray) -> Self:
        """Return the effect with them replaced."""
        return replace(self, **{p.name: float(v) for p, v in zip(self.fitted(), values, strict=True)})

    @classmethod
    def places(cls, seen: Photographed) -> list[float]:
        """Return the tubes it may sit on: all at once, and each that was photographed alone."""
        if not seen.alone:
            return []
        return [0.0, *sorted(map(float, seen.alone))] if len(seen.tubes) > 1 else [0.0]

    @classmethod
    def each(cls, seen: Photographed) -> list[float]:
        """Return the tubes one of which has it: each that was photographed alone."""
        return sorted(map(float, seen.alone)) if len(seen.tubes) > 1 else [0.0] * len(seen.alone)

    @classmethod
    def starts(cls, seen: Photographed) -> list[Self]:
        """Return where fits are started: every start of every parameter, on every tube and on all of them.

        None where a tube's own geometry is in question and no tube was photographed alone.
        """
        if cls.changes_tubes and not seen.alone:
            return []
        choices = []
        for parameter in cls.parameters_on("shapes"):
            if parameter.role == "tube":
                choices.append(cls.places(seen))
            elif parameter.role == "by_tube":
                choices.append([0.0, 1.0] if len(seen.alone) > 1 else [0.0])
            else:
                size = seen.scales[parameter.relative_to]
                choices.append([float(np.clip(s * size, parameter.low, parameter.high)) for s in parameter.starts])
        names = [parameter.name for parameter in cls.parameters_on("shapes")]
        return [cls(**dict(zip(names, values, strict=True))) for values in product(*choices)]

    @classmethod
    def widths(cls, seen: Photographed) -> FloatArray:
        """Return the prior width of each fitted parameter: what it costs to have one."""
        found = []
        for parameter in cls.fitted():
            size, null = seen.scales[parameter.relative_to], 0.0 if parameter.relative_to else parameter.null
            most = max(abs(start * size - null) for start in parameter.starts)
            found.append(2.0 * max(most, 1e-9) if parameter.expected is None else parameter.expected[1])
        return np.array(found)

    def scaled(self, amount: float) -> Self:
        """Return the effect made ``amount`` times as strong, to first order, inside its ranges."""
        parameter = self.fitted()[0]
        value = getattr(self, parameter.name)
        factor = float(np.sign(amount) * np.clip(abs(amount), 1e-3, 30.0) ** (1.0 / self.order))
        inside = 0.02 * (parameter.high - parameter.low)
        moved = float(
            np.clip(parameter.null + (value - parameter.null) * factor, parameter.low, parameter.high - inside)
        )
        return replace(self, **{parameter.name: moved})

    @classmethod
    def one_sided(cls) -> bool:
        """Return whether the effect cannot be turned round: it is null at the end of its range."""
        parameter = cls.fitted()[0]
        return parameter.null <= parameter.low

    def acts_on(self, number: int) -> bool:
        """Return whether the effect sits on the tube of that number."""
        chosen = getattr(self, "tube", 0.0)
        return chosen in {0.0, float(number)}

    def differing(self, share: float) -> Self:
        """Return the effect as it is on a tube that differs from the rest by a share of it."""
        return self


class OnPieces(OnShapes):
    """A tube's pieces, uncut and cut."""

    def pieces(self, pieces: Pieces) -> Pieces:
        """Change a tube's pieces."""
        return pieces


class OnBench(OnShapes):
    """Clamp, loads and what the picture shows of the line's length."""

    def loads(self, loads: Loads) -> Loads:
        """Change clamp and loads."""
        return loads


class OnPair(OnBench):
    """How two tubes are assembled: what only a pair can have."""


class OnImage(OnShapes):
    """The camera."""

    stage: ClassVar[Stage] = "sensor"

    def see(self, x: FloatArray, y: FloatArray, centre: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Change places (m) on their way through the camera; ``centre`` is the middle of the picture."""
        return x, y
