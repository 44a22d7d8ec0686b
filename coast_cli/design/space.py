"""The design space of ``[explore]``: from shares of every range to tubes, one role at a time.

The natural curvature of a tube that nobody has cut yet is interpolated between the measured samples, linearly in the
notch depth; what cut, uncut and diameters do to it is not known.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tubes import Tubes
from coast_cli.spec.config import Config
from coast_cli.spec.explore import CountRange, Explore, ExploredTube, Range
from coast_cli.spec.superelastic import build_superelastic
from coast_cli.spec.tubes import BenchTube, Role, bench_tubes
from coast_cli.spec.values import nominal
from coast_cli.units import GIGAPASCAL, MILLIMETRE

KEYS = ("depth_mm", "cut_mm", "uncut_mm", "count", "outer_diameter_mm", "inner_diameter_mm")
_SAME_DEPTH = 1e-9  # mm
_WHOLE = 1e-9  # pitches
_DECIMALS = 9  # of a millimetre, so that steps print as they were meant


@dataclass(frozen=True)
class RoleSpace:
    """What may change of one role; everything else is that of its first sample.

    Attributes:
        first: the first sample. ranges: by key. tube: the table of the role. holds: keep the nearest sample's natural
            curvature outside the measured depths.
        measured: depths (mm) and natural curvatures (1/m, signed as the mechanics) of the samples, by rising depth.
    """

    role: Role
    first: BenchTube
    ranges: dict[str, Range | CountRange]
    tube: ExploredTube
    measured: tuple[FloatArray, FloatArray]
    youngs_modulus: float
    superelastic: Superelastic | None
    density: float

    @property
    def axes(self) -> int:
        """Number of ranges."""
        return len(self.ranges)

    def values(self, shares: FloatArray) -> dict[str, FloatArray]:
        """Return every key (mm, or a count) at shares of the ranges, shape (m, axes); steps are kept."""
        count = len(shares)
        found = {key: np.full(count, getattr(self.first, key), dtype=float) for key in KEYS if key != "depth_mm"}
        found = {"depth_mm": np.full(count, self.first.depth_mm[0]), **found}
        for (key, span), share in zip(self.ranges.items(), shares.T, strict=True):
            if span.step is None:
                found[key] = span.min + share * (span.max - span.min)
            else:
                steps = np.floor((span.max - span.min) / span.step + _WHOLE)
                stepped = span.min + np.minimum(np.floor(share * (steps + 1.0)), steps) * span.step
                found[key] = np.round(stepped, _DECIMALS)
        if self.tube.length_mm is not None:
            found["count"] = np.floor(self.tube.length_mm / (found["cut_mm"] + found["uncut_mm"]) + _WHOLE)
        return found

    def grid(self) -> FloatArray:
        """Return the shares of every combination of steps, the first range slowest; shape (m, axes)."""
        lines = []
        for span in self.ranges.values():
            steps = int(np.floor((span.max - span.min) / (span.step or 1.0) + _WHOLE)) + 1
            lines.append((np.arange(steps) + 0.5) / steps)
        return (
            np.stack([line.ravel() for line in np.meshgrid(*lines, indexing="ij")], axis=1)
            if lines
            else np.zeros((1, 0))
        )

    def tubes(self, values: dict[str, FloatArray]) -> Tubes:
        """Return the tubes with the given values."""

        def metres(key: str) -> FloatArray:
            return values[key] * MILLIMETRE

        made = Tubes(
            outer_radius=metres("outer_diameter_mm") / 2.0,
            inner_radius=metres("inner_diameter_mm") / 2.0,
            depth=metres("depth_mm")[:, None],
            cut=metres("cut_mm")[:, None],
            uncut=metres("uncut_mm")[:, None],
            count=values["count"].astype(np.int64),
            youngs_modulus=np.full(len(values["count"]), self.youngs_modulus),
            density=np.full(len(values["count"]), self.density),
            natural_curvature=np.interp(values["depth_mm"], *self.measured),
            section=self.first.section,
            superelastic=self.superelastic,
        )
        return replace(made, end_length=self.end_length(made))

    def source(self, values: dict[str, FloatArray]) -> NDArray[np.str_]:
        """Return where each tube's natural curvature comes from."""
        depth, known = values["depth_mm"], self.measured[0]
        outside = (depth < known[0] - _SAME_DEPTH) | (depth > known[-1] + _SAME_DEPTH)
        exact = np.min(np.abs(depth[:, None] - known), axis=1) <= _SAME_DEPTH
        return np.where(outside, "held", np.where(exact, "measured", "interpolated"))

    def end_length(self, made: Tubes) -> FloatArray | float:
        """Return the extra cut length of tubes of this role, m."""
        if self.first.end_effect == "none":
            return 0.0
        if self.first.end_effect != "table":
            return float(np.mean(self.first.end_effect)) * MILLIMETRE
        return made.end_length_of_solids()[0]


@dataclass(frozen=True)
class Space:
    """Both roles; shares of a pair are those of the outer tube and then those of the middle tube."""

    config: Config
    outer: RoleSpace
    middle: RoleSpace

    @cached_property
    def explore(self) -> Explore:
        """The table, which the space was made from."""
        return self.config.explore or Explore()

    def role(self, name: Role) -> RoleSpace:
        """Return one role."""
        return self.outer if name == "outer" else self.middle


def space(config: Config) -> Space:
    """Return the design space of a configuration.

    Raises:
        BadInput: there is no [explore], or a depth lies outside the measured samples and that is not allowed.
    """
    if config.explore is None:
        raise config.refuse((), "there is no [explore] table", hint="Run `coast explain explore` for what it holds.")
    return Space(config, role_space(config, config.explore, "outer"), role_space(config, config.explore, "middle"))


def role_space(config: Config, explore: Explore, role: Role) -> RoleSpace:
    """Return the space of one role.

    Raises:
        BadInput: a depth lies outside the measured samples and that is not allowed.
    """
    samples, tube = bench_tubes(config, role), explore.outer if role == "outer" else explore.middle
    depths = np.array([np.mean(sample.depth_mm) for sample in samples])
    order = np.argsort(depths, kind="stable")
    curvature = np.array([sample.natural_curvature_per_m for sample in samples])
    low, high = float(depths.min()), float(depths.max())
    span = tube.ranges.get("depth_mm")
    if span is not None and explore.outside_samples == "refuse":
        for key, value in (("min", span.min), ("max", span.max)):
            if not low - _SAME_DEPTH <= value <= high + _SAME_DEPTH:
                raise config.refuse(
                    ("explore", role, "depth_mm", key),
                    "no sample was measured there, so its natural curvature is unknown",
                    found=value,
                    allowed=f"{low:g} to {high:g}, or explore.outside_samples = 'hold'",
                )
    material = config.materials[samples[0].material]
    return RoleSpace(
        role=role,
        first=samples[0],
        ranges=tube.ranges,
        tube=tube,
        measured=(depths[order], (1.0 if role == "outer" else -1.0) * curvature[order]),
        youngs_modulus=nominal(material.youngs_modulus_gpa) * GIGAPASCAL,
        superelastic=build_superelastic(material),
        density=material.density_kg_per_m3,
    )
