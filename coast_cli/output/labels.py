"""How figures of designs are headed and written where people read them, in units that spare powers of ten."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, isfinite, log10
from typing import NamedTuple


class Label(NamedTuple):
    """Words and unit of a column; its values times ``scale`` are in that unit."""

    words: str
    unit: str = ""
    scale: float = 1.0

    @property
    def heading(self) -> str:
        """Words with the unit, e.g. of an axis."""
        return f"{self.words} ({self.unit})" if self.unit else self.words


LABELS = {
    "total_precurvature_rad": Label("total pre-curvature", "rad"),
    "signed_precurvature_rad": Label("signed pre-curvature", "rad"),
    "rigidity_ratio_mean": Label("rigidity ratio, mean"),
    "rigidity_ratio_series": Label("rigidity ratio, series"),
    "total_rigidity_mean_n_m2": Label("total EI, mean", "N mm²", 1e6),
    "total_rigidity_series_n_m2": Label("total EI, series", "N mm²", 1e6),
    "score": Label("score"),
    "bending_length_mm": Label("bending length X2", "mm"),
    "curvature_per_m": Label("curvature", "1/m"),
    "stroke_mm": Label("stroke X1", "mm"),
    "tension_n": Label("tension", "N"),
    "tendon_strain": Label("tendon strain", "%", 1e2),
    "tip_x_mm": Label("tip x", "mm"),
    "tip_y_mm": Label("tip y", "mm"),
    "x_mm": Label("x", "mm"),
    "y_mm": Label("y", "mm"),
    "angle_deg": Label("angle", "deg"),
    "web_strain": Label("web strain", "%", 1e2),
    "closure_curvature_per_m": Label("curvature at notch closure", "1/m"),
    "closure_margin": Label("closure margin"),
    "strain_amplitude": Label("strain amplitude", "%", 1e2),
    "bend_deg": Label("bend reached", "deg"),
    "snap_margin": Label("snap margin"),
}


def label_text(values: Sequence[float | None], digits: int = 4) -> list[str]:
    """Return a column of numbers with as many decimals each as give the largest so many digits; None is a dash."""
    largest = max((abs(value) for value in values if value is not None and isfinite(value)), default=0.0)
    decimals = min(max(digits - 1 - floor(log10(largest)), 0), 9) if largest > 0.0 else 0
    return [
        "-" if value is None or not isfinite(value) else f"{round(value, decimals) + 0.0:.{decimals}f}"
        for value in values
    ]


def column(name: str, values: Sequence[float | None], digits: int = 4) -> list[str]:
    """Return a named column in the unit of its label, written."""
    scale = LABELS[name].scale
    return label_text([None if value is None else float(value) * scale for value in values], digits)
