"""What a criterion is measured in: an absolute reference for each, so that a score is of its pair alone.

A criterion divided by its reference is 1 where the pair is as far as the reference allows. References come from
``[rank]``, else from the limits of ``[checks]``, else from here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, log

import numpy as np

from coast_cli.design.reach import PLATEAU_STRAIN
from coast_cli.mechanics.section import FloatArray
from coast_cli.spec.config import Config

PRECURVATURE_RAD = 0.3
RATIO = 1.25
UNCUT_RIGIDITY_N_M2 = 1e-4  # both uncut tubes, 0.5 x 0.4 and 0.36 x 0.28 mm at 45 GPa: 1.05e-4
TENDON_STRAIN = 0.012  # as configs/tubes.toml has it
CHANGE = 0.1  # of one reference, to see whether an order rests on it


@dataclass(frozen=True, slots=True)
class Reference:
    """One criterion's reference: what it is of, its value as the criterion is counted, in words, and its origin."""

    name: str
    value: float
    words: str
    source: str


def rank_references(config: Config) -> tuple[Reference, Reference, Reference]:
    """Return the references of total pre-curvature (rad), |ln(rigidity ratio)| and total rigidity (N m^2).

    The ratio's default is the bound of checks.rigidity_ratio that is nearer to 1: |ln| counts both ways alike, and a
    pair within it passes whichever tube is the stiffer.
    """
    given, checks = config.rank, config.checks
    limit = None if checks is None else checks.max_total_precurvature_rad
    turn, turn_source = _first(
        (None if given is None else given.total_precurvature_rad, "rank.total_precurvature_rad"),
        (limit, "checks.max_total_precurvature_rad"),
        (PRECURVATURE_RAD, "default"),
    )
    ratio, ratio_source = _first(
        (None if given is None else given.rigidity_ratio, "rank.rigidity_ratio"), *_bounds(config), (RATIO, "default")
    )
    total, total_source = _first(
        (None if given is None else given.total_rigidity_n_m2, "rank.total_rigidity_n_m2"),
        (UNCUT_RIGIDITY_N_M2, "default: about the two uncut tubes"),
    )
    return (
        Reference("total pre-curvature", turn, f"{turn:.4g} rad", turn_source),
        Reference("rigidity ratio", abs(log(ratio)), f"{max(ratio, 1.0 / ratio):.4g} either way", ratio_source),
        Reference("total rigidity", total, f"{total:.4g} N m^2", total_source),
    )


def objective_scores(config: Config, costs: FloatArray) -> FloatArray:
    """Return the score of each pair from its objectives in the order of ``[explore]``, shape (pairs, objectives)."""
    if config.explore is None:
        return np.zeros(len(costs))
    scaled = [_scale(config, name)(column) for name, column in zip(config.explore.objectives, costs.T, strict=True)]
    return np.asarray(np.sqrt(np.sum(np.square(scaled), axis=0)))


def _scale(config: Config, objective: str) -> Callable[[FloatArray], FloatArray]:
    ranked = dict(zip(("total_precurvature", "rigidity_ratio", "total_rigidity"), rank_references(config), strict=True))
    if objective in ranked:
        return lambda cost: cost / ranked[objective].value
    checks = config.checks
    point = None if checks is None else checks.max_stroke_mm
    if point is None or checks is None:  # these objectives are taken at that point, which loading has asked for
        raise config.refuse(("explore", "objectives"), f"{objective} needs checks.max_stroke_mm")
    if objective == "notch_closure":  # the cost is the closing curvature, negative; the score has how near the point is
        return lambda cost: point.curvature_per_m / -cost
    references = {
        "stroke": point.value or 1.0,
        "tendon_strain": checks.max_tendon_strain or TENDON_STRAIN,
        "web_strain": checks.max_web_strain or PLATEAU_STRAIN,
    }
    return lambda cost: cost / references[objective]


def _bounds(config: Config) -> tuple[tuple[float, str], ...]:
    """Return the bounds of the rigidity ratio that can measure it, the nearest to 1 first."""
    limits = None if config.checks is None else config.checks.rigidity_ratio
    if limits is None:
        return ()
    found = [
        (value, f"checks.rigidity_ratio.{name}") for name, value in (("min", limits.min), ("max", limits.max)) if value
    ]
    usable = [(value, name) for value, name in found if value != 1.0 and isfinite(log(value))]
    return tuple(sorted(usable, key=lambda bound: abs(log(bound[0]))))


def _first(*choices: tuple[float | None, str]) -> tuple[float, str]:
    """Return the first choice that has a value above zero."""
    return next((value, source) for value, source in choices if value)
