"""The configuration document: what each table and key of a ``tubes.toml`` means, its unit and its range.

A stock tube (``[outer]``, ``[middle]``) is shared by its samples, and a sample may override any field of it. A joint of
one notched tube has no ``[outer]``. Tables that a command does not need may be left out.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, PrivateAttr, Tag

from coast_cli.errors import BadInput
from coast_cli.spec.explore import Explore
from coast_cli.spec.positions import Path, Position
from coast_cli.spec.superelastic import SuperelasticFields
from coast_cli.spec.tolerances import Tolerances
from coast_cli.spec.transmission import KINDS, NOTCHED, TRANSMISSION, TransmissionFields, kind_of
from coast_cli.spec.values import (
    Allowed,
    Calibrated,
    Curvature,
    Diameter,
    Document,
    EndEffect,
    Length,
    Modulus,
    Name,
    SectionChoice,
    Within,
    nominal,
)

FATIGUE_AMPLITUDE, FATIGUE_CYCLES = 0.004, 10_000_000


class Material(Document):
    """A tube material."""

    youngs_modulus_gpa: Modulus = Field(description="Young's modulus of the austenite, GPa")
    density_kg_per_m3: Annotated[float, Within(100.0, 30_000.0)] = Field(description="density, kg/m^3")
    superelastic: SuperelasticFields | None = Field(
        None, description="stress-strain curve past the elastic range; left out for a linear material"
    )


class Environment(Document):
    """What surrounds the robot."""

    gravity_m_per_s2: Annotated[float, Within(0.0, 1e6)] = Field(9.81, description="gravity along -y, m/s^2")


class Notch(Document):
    """The notch pattern: one pitch is uncut and then cut, starting with uncut at the clamp."""

    cut_mm: Length | None = Field(None, description="length of a notch along the tube, mm")
    uncut_mm: Length | None = Field(None, description="length of full ring before each notch, mm")
    count: Annotated[int, Within(1, 100_000)] | None = Field(None, description="number of notches")


class TubeFields(Document):
    """What describes a notched tube; a sample overrides any of these fields of its stock."""

    material: Name | None = Field(None, description="name of a table under [materials]")
    outer_diameter_mm: Diameter | None = Field(None, description="outer diameter, mm")
    inner_diameter_mm: Diameter | None = Field(None, description="inner diameter, mm")
    notch: Notch | None = Field(None, description="the notch pattern; a sample may override single keys of it")
    depth_mm: Annotated[float | tuple[float, ...], Within(0.001, 100.0)] | None = Field(
        None, description="notch depth from the outer surface, mm; a list has one depth for each notch, clamp to tip"
    )
    natural_curvature_per_m: Curvature | None = Field(
        None, description="curvature left by the laser, 1/m; an outer tube bends against gravity, a middle one along"
    )
    section: SectionChoice | None = Field(None, description="what a notch leaves: radial walls or a straight cut")
    end_effect: EndEffect | None = Field(
        None, description="extra cut length by which stress spreads from strip to ring: none, the table, or mm"
    )


class Sample(TubeFields):
    """One tube on the bench."""

    name: Name = Field(description="its name, used in pairs and recordings")


class Stock(TubeFields):
    """A stock tube and the samples cut from it."""

    samples: tuple[Sample, ...] = Field(strict=False, min_length=1, description="the tubes cut from this stock")


class Inner(Document):
    """The uncut inner tube; its tip is where bending starts."""

    youngs_modulus_gpa: Modulus = Field(description="Young's modulus, GPa")
    outer_diameter_mm: Diameter = Field(description="outer diameter, mm")
    inner_diameter_mm: Diameter = Field(description="inner diameter, mm")


class TendonFields(Document):
    """The tendon, anchored on the inner wall of the middle tube."""

    radius_mm: Annotated[float, Within(0.001, 10.0)] = Field(description="radius, mm")
    youngs_modulus_gpa: Modulus = Field(description="Young's modulus, GPa")
    length_mm: Annotated[float | Calibrated, Within(0.1, 100_000.0)] = Field(
        description="length from actuator to tip, undeformed, mm"
    )


class JointFields(Document):
    """The stroke model of the joint, equations (9)-(12) of the paper."""

    kind: Annotated[Literal["notched"] | None, Allowed(KINDS)] = Field(
        None, description="what is driven: notched tubes, as where it is left out, or a transmission without tubes"
    )
    youngs_modulus_gpa: Modulus = Field(description="effective Young's modulus of the bending joint, GPa")
    pulley_friction: Annotated[float | Calibrated, Within(0.0, 5.0)] = Field(
        description="friction coefficient mu at the pulleys"
    )
    wrap_angle_rad: Annotated[float | Calibrated, Within(0.0, 100.0)] = Field(
        pi, description="wrap angle alpha of the tendon round the pulleys, rad"
    )
    notch_friction: Annotated[float | Calibrated, Within(1.0, 10.0)] = Field(
        description="ratio eta of tensions across one notch; 1 is no friction"
    )
    deadband_mm: Annotated[float | Calibrated, Within(0.0, 100.0)] = Field(
        0.0, description="stroke spent before the tendon is taut, mm"
    )
    outer_cover_mm: Length | None = Field(
        None,
        description="how far beyond the inner tube's tip the outer tube covers the middle one, mm; further on the middle tube"
        " bends alone, so that longer bends are uneven (25 in the paper's recordings); default: everywhere",
    )
    pair: Annotated[str | None, Field(min_length=1), Allowed("'OUTER/MIDDLE', or the name of one tube")] = Field(
        None, description="the pair a command answers for where none is named: 'OUTER/MIDDLE', or one tube"
    )


JointTable = Annotated[
    Annotated[JointFields, Tag(NOTCHED)] | Annotated[TransmissionFields, Tag(TRANSMISSION)], Discriminator(kind_of)
]


class RatioLimits(Document):
    """Bounds of the rigidity ratio, outer over middle."""

    min: Annotated[float, Within(0.0, 1e9)] | None = Field(None, description="smallest ratio that passes")
    max: Annotated[float, Within(0.0, 1e9)] | None = Field(None, description="largest ratio that passes")
    rigidity: Annotated[Literal["mean", "series"], Allowed("'mean' or 'series'")] = Field(
        "mean", description="which rigidity: the mean along the tube (the paper's), or in series (what bends)"
    )


class LimitAtPoint(Document):
    """A limit that holds where the joint is bent to a curvature over a bending length."""

    value: Annotated[float, Within(0.0, 1e6)] = Field(description="the limit")
    curvature_per_m: Annotated[float, Within(0.0, 1000.0, above=True)] = Field(description="curvature, 1/m")
    bending_length_mm: Length = Field(description="bending length X2, mm")


class Reach(Document):
    """How far the pair must bend within its other limits."""

    value: Annotated[float, Within(0.0, 3600.0, above=True)] = Field(description="bend that must be reached, degrees")
    bending_length_mm: Length = Field(description="bending length X2, mm")


class Fatigue(Document):
    """The strain that the webs stand again and again, between straight and the point of max_stroke_mm."""

    cycles: Annotated[int, Within(1, 1_000_000_000)] = Field(10_000_000, description="bends that the tubes must stand")
    max_strain_amplitude: Annotated[float, Within(0.0, 1.0, above=True)] | None = Field(
        None,
        description="half of the largest web strain's range; default 0.004 for up to 10^7 cycles, which is assumed: quoted from"
        " memory of Pelton and others, J. Mech. Behav. Biomed. Mater. 1, 2008, and not read there",
    )
    source: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        None, description="where max_strain_amplitude comes from, in words"
    )

    @property
    def amplitude(self) -> float:
        """The limit of the strain amplitude."""
        return FATIGUE_AMPLITUDE if self.max_strain_amplitude is None else self.max_strain_amplitude

    @property
    def origin(self) -> str:
        """Where the limit comes from, in words."""
        if self.max_strain_amplitude is None:
            return f"{FATIGUE_AMPLITUDE:g} is assumed (as literature on nitinol has it, from memory)"
        return f"{self.max_strain_amplitude:g} is of {self.source or 'a source that is not named'}"


class Checks(Document):
    """What ``coast check`` holds the joint's pair to."""

    max_total_precurvature_rad: Annotated[float, Within(0.0, 1e3)] | None = Field(
        None, description="largest total pre-curvature of the pair, rad"
    )
    rigidity_ratio: RatioLimits | None = Field(None, description="bounds of the rigidity ratio, outer over middle")
    max_stroke_mm: LimitAtPoint | None = Field(None, description="largest stroke, mm, at a curvature and length")
    max_tendon_strain: Annotated[float, Within(0.0, 1.0, above=True)] | None = Field(
        None, description="largest tendon strain, at the curvature and length of max_stroke_mm"
    )
    max_tension_n: Annotated[float, Within(0.0, 1e4, above=True)] | None = Field(
        None, description="largest tendon tension at the actuator, N, at the curvature and length of max_stroke_mm"
    )
    max_web_strain: Annotated[float, Within(0.0, 1.0, above=True)] | None = Field(
        None, description="largest strain of what the notches leave, at the curvature of max_stroke_mm"
    )
    min_closure_margin: Annotated[float, Within(0.0, 1e3, above=True)] | None = Field(
        None, description="curvature at which the first notch closes over that of max_stroke_mm; above 1 it stays open"
    )
    fatigue: Fatigue | None = Field(None, description="strain amplitude of the webs between straight and max_stroke_mm")
    min_bend_deg: Reach | None = Field(
        None,
        description="bend that the pair reaches at a bending length with open notches and every limit on stroke, tendon"
        " strain, tension and web strain held",
    )
    min_snap_margin: Annotated[float, Within(-100.0, 1.0)] | None = Field(
        None,
        description="forecast margin of `coast snap` at the bending length of max_stroke_mm; below 0 the pair would jump. Held"
        " by `coast check` alone: tolerance and explore leave it out",
    )


class Rank(Document):
    """What the criteria of the ranking are divided by: absolute references, so that no pair's score rests on another."""

    total_precurvature_rad: Annotated[float, Within(0.0, 1e3, above=True)] | None = Field(
        None,
        description="total pre-curvature that counts as 1, rad; default: checks.max_total_precurvature_rad, else 0.3",
    )
    rigidity_ratio: Annotated[float, Within(1.0, 1e9, above=True)] | None = Field(
        None,
        description="rigidity ratio, either way, whose |ln| counts as 1; default: the bound of checks.rigidity_ratio nearer"
        " to 1, else 1.25",
    )
    total_rigidity_n_m2: Annotated[float, Within(0.0, 1e6, above=True)] | None = Field(
        None, description="total rigidity that counts as 1, N m^2; default: 1e-4, about the two uncut tubes"
    )
    source: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        None, description="where these values come from, in words"
    )


class Actuator(Document):
    """The motor that pulls the tendon."""

    steps_per_mm: Annotated[float, Within(0.0, 1e7, above=True)] = Field(
        description="steps of the motor, or counts of its encoder, for one mm of stroke X1"
    )


class Fitted(Document):
    """How sure the numbers are that a calibration or a diagnosis fitted, as it wrote them."""

    keys: tuple[Annotated[str, Field(max_length=200)], ...] = Field(
        strict=False, min_length=1, max_length=200, description="dotted keys of the fitted numbers"
    )
    std: tuple[Annotated[float, Field(ge=0.0, le=1e9)], ...] = Field(
        strict=False, description="standard deviation of each, in the unit of its key"
    )
    correlation: tuple[Annotated[tuple[Annotated[float, Field(ge=-1.0, le=1.0)], ...], Field(strict=False)], ...] = (
        Field(strict=False, description="of each with each, a row a key")
    )


@dataclass(frozen=True)
class Origin:
    """The file a configuration was read from, its text and the places of its keys."""

    file: str | None = None
    positions: dict[Path, Position] = field(default_factory=dict)
    text: str = ""

    def refuse(
        self, path: Path, message: str, *, found: object = None, allowed: str | None = None, hint: str | None = None
    ) -> BadInput:
        """Return the error that says what is wrong at a key, placed at the key or at its nearest table."""
        place = self.place(path)
        line, column = (None, None) if place is None else place
        return BadInput(
            message, file=self.file, line=line, column=column, key=dotted(path), found=found, allowed=allowed, hint=hint
        )

    def place(self, path: Path) -> Position | None:
        """Return where a key stands, or else the nearest table above it."""
        ends = range(len(path), 0, -1)
        return next((self.positions[path[:end]] for end in ends if path[:end] in self.positions), None)


class Config(Document):
    """A whole configuration file; units are in the names of its keys."""

    version: Annotated[Literal[1], Allowed("1")] = Field(1, description="version of this format")
    materials: Annotated[dict[Name, Material], Field(min_length=1)] = Field(
        default_factory=dict, description="tube materials by name; a transmission has none"
    )
    environment: Environment = Field(default_factory=Environment, description="what surrounds the robot")
    outer: Stock | None = Field(None, description="outer tubes; left out for a joint of one notched tube")
    middle: Stock | None = Field(None, description="middle tubes")
    inner: Inner | None = Field(None, description="the uncut inner tube")
    tendon: TendonFields | None = Field(None, description="the tendon; left out where tension is the drive")
    joint: JointTable | None = Field(None, description="the stroke model of the joint, or a transmission")
    checks: Checks | None = Field(None, description="limits that `coast check` holds the pair to")
    rank: Rank | None = Field(None, description="references that `coast rank-pairs` measures its criteria in")
    explore: Explore | None = Field(None, description="design space that `coast explore` searches")
    tolerances: Tolerances | None = Field(None, description="how far finished tubes may be from the drawing")
    corrections: dict[str, dict[str, float | str | list[float]]] = Field(
        default_factory=dict, description="effects that a diagnosis found, by id, with their fitted parameters"
    )

    actuator: Actuator | None = Field(None, description="the motor that pulls the tendon")
    fitted: Fitted | None = Field(None, description="how sure fitted numbers are, as a saved model has it")

    _origin: Origin = PrivateAttr(default_factory=Origin)

    def __repr__(self) -> str:
        """Return the file, the tubes and the pair in one line; ``model_dump()`` has all of it."""
        tubes = [stock.samples for stock in (self.outer, self.middle) if stock is not None]
        names = ", ".join(sample.name for samples in tubes for sample in samples)
        pair = None if self.joint is None else self.joint.pair
        return f"Config: {self.source or '<text>'}, tubes {names or 'none'}, pair {pair or 'not named'}"

    __str__ = __repr__

    @property
    def source(self) -> str:
        """The file the configuration was read from, or an empty string."""
        return self._origin.file or ""

    def refuse(self, path: Path, message: str, **facts: Any) -> BadInput:  # noqa: ANN401
        """Return the error that says what is wrong at a key; see ``Origin.refuse``."""
        return self._origin.refuse(path, message, **facts)

    @property
    def origin(self) -> Origin:
        """Where it was read from; empty for a configuration made in Python."""
        return self._origin

    def line(self, *path: str | int) -> int | None:
        """Return the line of a key, or of the nearest table above it."""
        place = self._origin.place(path)
        return None if place is None else place.line

    def bounds(self, key: str) -> tuple[float, float, float]:
        """Return (value, min, max) of a number by its dotted key, e.g. ``joint.youngs_modulus_gpa``.

        A plain number may move in the whole range of its field.
        """
        *tables, last = key.split(".")
        document: Any = self
        for name in tables:
            document = document[name] if isinstance(document, dict) else getattr(document, name)
        number = getattr(document, last)
        if isinstance(number, Calibrated):
            return number.value, number.min, number.max
        limits = next(item for item in type(document).model_fields[last].metadata if isinstance(item, Within))
        return nominal(number), limits.low, limits.high


def dotted(path: Path) -> str:
    """Return a path as a reader would write it, e.g. ``outer.samples[0].name``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text
