"""The figures of many pairs as named columns: what equation (8) of P gives, and what the joint does at one point."""

from __future__ import annotations

import numpy as np

from coast_cli.design.reach import require_covered
from coast_cli.mechanics.joint import Joint, joints_of, stroke
from coast_cli.mechanics.pairs import PairTable
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tubes import Tubes

FIGURES = {
    "total_precurvature_rad": "rad",
    "signed_precurvature_rad": "rad",
    "rigidity_ratio_mean": "",
    "rigidity_ratio_series": "",
    "total_rigidity_mean_n_m2": "N m^2",
    "total_rigidity_series_n_m2": "N m^2",
}
POINT_FIGURES = {"stroke_mm": "mm", "tendon_strain": "", "web_strain": "", "closure_curvature_per_m": "1/m"}


def pair_columns(table: PairTable) -> dict[str, FloatArray]:
    """Return the columns of ``FIGURES``, shape (pairs,); NaN where a tube of the pair was not solved."""
    columns = (
        table.total_precurvature,
        table.signed_precurvature,
        table.ratio_mean,
        table.ratio_series,
        table.total_mean,
        table.total_series,
    )
    return {
        name: np.where(table.converged, column, np.nan).ravel() for name, column in zip(FIGURES, columns, strict=True)
    }


def point_figures(
    joint: Joint, outer: Tubes, middle: Tubes, curvature: float, bending_length: float
) -> dict[str, FloatArray]:
    """Return the columns of ``POINT_FIGURES`` of pairs row by row, bent to a curvature (1/m) over a length (m).

    Stroke and tendon strain are those of the joint model with each pair's tubes; the web strain is the largest strain
    that bending puts into what a notch leaves of either tube, whose cuts take all of the bend; more past a plateau.

    Args:
        joint: gives tendon, friction and modulus; its own tubes are not used.
    """
    require_covered(joint, bending_length)
    columns, pairs = {}, joints_of(joint, outer, middle)
    if joint.tendon is not None:
        solution = stroke(pairs, curvature, bending_length)
        columns = {"stroke_mm": solution.stroke * 1e3, "tendon_strain": solution.tendon_strain}
    strain = [curvature * tubes.strain_per_curvature.max(axis=1) for tubes in (outer, middle)]
    closing = [tubes.closing_curvature.min(axis=1) for tubes in (outer, middle)]
    rise = pairs.softening.strain_rise(np.full(outer.size, curvature))
    columns["web_strain"], columns["closure_curvature_per_m"] = np.maximum(*strain) * rise, np.minimum(*closing)
    return columns
