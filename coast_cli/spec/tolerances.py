"""The ``[tolerances]`` table: how far a finished tube may be from its drawing, and how the error is distributed.

Defaults are those of drawn nitinol tube stock and of laser notches; what has no source has no default and is not varied.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from coast_cli.spec.values import Allowed, Document, Within


class Tolerance(Document):
    """A symmetric tolerance."""

    plus_minus: Annotated[float, Within(0.0, 100.0)] = Field(
        description="half width; of a normal distribution two standard deviations (95 % lie within)"
    )
    distribution: Annotated[Literal["normal", "uniform"], Allowed("'normal' or 'uniform'")] = Field(
        "normal", description="normal, or uniform over the whole width"
    )


class Tolerances(Document):
    """What varies: diameters and modulus from stock to stock, the rest from sample to sample, all its notches alike."""

    outer_diameter_mm: Tolerance = Field(
        Tolerance(plus_minus=0.007), description="outer diameter, mm; default 0.007, of drawn tube stock"
    )
    inner_diameter_mm: Tolerance = Field(
        Tolerance(plus_minus=0.015), description="inner diameter, mm; default 0.015, of drawn tube stock"
    )
    depth_mm: Tolerance = Field(
        Tolerance(plus_minus=0.01), description="notch depth, mm; default 0.01, of laser notches"
    )
    cut_mm: Tolerance | None = Field(None, description="length of a notch, mm; the pitch stays, so uncut gives way")
    youngs_modulus_percent: Tolerance | None = Field(None, description="Young's modulus, per cent")
    natural_curvature_per_m: Tolerance | None = Field(None, description="natural curvature, 1/m")
    roll_deg: Tolerance | None = Field(
        None, description="roll of the outer about the middle tube away from 180 degrees, degrees"
    )
