"""What an effect is: a frozen object that declares its stage, its parameters with ranges and sources, and its null.

Effects act at five stages, always in this order whatever order they are listed in, because they do not commute:
drive, tendon, transmission, structure, sensor. Each stage has one method, which is the identity unless overridden.
Parameters carry the user's unit in their name (``width_mm``); the methods convert.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self

import numpy as np

from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray

Stage = Literal["drive", "tendon", "transmission", "structure", "sensor"]
Kind = Literal["physics", "sensor", "parameter"]
Scope = Literal["tube", "bench", "camera"]
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
    "clipped",
    "frozen",
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
        role: "size" where the null makes the effect vanish, "shape" where it only says how it acts, "run" where it is the
            number of a run, which is chosen, "found" where the rows themselves say it; neither is fitted.
        relative_to: the largest of this in the recording is what ``starts`` are multiples of; empty for absolute.
    """

    name: str
    null: float
    low: float
    high: float
    starts: tuple[float, ...]
    source: str
    relative_to: Scale = ""
    role: Literal["size", "shape", "run", "found"] = "size"
    needs: Need | None = None


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
    number in the recording, from 0; ``load`` what the far end carries (N or N m), where recorded.
    """

    time: FloatArray | None
    stroke: FloatArray | None
    tension: FloatArray | None
    bending_length: FloatArray
    earlier_tension: float = 0.0
    run: int = 0
    load: FloatArray | None = None

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


@dataclass(frozen=True)
class Effect:
    """Base of all effects: every stage is the identity.

    ``needs`` is what a recording must hold for the effect to show at all, ``unlikely`` the nats by which it starts behind
    the others. ``reverses`` says that load and release follow different branches, ``varies_along`` that notches bend
    differently by their place. ``scope`` says what it belongs to: what is not the tubes' own never goes along to another
    kind of recording. ``decided_by`` is the recording that tells the effect from its look-alikes.
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
    needs: ClassVar[tuple[Need, ...]] = ()
    unlikely: ClassVar[float] = 0.0
    reverses: ClassVar[bool] = False
    varies_along: ClassVar[bool] = False
    decided_by: ClassVar[str]

    @classmethod
    def null(cls) -> Self:
        """Return the effect at which nothing changes."""
        return cls(**{parameter.name: parameter.null for parameter in cls.parameters})

    def values(self) -> tuple[float, ...]:
        """Return the parameters in declared order."""
        return tuple(getattr(self, parameter.name) for parameter in self.parameters)

    def with_values(self, values: FloatArray) -> Self:
        """Return the effect with its parameters replaced, in declared order."""
        return replace(self, **{p.name: float(v) for p, v in zip(self.parameters, values, strict=True)})

    @property
    def lumps(self) -> int:
        """Into how many parts that move by themselves the effect divides a segment of equal notches."""
        return 1

    def joint(self, joint: Joint) -> Joint:
        """Change the joint itself (section, end effect), before anything else."""
        return joint

    def drive(self, history: History) -> History:
        """Change what the drive does before it reaches the tendon."""
        return history

    def stretch(self, stretch: FloatArray, tension: FloatArray, joint: Joint) -> FloatArray:
        """Change the tendon's elongation (m) at each tension (N); memoryless and increasing."""
        return stretch

    def slack(self, tension: FloatArray, history: History, joint: Joint) -> FloatArray:
        """Return tendon length (m) that the history of tension (N) has added by each row."""
        return np.zeros_like(tension)

    def drag(self, motion: Motion) -> FloatArray:
        """Return the tension (N, at the actuator) that the motion of the segment takes, row by row."""
        return np.zeros_like(motion.tension)

    def weigh(self, tension: FloatArray, history: History) -> FloatArray:
        """Change the tension (N) on its way through the load cell."""
        return tension

    def settle(self, curvature: FloatArray, history: History, joint: Joint, rigidity: float, arm: float) -> FloatArray:
        """Let the segment's curvature (n, m) come late; ``rigidity`` in N m^2, ``arm`` the tendon's lever arm, m."""
        return curvature

    @property
    def shapes_branches(self) -> bool:
        """Whether the effect is part of the tabulated load and release branches."""
        return self._overrides("friction", "notch_friction", "moment", "lumps")

    @property
    def slackens(self) -> bool:
        """Whether the effect adds tendon length by the history of tension."""
        return self._overrides("slack")

    @property
    def drags(self) -> bool:
        """Whether the effect takes tension row by row."""
        return self._overrides("drag")

    def _overrides(self, *stages: str) -> bool:
        return any(getattr(type(self), stage) is not getattr(Effect, stage) for stage in stages)

    def friction(self, direction: int, joint: Joint, bending_length: float) -> float:
        """Return the exponent added to ln(actuator tension / tension at the segment), load (+1) or release (-1)."""
        return 0.0

    def notch_friction(self) -> tuple[float, float]:
        """Return the coefficient by which tension decays with each notch's bend, and the share of its own bend in it."""
        return 0.0, 0.0

    def homing(self) -> float:
        """Return the share (0 to 1) of the rest shape's tendon path that the zero of the stroke already counts."""
        return 0.0

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Change the moment (N m) that holds each curvature (1/m), on load (+1) or release (-1)."""
        return moment

    def drift(self, time: FloatArray) -> FloatArray | None:
        """Return how far (0 to 1) a slow change of the structure has come at each time (s), or None for none."""
        return None

    def drifted(self, share: float) -> tuple[float, float]:
        """Return the factor on stiffness and the curvature at rest (1/m) when a slow change has come so far."""
        return 1.0, 0.0

    @property
    def rounding(self) -> float:
        """Standard deviation of ln of the play's width along the path: ends of the wait are rounded by it."""
        return 0.0

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Change the response, shape (n, k), on its way through the camera; in the recording's SI unit."""
        return response


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
