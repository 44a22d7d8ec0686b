"""Arguments in SI units that are far outside physics are refused: millimetres for metres, gigapascals for pascals.

The ranges are those of a configuration, so that nothing read from a file is refused here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from coast_cli.errors import BadInput

_FAR = 10.0  # times the notched length: no bending length or stroke comes near


class PlausibleRange(NamedTuple):
    """What a number may be, its unit, and the unit in which it was probably given."""

    low: float
    high: float
    unit: str
    probably: str


RADIUS = PlausibleRange(0.0, 0.05, "m", "millimetres")
LENGTH = PlausibleRange(0.0, 1.0, "m", "millimetres")
WIRE = PlausibleRange(0.0, 100.0, "m", "millimetres")
MODULUS = PlausibleRange(1e6, 1e13, "Pa", "gigapascals")
DENSITY = PlausibleRange(100.0, 30_000.0, "kg/m^3", "g/cm^3")
CURVATURE = PlausibleRange(-1e3, 1e3, "1/m", "1/mm, or a radius")
SEGMENT = PlausibleRange(0.0, 2.0, "m", "millimetres")  # a bend that nothing says the tubes of


def require(within: PlausibleRange, **given: Any) -> None:  # noqa: ANN401
    """Refuse numbers or arrays, by name, that lie outside a range; what is not a number (NaN) is left to others.

    Raises:
        BadInput: naming the argument, its value and the unit that it was probably given in.
    """
    for name, values in given.items():
        numbers = np.real(np.asarray(values) * 1.0)
        worst = float(np.max(numbers, initial=within.low))
        if worst <= within.high:
            worst = float(np.min(numbers, initial=within.high))
        if worst < within.low or worst > within.high:
            allowed = f"at most {within.high:g}" if np.isinf(within.low) else f"{within.low:g} to {within.high:g}"
            message = f"{name} {worst:g} {within.unit}; {within.probably}?"
            raise BadInput(message, allowed=f"{allowed} {within.unit}")


def require_of_tubes(joint: Any, **lengths: Any) -> None:  # noqa: ANN401  # one joint; many at once are made from files
    """Refuse lengths (m), by name, that are far longer than the notched part of a joint's tubes.

    Raises:
        BadInput: naming the argument and the unit that it was probably given in.
    """
    middle = getattr(joint, "middle", None)
    if middle is not None:
        for name, values in lengths.items():
            require(PlausibleRange(-np.inf, _FAR * float(np.real(middle.length)), "m", "millimetres"), **{name: values})
