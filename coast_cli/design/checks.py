"""Checks: a pair held to the limits of its configuration, a row a limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from coast_cli.design.limits import Limit, beside, limits
from coast_cli.design.loading import acting_on_load, corrected_stroke
from coast_cli.design.reach import Pulled, Webs, largest_curvature, pulled_at, require_covered, tendon_limits
from coast_cli.design.snapping import snaps
from coast_cli.design.stroke import stroke_table
from coast_cli.errors import BadInput, NotConverged
from coast_cli.mechanics.beam import NO_EQUILIBRIUM
from coast_cli.mechanics.pairs import pair_table
from coast_cli.mechanics.section import FloatArray
from coast_cli.spec.build import Design
from coast_cli.spec.config import Checks, Config, LimitAtPoint, Reach
from coast_cli.units import DEGREE, MILLIMETRE

Row = dict[str, str | float | int | bool | None]
_JUST_PAST = 1.0 + 1e-9


def check_design(design: Design, pair: str | None = None) -> list[Row]:
    """Return one row for each limit of a configuration, with its value and whether it holds; units are in the names.

    Args:
        design: from ``build``, with a ``[checks]`` table.
        pair: OUTER/MIDDLE, or one tube; None is joint.pair.

    Raises:
        BadInput: no limits, no pair, or a limit that needs a table the configuration does not have.
        NotConverged: a beam under gravity was not solved.

    Example:
        >>> rows = coast.check_design(coast.build(coast.load_config(coast.REFERENCE)))
        >>> [row["passed"] for row in rows if row["check"] == "max_stroke_mm"]
        [True]
    """
    config, checks = design.config, design.config.checks
    if checks is None:
        raise config.refuse((), "there is nothing to check: no [checks] table")
    asked, stopped = design.pair(pair), None
    figures: dict[str, FloatArray] = {}
    if checks.max_total_precurvature_rad is not None or checks.rigidity_ratio is not None:
        figures |= _pair_figures(design, asked)
    if checks.max_stroke_mm is not None:
        figures |= _at_the_point(design, pair, checks.max_stroke_mm)
    if checks.min_bend_deg is not None:
        bend, stopped = _reach(design, pair, checks, checks.min_bend_deg)
        figures["bend_deg"] = bend
    held = limits(config)
    if checks.min_snap_margin is not None:
        figures["snap_margin"] = _snap_margin(design, asked)
        held = (*held, Limit("min_snap_margin", "min", "snap_margin", checks.min_snap_margin))
    return [
        {
            "config": config.source,
            "pair": "/".join(name for name in asked if name),
            "check": limit.check,
            "bound": limit.bound,
            "value": figures[limit.figure].item(),
            "limit": limit.limit,
            "passed": bool(limit.holds(figures)),
            "line": config.line("checks", limit.check),
            "stopped_by": stopped if limit.figure == "bend_deg" else None,
            "error": None,
        }
        for limit in held
    ]


def limits_told(config: Config) -> tuple[str, ...]:
    """Return the note on where a limit comes from that no drawing gives: that of fatigue."""
    fatigue = None if config.checks is None else config.checks.fatigue
    return (
        () if fatigue is None else (f"checks.fatigue: the limit of {fatigue.origin}, for {fatigue.cycles:g} cycles.",)
    )


def jump_told(design: Design, pair: str | None = None) -> tuple[str, ...]:
    """Return the note on a forecast of a jump that passes checks.min_snap_margin; none without that limit."""
    checks, asked = design.config.checks, design.pair(pair)
    if checks is None or checks.min_snap_margin is None:
        return ()
    margin = float(_snap_margin(design, asked).min())
    if margin >= checks.min_snap_margin:
        return ()
    words = f"forecast margin {margin:.3g} below {checks.min_snap_margin:g} (checks.min_snap_margin)"
    return (f"past a limit: {words}; `coast snap` says where the pair would jump.",)


def refused(config: str, error: BadInput | NotConverged) -> Row:
    """Return the row of a configuration that could not be checked."""
    names = ("config", "pair", "check", "bound", "value", "limit", "passed", "line", "stopped_by", "error")
    line = error.line if isinstance(error, BadInput) else None
    return {**dict.fromkeys(names), "config": config, "passed": False, "line": line, "error": str(error)}


def _pair_figures(design: Design, pair: tuple[str | None, str]) -> dict[str, FloatArray]:
    outer, middle = pair
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


def _snap_margin(design: Design, pair: tuple[str | None, str]) -> FloatArray:
    outer, middle = pair
    ones = () if outer is None else (design.tube(outer),)
    found = snaps(replace(design, outer=ones, middle=(design.tube(middle),)))
    if found is None:
        message = "a forecast of jumps needs a pair, a joint and its tendon"
        raise design.config.refuse(("checks", "min_snap_margin"), message)
    if np.isnan(found.rest).any():
        raise NotConverged(f"{outer}/{middle}: {NO_EQUILIBRIUM}.")
    return found.margin


def _at_the_point(design: Design, pair: str | None, limit: LimitAtPoint) -> dict[str, FloatArray]:
    """Return what the joint has at the point of a limit: stroke (mm), tendon strain, tension (N), strain of the webs."""
    if design.config.tendon is None:
        raise design.config.refuse(("checks", "max_stroke_mm"), "a stroke needs a [tendon] table")
    joint, lengths = design.joint(pair), [limit.bending_length_mm * MILLIMETRE]
    require_covered(joint, lengths[0])
    table = stroke_table(joint, lengths, curvatures=[limit.curvature_per_m], effects=design.effects)
    if table.columns["stroke_mm"][0] is None:
        raise NotConverged(f"checks.max_stroke_mm: {table.notes[0]}")
    found = {name: np.asarray(table.columns[name], dtype=float) for name in ("stroke_mm", "tendon_strain", "tension_n")}
    webs = Webs.of(joint)
    found["web_strain"] = webs.strain(np.array([limit.curvature_per_m]))
    found["closure_curvature_per_m"] = np.asarray([webs.closure_curvature])
    return found | beside(found, limit.curvature_per_m)


def _reach(design: Design, pair: str | None, checks: Checks, wanted: Reach) -> tuple[FloatArray, str]:
    """Return the bend (degrees) that the joint reaches within its limits, and what stops it there."""
    joint, length = design.joint(pair), wanted.bending_length_mm * MILLIMETRE
    require_covered(joint, length)
    acting, _ = acting_on_load(design.effects)

    def pull(curvature: FloatArray) -> Pulled:
        if acting:
            found = corrected_stroke(joint, acting, np.full_like(curvature, length), curvature, inverse=False)
            return Pulled(found.stroke, found.tendon_strain, found.tension)
        return pulled_at(joint, curvature, length)

    webs = Webs.of(joint)
    reached = largest_curvature(pull, webs, checks)
    passed = [words for mask, words in tendon_limits(pull(reached * _JUST_PAST), checks) if mask.any()]
    closes = reached[0] * _JUST_PAST >= webs.closure_curvature
    at_the_webs = "notch faces touch" if closes else "web strain (checks.max_web_strain)"
    return reached * length / DEGREE, passed[0] if passed else at_the_webs
