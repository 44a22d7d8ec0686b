"""A law's curve as an equation, where a short one holds it to a tenth: constant, line, square, saturating, knee, hump, sine."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from coast_cli.effects.unnamed import UnnamedLaw, Variable
from coast_cli.mechanics.section import FloatArray

# A typed form is printed where it misses the smooth one by less than this part of it.
HOLDS_TO = 0.1
_POINTS = 121
# Display unit of each variable, and SI units in one of it.
UNITS: dict[Variable, tuple[str, str, float]] = {
    "stroke": ("X1", "mm", 1e-3),
    "tension": ("F", "N", 1.0),
    "curvature": ("kappa", "1/m", 1.0),
    "bending_length": ("X2", "mm", 1e-3),
    "position": ("s", "mm", 1e-3),
    "time": ("t", "s", 1.0),
    "rate": ("X1'", "mm/s", 1e-3),
    "path": ("path of X1", "mm", 1e-3),
    "run": ("run", "1", 1.0),
}


@dataclass(frozen=True, slots=True)
class Form:
    """A typed form: its words ("a line"), its equation in display units, and the fraction of the curve that it misses."""

    name: str
    equation: str
    missed: float


def curve_of(law: UnnamedLaw) -> tuple[FloatArray, FloatArray]:
    """Return the remembered variable over the range that was seen, SI, and what the law adds there, each (n,)."""
    low, high = (0.0, law.setting) if law.memory == "period" else (law.low, law.high)
    along = np.linspace(low, high, _POINTS)
    return along, law.of(along)


def symbol(law: UnnamedLaw) -> str:
    """Return the remembered variable as a reader would write it."""
    name = UNITS[law.variable][0]
    if law.memory == "relaxation":
        return f"(lagged {name} - {name})"
    if law.memory == "maximum":
        return f"max {name} so far"
    if law.memory == "path":
        return f"path of {name}"
    return name


def typed(law: UnnamedLaw, unit: float = 1.0) -> Form | None:
    """Return the shortest form that misses the curve by less than a tenth, or None.

    Args:
        unit: of the amplitude that is printed, in the law's own.
    """
    along, values = curve_of(law)
    x, y = along / UNITS[law.variable][2], values / unit
    if law.memory == "step":
        return Form("a step", f"{_number(law.weights[0] / unit)} from t = {law.setting:.4g} s on", 0.0)
    if law.memory == "period":
        period = law.setting / UNITS[law.variable][2]
        size = float(np.linalg.norm(law.weights[:2])) / unit
        return Form("a wave", f"{_number(size)} sin(2 pi {symbol(law)} / {period:.4g} + phase)", 0.0)
    reach = float(np.sqrt(np.mean(y**2)))
    if reach == 0.0:
        return None
    for name, values_of, text in _forms(x, symbol(law)):
        missed, coefficients, shape = _closest(values_of, x, y)
        if missed < HOLDS_TO * reach:
            return Form(name, text(coefficients, shape), missed / reach)
    return None


Columns = Callable[[FloatArray, tuple[float, ...]], FloatArray]
Text = Callable[[FloatArray, tuple[float, ...]], str]


def _forms(x: FloatArray, name: str) -> Iterator[tuple[str, tuple[Columns, list[tuple[float, ...]]], Text]]:
    """Yield each form, simplest first: its columns for given shape values, the shapes to try, and its equation."""
    span = float(np.ptp(x)) or 1.0
    one = np.ones_like(x)
    places: list[tuple[float, ...]] = [(float(b),) for b in np.linspace(x[0], x[-1], 42)[1:-1]]
    widths: list[tuple[float, ...]] = [(float(w),) for w in span * np.array([0.05, 0.1, 0.2, 0.35, 0.6, 1.0])]
    humps: list[tuple[float, ...]] = [(b[0], w[0]) for b in places[::2] for w in widths]
    yield "constant", (lambda x, _: np.ones((x.size, 1)), [()]), lambda c, _: _number(c[0])
    yield "a line", (lambda x, _: np.stack([one, x], 1), [()]), lambda c, _: _sum(c, ("", name))
    yield (
        "a square",
        (lambda x, _: np.stack([one, x**2], 1), [()]),
        lambda c, _: _sum(c, ("", f"{name}^2")),
    )
    yield (
        "a knee",
        (lambda x, b: np.stack([one, np.maximum(x - b[0], 0.0)], 1), places),
        lambda c, b: _sum(c, ("", f"max({name} - {b[0]:.4g}, 0)")),
    )
    yield (
        "a saturating curve",
        (lambda x, w: np.stack([one, np.tanh((x - x[0]) / w[0])], 1), widths),
        lambda c, w: _sum(c, ("", f"tanh(({name} - {x[0]:.4g})/{w[0]:.4g})")),
    )
    yield (
        "a hump",
        (lambda x, s: np.stack([one, np.exp(-0.5 * ((x - s[0]) / s[1]) ** 2)], 1), humps),
        lambda c, s: _sum(c, ("", f"exp(-(({name} - {s[0]:.4g})/{s[1]:.4g})^2/2)")),
    )
    yield (
        "a line with a knee",
        (lambda x, b: np.stack([one, x, np.maximum(x - b[0], 0.0)], 1), places),
        lambda c, b: _sum(c, ("", name, f"max({name} - {b[0]:.4g}, 0)")),
    )


def _closest(
    form: tuple[Columns, list[tuple[float, ...]]], x: FloatArray, y: FloatArray
) -> tuple[float, FloatArray, tuple[float, ...]]:
    """Return the RMS miss, coefficients and shape of the closest curve of a form."""
    columns_of, shapes = form
    found = []
    for shape in shapes:
        columns = columns_of(x, shape)
        coefficients = np.asarray(np.linalg.lstsq(columns, y, rcond=1e-10)[0], dtype=np.float64)
        found.append((float(np.sqrt(np.mean((y - columns @ coefficients) ** 2))), coefficients, shape))
    return min(found, key=lambda one: one[0])


def _sum(coefficients: FloatArray, terms: tuple[str, ...]) -> str:
    largest = float(np.max(np.abs(coefficients)))
    parts = [
        f"{_number(value)}{' ' if term else ''}{term}"
        for value, term in zip(coefficients.tolist(), terms, strict=True)
        if abs(value) > 1e-3 * largest or len(terms) == 1
    ]
    return " + ".join(parts).replace("+ -", "- ") or "0"


def _number(value: float) -> str:
    return f"{value:.3g}"
