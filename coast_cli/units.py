"""Units at the edge of the program: inside, everything is SI; files and tables say their unit in the name's suffix."""

from __future__ import annotations

from math import pi

MILLIMETRE = 1e-3
MICROMETRE = 1e-6
DEGREE = pi / 180.0
GIGAPASCAL = 1e9
MEGAPASCAL = 1e6
MILLINEWTON = 1e-3

# Suffixes of column names with their factor to SI, one table a quantity.
LENGTH = {"_m": 1.0, "_mm": MILLIMETRE, "_um": MICROMETRE}
ANGLE = {"_rad": 1.0, "_deg": DEGREE}
FORCE = {"_n": 1.0, "_mn": 1e-3}
CURVATURE = {"_per_m": 1.0, "_per_mm": 1e3}
TIME = {"_s": 1.0, "_ms": 1e-3}
MOMENT = {"_n_m": 1.0, "_n_mm": 1e-3, "_mn_m": 1e-3, "_mn_mm": 1e-6}
KINDS = {
    "a length": LENGTH,
    "an angle": ANGLE,
    "a force": FORCE,
    "a curvature": CURVATURE,
    "a time": TIME,
    "a moment": MOMENT,
}


def unit_of(name: str) -> tuple[str, str, float] | None:
    """Return (what it is, suffix, factor to SI) of a name that says its unit, by the longest suffix; else None."""
    lower = name.lower()
    found = [
        (kind, suffix, factor)
        for kind, suffixes in KINDS.items()
        for suffix, factor in suffixes.items()
        if lower.endswith(suffix)
    ]
    return max(found, key=lambda one: len(one[1]), default=None)
