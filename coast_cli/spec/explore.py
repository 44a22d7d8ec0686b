"""The ``[explore]`` table: what a designer may change of the tubes, how far, and what makes a pair better."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from coast_cli.spec.values import Allowed, Document, Within

if TYPE_CHECKING:
    from coast_cli.spec.config import Config
    from coast_cli.spec.positions import Path

Objective = Literal[
    "total_precurvature", "rigidity_ratio", "total_rigidity", "stroke", "tendon_strain", "web_strain", "notch_closure"
]
RANKED: tuple[Objective, ...] = ("total_precurvature", "rigidity_ratio", "total_rigidity")
AT_A_POINT = frozenset({"stroke", "tendon_strain", "web_strain", "notch_closure"})
MOST_TUBES = 1_000_000


class Range(Document):
    """A range of lengths."""

    min: Annotated[float, Within(0.001, 1000.0)] = Field(description="smallest, mm")
    max: Annotated[float, Within(0.001, 1000.0)] = Field(description="largest, mm")
    step: Annotated[float, Within(1e-6, 1000.0)] | None = Field(
        None, description="step from min, mm: only those values are made; left out, any value is"
    )


class CountRange(Document):
    """A range of whole numbers."""

    min: Annotated[int, Within(1, 100_000)] = Field(description="smallest")
    max: Annotated[int, Within(1, 100_000)] = Field(description="largest")
    step: Annotated[int, Within(1, 100_000)] = Field(1, description="step from min")


class ExploredTube(Document):
    """What may change of one tube; the rest is that of the stock, or of its first sample."""

    depth_mm: Range | None = Field(None, description="notch depth")
    cut_mm: Range | None = Field(None, description="length of a notch")
    uncut_mm: Range | None = Field(None, description="length of full ring before each notch")
    outer_diameter_mm: Range | None = Field(None, description="outer diameter")
    inner_diameter_mm: Range | None = Field(None, description="inner diameter")
    count: CountRange | None = Field(None, description="number of notches")
    length_mm: Annotated[float, Within(0.01, 10_000.0)] | None = Field(
        None, description="notched length to keep, mm, instead of count: as many whole pitches as go into it"
    )

    @property
    def ranges(self) -> dict[str, Range | CountRange]:
        """The keys that have a range, in the order of the document."""
        values = {name: getattr(self, name) for name in type(self).model_fields if name != "length_mm"}
        return {name: value for name, value in values.items() if value is not None}


class Explore(Document):
    """The design space of both tubes, and what is sought in it."""

    sampling: Annotated[Literal["sobol", "grid"], Allowed("'sobol' or 'grid'")] = Field(
        "sobol", description="a scrambled Sobol sequence over the ranges, or every combination of their steps"
    )
    tubes: Annotated[int, Within(1, MOST_TUBES)] = Field(
        256, description="tubes of each role with sobol sampling; every outer is paired with every middle tube"
    )
    refinements: Annotated[int, Within(0, 100)] = Field(
        4, description="rounds in which new pairs are tried round the front, in ever smaller boxes"
    )
    seed: Annotated[int, Within(0, 2**31 - 1)] = Field(0, description="of the Sobol sequence's scrambling")
    objectives: Annotated[tuple[Objective, ...], Allowed("a list of " + ", ".join(Objective.__args__))] = Field(
        RANKED, strict=False, min_length=1, description="what should be small (notch_closure: large)"
    )
    rigidity: Annotated[Literal["mean", "series"], Allowed("'mean' or 'series'")] = Field(
        "mean", description="which rigidity the objectives take"
    )
    outside_samples: Annotated[Literal["refuse", "hold"], Allowed("'refuse' or 'hold'")] = Field(
        "refuse",
        description="depths past the measured samples, whose natural curvature nobody measured: refuse them, or hold the"
        " nearest sample's value",
    )
    outer: ExploredTube = Field(default_factory=ExploredTube, description="ranges of the outer tube")
    middle: ExploredTube = Field(default_factory=ExploredTube, description="ranges of the middle tube")


def check_explore(config: Config) -> None:
    """Check the ranges of ``[explore]``.

    Raises:
        BadInput: placed at the offending key.
    """
    explore = config.explore
    if explore is None:
        return
    if not (explore.outer.ranges or explore.middle.ranges):
        raise config.refuse(
            ("explore",), "nothing may change", allowed="a range under [explore.outer] or [explore.middle]"
        )
    for role in ("outer", "middle"):
        if getattr(config, role) is None:
            raise config.refuse(
                ("explore",), f"a pair needs an outer and a middle tube, and there is no [{role}] table"
            )
        tube: ExploredTube = getattr(explore, role)
        if tube.count is not None and tube.length_mm is not None:
            raise config.refuse(("explore", role, "count"), "both count and length_mm are given", allowed="one of them")
        points = 1.0
        for key, span in tube.ranges.items():
            path: Path = ("explore", role, key)
            if span.min >= span.max:
                raise config.refuse(
                    (*path, "min"), "the range is inverted", found=span.min, allowed=f"below {span.max:g}"
                )
            if span.step is None and explore.sampling == "grid":
                raise config.refuse(path, "a grid needs a step", allowed="step, or sampling = 'sobol'")
            points *= 1.0 if span.step is None else (span.max - span.min) / span.step + 1.0
        if explore.sampling == "grid" and points > MOST_TUBES:
            allowed = f"at most {MOST_TUBES} tubes"
            raise config.refuse(("explore", role), "the grid is too fine", found=f"{points:.3g} tubes", allowed=allowed)
    point = AT_A_POINT.intersection(explore.objectives)
    if point and (config.joint is None or config.checks is None or config.checks.max_stroke_mm is None):
        message = (
            f"{', '.join(sorted(point))} is taken at the point of checks.max_stroke_mm with [joint], which is not given"
        )
        raise config.refuse(("explore", "objectives"), message)
    if {"stroke", "tendon_strain"} & point and config.tendon is None:
        raise config.refuse(("explore", "objectives"), "a stroke needs a [tendon] table")
