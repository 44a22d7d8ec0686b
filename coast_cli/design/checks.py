"""Checks: the joint's pair held to the limits of its configuration, a row a limit."""

from __future__ import annotations

import numpy as np

from coast_cli.design.limits import limits
from coast_cli.design.stroke import stroke_table
from coast_cli.errors import NotConverged
from coast_cli.mechanics.beam import NO_EQUILIBRIUM
from coast_cli.mechanics.pairs import pair_table
from coast_cli.mechanics.section import FloatArray
from coast_cli.spec.build import Design
from coast_cli.spec.config import LimitAtPoint
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
    figures: dict[str, FloatArray] = {}
    if config.checks.max_total_precurvature_rad is not None or config.checks.rigidity_ratio is not None:
        figures |= _pair_figures(design)
    if config.checks.max_stroke_mm is not None:
        figures |= _stroke_and_strain(design, config.checks.max_stroke_mm)
    return [
        {
            "config": config.source,
            "pair": "/".join(name for name in design.pair() if name),
            "check": limit.check,
            "bound": limit.bound,
            "value": figures[limit.figure].item(),
            "limit": limit.limit,
            "passed": bool(limit.holds(figures)),
            "line": config.line("checks", limit.check),
        }
        for limit in limits(config)
    ]


def _pair_figures(design: Design) -> dict[str, FloatArray]:
    outer, middle = design.pair()
    if outer is None:
        message = "a limit on a pair needs an outer tube, and the joint has one tube"
        raise design.config.refuse(("checks",), message, found=middle, allowed="'OUTER/MIDDLE' as joint.pair")
    table = pair_table([design.tube(outer)], [design.tube(middle)], design.gravity)
    if not table.converged.all():
        raise NotConverged(f"{outer}/{middle}: {NO_EQUILIBRIUM}.")
    return {
        "total_precurvature_rad": table.total_precurvature,
        "rigidity_ratio_mean": table.ratio_mean,
        "rigidity_ratio_series": table.ratio_series,
    }


def _stroke_and_strain(design: Design, limit: LimitAtPoint) -> dict[str, FloatArray]:
    """Return stroke (mm) and tendon strain at the point of a limit."""
    if design.config.tendon is None:
        raise design.config.refuse(("checks", "max_stroke_mm"), "a stroke needs a [tendon] table")
    lengths = [limit.bending_length_mm * MILLIMETRE]
    columns, notes = stroke_table(design.joint(), lengths, curvatures=[limit.curvature_per_m], effects=design.effects)
    if columns["stroke_mm"][0] is None:
        raise NotConverged(f"checks.max_stroke_mm: {notes[0]}")
    return {name: np.asarray(columns[name], dtype=float) for name in ("stroke_mm", "tendon_strain")}
