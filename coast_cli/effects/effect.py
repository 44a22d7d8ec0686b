"""What an effect is: a frozen object that declares its parameters with ranges and sources, and its null.

What it does it says by the stages that it is made of (``stages`` for joints, ``shape_stages`` for photographs), each with a
method of its own. Stages act in one order whatever order effects are listed in, because they do not commute: drive, tendon,
transmission, structure, sensor. Parameters carry the user's unit in their name (``width_mm``); the methods convert.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import ClassVar, Literal, Self, TypedDict, TypeVar

import numpy as np

from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray

Stage = Literal["drive", "tendon", "transmission", "structure", "sensor"]
Kind = Literal["physics", "sensor", "parameter"]
Scope = Literal["tube", "bench", "camera"]
RecordingKind = Literal["joint", "shapes"]
Need = Literal[
    "stroke",
    "time",
    "release",
    "hold",
    "rates",
    "reversals",
    "pairs",
    "outer",
    "linear_tubes",
    "runs",
    "witness",
    "period",
    "load",
    "far_end",
    "flat_end",
    "frozen",
    "force",
]
Scale = Literal[
    "",
    "curvature",
    "strain",
    "stress",
    "closure",
    "tension",
    "duration",
    "response",
    "stroke",
    "period",
    "compliance",
    "runs",
    "weight",
    "gradient",
]
STAGES: tuple[Stage, ...] = ("drive", "tendon", "transmission", "structure", "sensor")


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: field of the effect, unit in the suffix.
        null: the value at which the effect vanishes, or a usual value of a shape.
        low, high: range outside which the value is not believed.
        starts: values from which a fit is started, as given or, with ``relative_to``, times that scale of the data.
        source: where the range comes from.
        needs: what a recording must hold for this number to be looked for; elsewhere it stays at its null.
        role: "size" where the null makes the effect vanish, "shape" where it only says how it acts; "run", "tube" or "by_tube"
            where it says on which one it sits and "moment" when, which is chosen; "found" where the rows themselves say it.
        relative_to: the largest of this in the recording is what ``starts`` are multiples of; empty for absolute. Of
            photographs "weight" is a tube's, mN, and "gradient" what changes a curvature by 1/m over its length.
        expected: mean and standard deviation where physics foretells it. logarithmic: whether a fit moves it by factors.
            Of joints only a parameter with both: median, and standard deviation of the natural logarithm.
    """

    name: str
    null: float
    low: float
    high: float
    starts: tuple[float, ...]
    source: str
    relative_to: Scale = ""
    role: Literal["size", "shape", "run", "tube", "by_tube", "moment", "found"] = "size"
    needs: Need | None = None
    expected: tuple[float, float] | None = None
    logarithmic: bool = False


# Shared by the effects that bend the segment at rest: whether the stroke is zeroed on the straight or the rest shape.
HOMED = Parameter(
    "homed", 0.0, 0.0, 1.0, (0.0, 1.0), "0: zeroed once on a straight segment; 1: at rest before each run", role="shape"
)
# Which run an effect of one run sits on: every run is tried.
RUN = Parameter("run", 0.0, 0.0, 1e6, (0.0,), "number of the run in the recording, from 0", role="run")


@dataclass(frozen=True, slots=True)
class History:
    """What the drive did in one run, row by row; SI, shape (n,).

    ``stroke`` is None for a tension-driven run; where both are given the stroke drives. ``time`` is None where not
    recorded. ``earlier_tension`` is the largest tension (N) that earlier runs of the recording reached; ``run`` the run's
    number in the recording, from 0; ``load`` what the far end carries (N or N m), and ``tip_force`` the force at the
    tip of a notched segment (N, across it, positive as the tendon bends), where recorded. Of a device without tubes
    ``first_response`` is the first that was recorded (SI), and ``start`` the drive that it stands for.
    """

    time: FloatArray | None
    stroke: FloatArray | None
    tension: FloatArray | None
    bending_length: FloatArray
    earlier_tension: float = 0.0
    run: int = 0
    load: FloatArray | None = None
    tip_force: FloatArray | None = None
    first_response: float | None = None
    start: float | None = None

    @property
    def drive(self) -> FloatArray:
        """Stroke where there is one, else tension."""
        found = self.tension if self.stroke is None else self.stroke
        return np.zeros_like(self.bending_length) if found is None else found


@dataclass(frozen=True, slots=True)
class Motion:
    """What a run's own tension (N, at the actuator) and mean curvature (1/m) were, row by row, each shape (n,).

    ``tension_per_curvature`` is the actuator's tension that one 1/m of curvature costs, N m, shape (n,).
    """

    history: History
    tension: FloatArray
    curvature: FloatArray
    tension_per_curvature: FloatArray


class Otherwise(TypedDict, total=False):
    """What an effect of joints and photographs alike declares otherwise of photographs."""

    title: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    needs: tuple[Need, ...]
    unlikely: float
    decided_by: str


@dataclass(frozen=True)
class Effect:
    """Base of all effects; its stages say what it does.

    ``needs`` is what a recording must hold for the effect to show at all, ``unlikely`` the nats by which it starts behind
    the others, negative where theory says that it is always there. ``reverses`` says that load and release follow different
    branches, ``varies_along`` that notches bend differently by their place. ``scope`` says what it belongs to: what is not the
    tubes' own never goes along to another kind of recording. ``decided_by`` is the recording that tells the effect from its
    look-alikes. ``recordings`` follows from the stages; what it declares otherwise of photographs stands in ``on_shapes``.
    """

    id: ClassVar[str]
    title: ClassVar[str]
    component: ClassVar[str]
    kind: ClassVar[Kind] = "physics"
    stage: ClassVar[Stage]
    scope: ClassVar[Scope] = "tube"
    equation: ClassVar[str]
    source: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    expected: ClassVar[Mapping[str, tuple[float, float]]] = {}
    needs: ClassVar[tuple[Need, ...]] = ()
    unlikely: ClassVar[float] = 0.0
    reverses: ClassVar[bool] = False
    varies_along: ClassVar[bool] = False
    decided_by: ClassVar[str]
    recordings: ClassVar[tuple[RecordingKind, ...]] = ()
    on_shapes: ClassVar[Otherwise] = {}

    def __init_subclass__(cls) -> None:
        """Act on what the stages act on, joints first, unless the class says otherwise."""
        super().__init_subclass__()
        if "recordings" not in cls.__dict__:
            served = {recording for base in cls.__mro__[1:] for recording in getattr(base, "recordings", ())}
            cls.recordings = tuple(sorted(served))

    @classmethod
    def null(cls) -> Self:
        """Return the effect at which nothing changes."""
        parameters = (*cls.parameters, *cls.parameters_on("shapes"))
        return cls(**{parameter.name: parameter.null for parameter in parameters})

    @classmethod
    def parameters_on(cls, recording: RecordingKind) -> tuple[Parameter, ...]:
        """Return the parameters that it has on a kind of recording."""
        return cls.on_shapes.get("parameters", cls.parameters) if recording == "shapes" else cls.parameters

    def values(self) -> tuple[float, ...]:
        """Return the parameters in declared order."""
        return tuple(getattr(self, parameter.name) for parameter in self.parameters)

    def with_values(self, values: FloatArray) -> Self:
        """Return the effect with its parameters replaced, in declared order."""
        return replace(self, **{p.name: float(v) for p, v in zip(self.parameters, values, strict=True)})

    def numbers(self) -> dict[str, float]:
        """Return all its parameters by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def idle(self) -> tuple[str, ...]:
        """Names of parameters that do nothing as the effect stands, which no fit moves."""
        return ()

    def with_numbers(self, numbers: Mapping[str, float]) -> Self:
        """Return the effect with some of them replaced."""
        return replace(self, **numbers)

    def acts_at(self, stage: type[Effect]) -> bool:
        """Return whether it acts at a stage that it is made of."""
        return True


StageOf = TypeVar("StageOf", bound=Effect)


def acting(effects: Iterable[Effect], stage: type[StageOf]) -> list[StageOf]:
    """Return the effects that act at a stage, in their order."""
    return [effect for effect in effects if isinstance(effect, stage) and effect.acts_at(stage)]


@dataclass(frozen=True, slots=True)
class Declared:
    """What an effect declares of one kind of recording, as ``Effect`` has it."""

    title: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    needs: tuple[Need, ...]
    unlikely: float
    decided_by: str


def declared(effect: Effect | type[Effect], recording: RecordingKind) -> Declared:
    """Return what an effect declares of a kind of recording."""
    found = Declared(**{field.name: getattr(effect, field.name) for field in fields(Declared)})
    return replace(found, **effect.on_shapes) if recording == "shapes" else found


@dataclass(frozen=True, slots=True)
class Segment:
    """The bending segment that a moment law describes, at m stations (one where all notches are alike).

    Attributes:
        rigidity: flexural rigidity, N m^2, shape (m, 1). bending_length: X2, m. joint: the tubes.
        strain_per_curvature: strain of the strip's outer fibre for one 1/m of segment curvature, m, shape (m, 1).
        closing_curvature: curvature at which the faces of a notch touch by geometry, 1/m, shape (m, 1).
        position: arc length of each station from the clamp of the segment, m, shape (m, 1); None for one station.
    """

    rigidity: FloatArray
    bending_length: float
    joint: Joint
    strain_per_curvature: FloatArray
    closing_curvature: FloatArray
    position: FloatArray | None = None
