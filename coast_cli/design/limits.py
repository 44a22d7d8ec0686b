"""The limits of ``[checks]`` over many pairs at once, and whether tubes go into each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.figures import POINT_FIGURES, point_figures
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tubes import Tubes
from coast_cli.spec.build import Design, build_joint
from coast_cli.spec.config import Config
from coast_cli.spec.tubes import assembly_fault, bench_tubes
from coast_cli.units import MILLIMETRE


@dataclass(frozen=True, slots=True)
class Limit:
    """One bound of a figure: the check it comes from, "min" or "max", the column it bounds and the bound."""

    check: str
    bound: str
    figure: str
    limit: float

    def holds(self, columns: Mapping[str, FloatArray]) -> NDArray[np.bool_]:
        """Return where the limit holds; a figure without a value does not pass."""
        values = columns[self.figure]
        return np.asarray(values <= self.limit if self.bound == "max" else values >= self.limit)


def limits(config: Config) -> tuple[Limit, ...]:
    """Return the limits of a configuration in the order of the document; none without [checks]."""
    checks, found = config.checks, list[Limit]()
    if checks is None:
        return ()
    if checks.max_total_precurvature_rad is not None:
        limit = checks.max_total_precurvature_rad
        found.append(Limit("max_total_precurvature_rad", "max", "total_precurvature_rad", limit))
    if checks.rigidity_ratio is not None:
        figure = f"rigidity_ratio_{checks.rigidity_ratio.rigidity}"
        for bound, value in (("min", checks.rigidity_ratio.min), ("max", checks.rigidity_ratio.max)):
            if value is not None:
                found.append(Limit("rigidity_ratio", bound, figure, value))
    if checks.max_stroke_mm is not None and config.joint is not None and config.tendon is not None:
        found.append(Limit("max_stroke_mm", "max", "stroke_mm", checks.max_stroke_mm.value))
        if checks.max_tendon_strain is not None:
            found.append(Limit("max_tendon_strain", "max", "tendon_strain", checks.max_tendon_strain))
    return tuple(found)


def at_the_point(design: Design, outer: Tubes, middle: Tubes) -> dict[str, FloatArray]:
    """Return the figures at the point of ``checks.max_stroke_mm`` for pairs row by row; none where that is not given."""
    config = design.config
    if config.checks is None or config.checks.max_stroke_mm is None or not point_figure_names(config):
        return {}
    point = config.checks.max_stroke_mm
    return point_figures(
        _some_joint(config), outer, middle, point.curvature_per_m, point.bending_length_mm * MILLIMETRE
    )


def point_figure_names(config: Config) -> tuple[str, ...]:
    """Return the figures that ``at_the_point`` gives."""
    if config.joint is None or config.checks is None or config.checks.max_stroke_mm is None:
        return ()
    return tuple(
        name for name in POINT_FIGURES if config.tendon is not None or name not in {"stroke_mm", "tendon_strain"}
    )


def assembles(config: Config, outer: Tubes, middle: Tubes) -> NDArray[np.bool_]:
    """Return which rows are tubes, and go into each other with the inner tube and the tendon inside."""
    inner = 0.0 if config.inner is None else config.inner.outer_diameter_mm / 2.0 * MILLIMETRE
    tendon = 0.0 if config.tendon is None else 2.0 * config.tendon.radius_mm * MILLIMETRE
    nested = (middle.outer_radius < outer.inner_radius) & (middle.inner_radius > inner)
    return np.asarray(outer.possible & middle.possible & nested & (2.0 * middle.inner_radius > tendon))


def _some_joint(config: Config) -> Joint:
    """Return the joint with any tubes that go together: its own numbers are what counts."""
    outer, middle = bench_tubes(config, "outer"), bench_tubes(config, "middle")
    pairs = ((one.name, two.name) for two in middle for one in outer if assembly_fault(config, one, two) is None)
    return build_joint(config, *next(pairs))
