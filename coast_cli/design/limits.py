"""The limits of ``[checks]`` over many pairs at once, and whether tubes go into each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.figures import FIGURES, POINT_FIGURES, point_figures
from coast_cli.design.reach import Webs, largest_curvature, pulled_at
from coast_cli.mechanics.joint import Joint, joints_of, tension
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tubes import Tubes
from coast_cli.spec.build import Design, build_joint
from coast_cli.spec.config import Checks, Config
from coast_cli.spec.tubes import assembly_fault, bench_tubes
from coast_cli.units import DEGREE, MILLIMETRE


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
    if checks.max_stroke_mm is not None and config.joint is not None:
        found += _limits_at_the_point(config, checks)
    if checks.min_bend_deg is not None and config.joint is not None:
        found.append(Limit("min_bend_deg", "min", "bend_deg", checks.min_bend_deg.value))
    return tuple(found)


def _limits_at_the_point(config: Config, checks: Checks) -> list[Limit]:
    stroke, fatigue = checks.max_stroke_mm, checks.fatigue
    tendon = config.tendon is not None
    bounds = (
        ("max_stroke_mm", "max", "stroke_mm", stroke.value if stroke is not None and tendon else None),
        ("max_tendon_strain", "max", "tendon_strain", checks.max_tendon_strain if tendon else None),
        ("max_tension_n", "max", "tension_n", checks.max_tension_n),
        ("max_web_strain", "max", "web_strain", checks.max_web_strain),
        ("min_closure_margin", "min", "closure_margin", checks.min_closure_margin),
        ("fatigue", "max", "strain_amplitude", None if fatigue is None else fatigue.amplitude),
    )
    return [Limit(check, bound, figure, limit) for check, bound, figure, limit in bounds if limit is not None]


def at_the_point(design: Design, outer: Tubes, middle: Tubes) -> dict[str, FloatArray]:
    """Return the figures at the point of ``checks.max_stroke_mm`` for pairs row by row, and how far they bend.

    Those of ``point_figure_names``.
    """
    config, names = design.config, point_figure_names(design.config)
    if config.checks is None or not names:
        return {}
    joint = some_joint(config)
    columns: dict[str, FloatArray] = {}
    if config.checks.max_stroke_mm is not None:
        point = config.checks.max_stroke_mm
        length = point.bending_length_mm * MILLIMETRE
        columns = point_figures(joint, outer, middle, point.curvature_per_m, length)
        columns |= beside(columns, point.curvature_per_m)
        columns["tension_n"] = tension(joints_of(joint, outer, middle), point.curvature_per_m, length)
    if "bend_deg" in names:
        columns["bend_deg"] = _bend_deg(config, joint, outer, middle)
    return {name: columns[name] for name in names}


def beside(columns: Mapping[str, FloatArray], curvature: float) -> dict[str, FloatArray]:
    """Return the figures that follow from others: half the range of the web strain, how far closing is."""
    return {
        "strain_amplitude": columns["web_strain"] / 2.0,
        "closure_margin": columns["closure_curvature_per_m"] / curvature,
    }


def _bend_deg(config: Config, joint: Joint, outer: Tubes, middle: Tubes) -> FloatArray:
    """Return the bend (degrees) that each pair reaches at the length of checks.min_bend_deg within its limits."""
    checks = config.checks
    if checks is None or checks.min_bend_deg is None:
        raise config.refuse(("checks",), "there is no checks.min_bend_deg")
    joints, length = joints_of(joint, outer, middle), checks.min_bend_deg.bending_length_mm * MILLIMETRE
    at_one = point_figures(joint, outer, middle, 1.0, length)
    webs = Webs(at_one["web_strain"], at_one["closure_curvature_per_m"], joints.softening)
    reached = largest_curvature(lambda curvature: pulled_at(joints, curvature, length), webs, checks)
    return np.asarray(reached * length / DEGREE)


def point_figure_names(config: Config) -> tuple[str, ...]:
    """Return the figures that ``at_the_point`` gives: those of ``POINT_FIGURES``, and what else a limit is on."""
    if config.joint is None or config.checks is None:
        return ()
    limited = [limit.figure for limit in limits(config) if limit.figure not in (*FIGURES, *POINT_FIGURES)]
    if config.checks.max_stroke_mm is None:
        return tuple(limited)
    pulled = {"stroke_mm", "tendon_strain"} if config.tendon is None else set()
    return (*(name for name in POINT_FIGURES if name not in pulled), *limited)


def assembles(config: Config, outer: Tubes, middle: Tubes) -> NDArray[np.bool_]:
    """Return which rows are tubes, and go into each other with the inner tube and the tendon inside."""
    inner = 0.0 if config.inner is None else config.inner.outer_diameter_mm / 2.0 * MILLIMETRE
    tendon = 0.0 if config.tendon is None else 2.0 * config.tendon.radius_mm * MILLIMETRE
    nested = (middle.outer_radius < outer.inner_radius) & (middle.inner_radius > inner)
    return np.asarray(outer.possible & middle.possible & nested & (2.0 * middle.inner_radius > tendon))


def some_joint(config: Config) -> Joint:
    """Return the joint with any tubes that go together: its own numbers are what counts."""
    outer, middle = bench_tubes(config, "outer"), bench_tubes(config, "middle")
    pairs = ((one.name, two.name) for two in middle for one in outer if assembly_fault(config, one, two) is None)
    return build_joint(config, *next(pairs))
