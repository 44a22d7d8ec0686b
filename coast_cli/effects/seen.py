"""Whether a law without a name is used inside the range that it was seen in; outside it stays as at the range's end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from coast_cli.effects.effect import Effect
from coast_cli.effects.unnamed import UnnamedLaw, Variable
from coast_cli.mechanics.section import FloatArray

# Symbol, display unit of each variable, and SI units in one of it.
UNITS: Mapping[Variable, tuple[str, str, float]] = {
    "stroke": ("X1", "mm", 1e-3),
    "tension": ("F", "N", 1.0),
    "curvature": ("kappa", "1/m", 1.0),
    "bending_length": ("X2", "mm", 1e-3),
    "position": ("s", "mm", 1e-3),
    "time": ("t", "s", 1.0),
    "rate": ("v", "mm/s", 1e-3),
    "path": ("y", "mm", 1e-3),
    "run": ("run", "", 1.0),
}
_BOUNDED = ("none", "friction", "maximum", "path", "relaxation")


def outside_note(law: UnnamedLaw, remembered: FloatArray) -> str:
    """Return a note where values of a law's remembered variable (n,), SI, lie outside the range seen, or an empty text."""
    known = remembered[np.isfinite(remembered)]
    part = law.outside(known)
    if law.memory not in _BOUNDED or part == 0.0:
        return ""
    symbol, unit, scale = UNITS[law.variable]
    what = {"maximum": f"the largest {symbol}", "path": f"the path of {symbol}", "relaxation": f"the lag of {symbol}"}
    low, high = float(known.min()) / scale, float(known.max()) / scale
    share = f"{100.0 * part:.0f} %" if part >= 0.01 else "less than 1 %"
    return (
        f"{law.id} was seen for {what.get(law.memory, symbol)} from {law.low / scale:.3g} to {law.high / scale:.3g} {unit}; "
        f"{share} of the rows lie outside ({low:.3g} to {high:.3g} {unit}), where it stays as at the end of that range."
    )


def outside_at(
    effects: Sequence[Effect],
    *,
    curvature: FloatArray,
    stroke: FloatArray | None,
    tension: FloatArray,
    bending_length: FloatArray,
) -> Iterator[str]:
    """Yield notes on laws that states of a slow pull, row by row (n,), SI, take outside the range that they were seen in."""
    values = {
        "curvature": curvature,
        "stroke": stroke,
        "path": stroke,
        "tension": tension,
        "bending_length": bending_length,
    }
    for law in effects:
        series = values.get(law.variable) if isinstance(law, UnnamedLaw) else None
        if isinstance(law, UnnamedLaw) and series is not None and law.memory != "relaxation":
            note = outside_note(law, series)
            if note:
                yield note
