"""Checks: the joint's pair held to the limits of its configuration, a row a limit."""

from __future__ import annotations

from collections.abc import Iterator

from coast_cli.design.stroke import stroke_table
from coast_cli.errors import NotConverged
from coast_cli.mechanics.beam import NO_EQUILIBRIUM
from coast_cli.mechanics.pair import PairTable, pair_table
from coast_cli.spec.build import Design
from coast_cli.spec.config import Checks, LimitAtPoint
from coast_cli.units import MILLIMETRE

Row = dict[str, str | float | int | bool | None]


def check_design(design: Design) -> list[Row]:
    """Return one row for each limit of a configuration, with its value and whether it holds.

    Raises:
        BadInput: no limits, no pair, or a limit that needs a table the configuration does not have.
        NotConverged: a beam under gravity was not solved.
    """
    config = design.config
    if config.checks is None:
        raise config.refuse((), "there is nothing to check: no [checks] table")
    return [
        {
            "config": config.source,
            "pair": "/".join(name for name in design.pair() if name),
            "check": check,
            "bound": bound,
            "value": value,
            "limit": limit,
            "passed": value <= limit if bound == "max" else value >= limit,
            "line": config.line("checks", check),
        }
        for check, bound, value, limit in _limits(design, config.checks)
    ]


def _limits(design: Design, checks: Checks) -> Iterator[tuple[str, str, float, float]]:
    """Yield (check, "min" or "max", value, limit)."""
    if checks.max_total_precurvature_rad is not None:
        value = _figures(design).total_precurvature.item()
        yield "max_total_precurvature_rad", "max", value, checks.max_total_precurvature_rad
    if checks.rigidity_ratio is not None:
        figures, limits = _figures(design), checks.rigidity_ratio
        ratio = figures.ratio_mean if limits.rigidity == "mean" else figures.ratio_series
        for bound, limit in (("min", limits.min), ("max", limits.max)):
            if limit is not None:
                yield "rigidity_ratio", bound, ratio.item(), limit
    if checks.max_stroke_mm is not None:
        stroke, strain = _stroke_and_strain(design, checks.max_stroke_mm)
        yield "max_stroke_mm", "max", stroke, checks.max_stroke_mm.value
        if checks.max_tendon_strain is not None:
            yield "max_tendon_strain", "max", strain, checks.max_tendon_strain


def _figures(design: Design) -> PairTable:
    """Return the table of the one pair."""
    outer, middle = design.pair()
    if outer is None:
        message = "a limit on a pair needs an outer tube, and the joint has one tube"
        raise design.config.refuse(("checks",), message, found=middle, allowed="'OUTER/MIDDLE' as joint.pair")
    figures = pair_table([design.tube(outer)], [design.tube(middle)], design.gravity)
    if not figures.converged.all():
        raise NotConverged(f"{outer}/{middle}: {NO_EQUILIBRIUM}.")
    return figures


def _stroke_and_strain(design: Design, limit: LimitAtPoint) -> tuple[float, float]:
    """Return stroke (mm) and tendon strain at the point of a limit."""
    if design.config.tendon is None:
        raise design.config.refuse(("checks", "max_stroke_mm"), "a stroke needs a [tendon] table")
    lengths = [limit.bending_length_mm * MILLIMETRE]
    columns, notes = stroke_table(
        design.joint(), lengths, curvatures=[limit.curvature_per_m], effects=design.effects
    )
    stroke, strain = columns["stroke_mm"][0], columns["tendon_strain"][0]
    if stroke is None:
        raise NotConverged(f"checks.max_stroke_mm: {notes[0]}")
    return float(stroke), float(strain)
