"""How figures of designs are headed where people read them: words, and a unit that leaves numbers without powers of ten."""

from __future__ import annotations

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
    "stroke_mm": Label("stroke", "mm"),
    "tendon_strain": Label("tendon strain", "%", 1e2),
    "web_strain": Label("web strain", "%", 1e2),
    "closure_curvature_per_m": Label("curvature at notch closure", "1/m"),
}
