"""The words and figures that the terminal page and the report share: verdicts, places, units, uncertainties."""

from __future__ import annotations

from math import floor, isfinite, log10
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Comparison, Diagnosis, Level, Value
    from coast_cli.diagnosis.locate import Region

HEADLINES = {
    "agrees": "The model agrees with the recording.",
    "parameters": "The model agrees once its own parameters are refitted.",
    "physics": "The model leaves out physics.",
    "sensor": "The sensor, not the robot, disagrees with the model.",
    "ambiguous": "Something is left out; the recording cannot tell which.",
    "unexplained": "Something is left out that no effect of the catalogue explains.",
    "insufficient": "The recording cannot decide.",
}
_NOTHING = 1e-9
UNITS = {"curvature_per_m": "1/m", "bend_deg": "deg", "notch_deg": "deg", "shape_mm": "mm"}
AXES = {
    "direction": ("on", ""),
    "stroke": ("stroke", "mm"),
    "tension": ("tension", "N"),
    "curvature": ("curvature", "1/m"),
    "bending_length": ("bending length", "mm"),
    "time": ("time", "s"),
    "rate": ("rate", "a second"),
    "cycle": ("cycle", ""),
    "run": ("run", ""),
    "pair": ("pair", ""),
    "notch": ("notch", ""),
    "arc_length": ("arc length", "mm"),
}


def unit_of(diagnosis: Diagnosis) -> str:
    """Return the unit of the response as people write it."""
    return UNITS.get(diagnosis.noise_unit, diagnosis.noise_unit)


def place(region: Region) -> str:
    """Return a region in words, e.g. ``stroke 1.2 to 3 mm``."""
    name, unit = AXES.get(region.axis, (region.axis, ""))
    if region.value is not None:
        return f"{name} {region.value}"
    return f"{name} {_edge(region.low)} to {_edge(region.high)} {unit}".rstrip()


def _edge(value: float | None) -> str:
    return "..." if value is None else f"{value if abs(value) > _NOTHING else 0.0:.3g}"


def measured(value: Value) -> str:
    """Return a number with its standard deviation, both to the digits that count, and whether it is on a bound."""
    if value.at_bound:
        return f"{value.value:.4g}, on its bound"
    if not (isfinite(value.std) and value.std > 0.0):
        return f"{value.value:.4g}, not determined"
    if value.std > 10.0 * abs(value.value) and value.std > 1e-9:
        return f"{value.value:.2g} +- {value.std:.2g}"
    digits = min(max(1 - floor(log10(value.std)), 0), 9)
    return f"{value.value:.{digits}f} +- {value.std:.{digits}f}"


def figure(value: float | None) -> str:
    """Return an error with three digits, or a dash."""
    return "-" if value is None or not isfinite(value) else f"{value:.3g}"


def against_noise(diagnosis: Diagnosis, level: float | None) -> str:
    """Return an error in noise levels."""
    if level is None or not diagnosis.noise > 0.0:
        return "-"
    return f"{level / diagnosis.noise:.2g} x"


def judged(level: Level) -> float:
    """Return the error that counts: on rows held out, or on those fitted where nothing was held out."""
    return level.train if level.held_out is None else level.held_out


def gained(fit: Comparison) -> str:
    """Return what the effects gain over the refitted base, as a sentence that can also say no."""
    before, after = judged(fit.refitted), judged(fit.with_effects)
    where = "fitted rows only, no proof" if fit.with_effects.held_out is None else "held out"
    if after >= before or before <= 0.0:
        return f"No: {figure(after)} against {figure(before)} of the refitted base ({where})."
    return f"Yes: {100.0 * (1.0 - after / before):.0f} % less error than the refitted base ({where})."


def percent(share: float) -> str:
    """Return a probability or share; one near certainty is not rounded up to it."""
    return f"{100.0 * share:.0f} %" if share < 0.995 else "over 99 %"
