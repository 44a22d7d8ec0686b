"""A law's curve in display units, with its 90 % band, and as an equation where a short one holds it to a tenth.

Forms that are tried, simplest first: constant, line, square, knee, square beyond a knee, saturating,
hump, line with a knee.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from coast_cli.effects.seen import UNITS
from coast_cli.effects.unnamed import Place, UnnamedLaw, Variable
from coast_cli.effects.unnamed_shape import Law
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import DEGREE, MILLIMETRE

# A typed form is printed where it misses the smooth one by less than this part of it.
HOLDS_TO = 0.1
_POINTS = 121
_TABLE = 7
WIDTH_90 = 1.6448536269514722  # standard deviations on either side of 90 % of a normal distribution
_NOTHING = 1e-9  # of its largest value, below which the variable is zero
_STEP = 1e-4  # relative, of a setting
_LEAST_TERM = 5e-3  # of the largest term, below which a term is not printed
_DIGITS = (3, 4, 6)  # of a printed number; more where fewer would miss the curve
_UNITS_OF_TENSION: Mapping[Variable, tuple[str, str, float]] = {"rate": ("v", "N/s", 1.0), "path": ("y", "N", 1.0)}
_AMPLITUDES: Mapping[Place, str] = {
    "drive": "mm",
    "tendon": "mm",
    "transmission": "",
    "structure": "1/m",
    "load_cell": "N",
}
_ENTERS: Mapping[Place, str] = {
    "drive": "DRIVE -> DRIVE + g",
    "tendon": "tendon length -> tendon length + g",
    "transmission": "F -> F*exp(g)",
    "structure": "M -> M + EI*g",
    "sensor": "RESPONSE shown -> RESPONSE + g",
    "load_cell": "F read -> F + g",
}
_ENTERS_AGAINST: Mapping[Place, str] = {
    "drive": "DRIVE with a play of g to either side",
    "tendon": "stretch of the tendon with a play of g to either side",
    "transmission": "F -> F*exp(g) on load, F*exp(-g) on release",
    "structure": "M -> M + EI*g on load, M - EI*g on release",
    "sensor": "RESPONSE shown with a play of g to either side",
    "load_cell": "F read with a play of g to either side",
}
_LABELS_AGAINST: Mapping[Place, str] = {
    "drive": "play, to either side",
    "tendon": "stretch, to either side",
    "transmission": "ln of ratio, against motion",
    "structure": "moment / EI against motion",
    "sensor": "play, to either side",
    "load_cell": "play, to either side",
}
_LABELS: Mapping[Place, str] = {
    "drive": "added stroke",
    "tendon": "added tendon length",
    "transmission": "ln of the tension ratio",
    "structure": "added moment / EI",
    "sensor": "added response",
    "load_cell": "added tension reading",
}


_RESPONSES: Mapping[str, tuple[str, str, float]] = {
    "curvature": ("kappa", "1/m", 1.0),
    "bend": ("theta", "degrees", DEGREE),
    "notch": ("theta", "degrees", DEGREE),
    "position": ("p", "mm", MILLIMETRE),
    "force": ("R", "N", 1.0),
}


@dataclass(frozen=True, slots=True)
class Display:
    """In which units a recording's laws are shown: its kind of response, and whether a tension drives it."""

    response: str
    driven_by_tension: bool = False

    def axis(self, law: UnnamedLaw) -> tuple[str, str, float]:
        """Return symbol and unit of a law's variable, and SI units in one of it."""
        if law.place == "sensor" and law.variable == "curvature" and self.response != "curvature":
            symbol, unit, scale = _RESPONSES[self.response]
            return symbol, unit, scale
        if self.driven_by_tension and law.variable in _UNITS_OF_TENSION:
            return _UNITS_OF_TENSION[law.variable]
        return UNITS[law.variable]

    def amplitude(self, law: UnnamedLaw) -> tuple[str, float]:
        """Return the unit of what a law adds, empty for a pure number, and that unit in the law's own."""
        if law.place == "sensor":
            return _RESPONSES[self.response][1:]
        if law.place == "drive" and self.driven_by_tension:
            return "N", 1.0
        return _AMPLITUDES[law.place], 1.0


@dataclass(frozen=True, slots=True)
class Form:
    """A typed form: its words ("a line"), its right-hand side and values in display units, and the fraction it misses."""

    name: str
    text: str
    missed: float
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Curve:
    """A law over the range that was seen, in display units.

    Attributes:
        x: the remembered variable. y: what is added. low, high: ends of the 90 % band; empty where it is not known.
        axis, unit: labels of x and y with their units. symbol, of: of x, and how it is made where it is not a variable
            itself. enters: what the law does to its stage. form: a short equation, or None where none holds.
    """

    law: Law
    x: tuple[float, ...]
    y: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    axis: str
    unit: str
    symbol: str
    of: str
    enters: str
    form: Form | None

    def rows(self) -> list[tuple[str, ...]]:
        """Return some points from end to end as text: x, y, and the ends of the band where it is known."""
        places = [0] if len(set(self.y)) == 1 else [round(p) for p in np.linspace(0, len(self.x) - 1, _TABLE).tolist()]
        added = [column for column in (self.y, self.low, self.high) if column]
        scale = max(abs(value) for column in added for value in column)
        reach = max(abs(value) for value in self.x)
        return [(_figure(self.x[p], reach), *(_figure(column[p], scale) for column in added)) for p in places]

    def names(self) -> tuple[str, ...]:
        """Return the heads of the columns of ``rows``."""
        return (self.axis, self.unit, "90 % from", "to") if self.low else (self.axis, self.unit)


def curve_of(law: Law) -> tuple[FloatArray, FloatArray]:
    """Return the remembered variable over the range that was seen, SI, and what the law adds there, each (n,)."""
    low, high = (0.0, law.setting) if law.memory == "period" else (law.low, law.high)
    along = np.linspace(low, high, _POINTS)
    along[np.abs(along) < _NOTHING * float(np.max(np.abs(along)))] = 0.0
    return along, law.of(along)


def drawn(law: UnnamedLaw, display: Display, covariance: FloatArray | None = None) -> Curve:
    """Return a law as it is shown.

    Args:
        covariance: of its parameters in declared order, (q, q); None where it is not known.
    """
    along, values = curve_of(law)
    (symbol, per, scale), (unit, size) = display.axis(law), display.amplitude(law)
    half = None if covariance is None else WIDTH_90 * law_deviation(law, along, covariance) / size
    known = half is not None and bool(np.all(np.isfinite(half)))
    x, y = along / scale, values / size
    low, high = np.zeros(0), np.zeros(0)
    if half is not None and known:
        fitted = np.asarray(law.basis(along) @ np.array(law.weights)) / size
        least = 0.0 if law.memory == "friction" else -np.inf
        low, high = np.maximum(fitted - half, least), np.maximum(fitted + half, least)
    drive = "F" if display.driven_by_tension and law.place == "drive" else "X1"
    response = _RESPONSES[display.response][0]
    enters = (_ENTERS_AGAINST if law.memory == "friction" else _ENTERS)[law.place]
    label = _LABELS_AGAINST[law.place] if law.memory == "friction" else _LABELS[law.place]
    label = label.replace("stroke", "tension") if drive == "F" else label
    remembered, made = _remembered(law, symbol, display)
    x_, y_, low_, high_ = (tuple(column.tolist()) for column in (x, y, low, high))
    return Curve(
        law,
        x_,
        y_,
        low_,
        high_,
        f"{made or remembered}{_in(per)}",
        f"{label}{_in(unit)}",
        remembered,
        made,
        enters.replace("DRIVE", drive).replace("RESPONSE", response),
        typed(law, remembered, scale, size),
    )


def equation(curve: Curve) -> str:
    """Return what a law does as an equation that can be typed, with units and range; without a short form, as a table."""
    law, unit = curve.law, curve.unit.rpartition("(")[2].rstrip(")") if "(" in curve.unit else ""
    right = "as in the table" if curve.form is None else curve.form.text
    parts = [f"{curve.enters}, g = {right}"]
    if unit:
        parts.append(f"g in {unit}")
    if law.memory not in ("step", "period"):
        per = curve.axis.rpartition("(")[2].rstrip(")") if "(" in curve.axis else ""
        made = f"{curve.symbol} = {curve.of}, " if curve.of else f"{curve.symbol} "
        parts.append(f"{made}from {curve.x[0]:.3g} to {curve.x[-1]:.3g} {per}".rstrip())
    return ", ".join(parts)


def typed(law: Law, symbol: str = "x", scale: float = 1.0, size: float = 1.0) -> Form | None:
    """Return the shortest form that misses the curve by less than a tenth, or None.

    Args:
        symbol: of the variable that is printed. scale, size: display units of variable and amplitude, in the law's own.
    """
    along, values = curve_of(law)
    x, y = along / scale, values / size
    if law.memory == "step":
        return Form("a step", f"{law.weights[0] / size:.3g} from t = {law.setting:.4g} s on", 0.0, tuple(y.tolist()))
    if law.memory == "period":
        return Form("a wave", _wave(law, symbol, scale, size), 0.0, tuple(y.tolist()))
    reach = float(np.sqrt(np.mean(y**2)))
    if reach == 0.0:
        return Form("constant", "0", 0.0, tuple(y.tolist()))
    for name, (columns_of, shapes), text in _forms(x, symbol):
        missed, coefficients, shape = _closest((columns_of, shapes), x, y)
        if missed >= HOLDS_TO * reach:
            continue
        for digits in _DIGITS:
            c, s = _rounded(coefficients, digits), tuple(_rounded(np.array(shape), digits).tolist())
            columns = columns_of(x, s)
            c[np.abs(c) * np.max(np.abs(columns), axis=0) < _LEAST_TERM * float(np.max(np.abs(columns * c)))] = 0.0
            again = columns @ c
            left = float(np.sqrt(np.mean((y - again) ** 2)))
            if left < HOLDS_TO * reach:
                return Form(name, text(c, s), left / reach, tuple(again.tolist()))
    return None


Columns = Callable[[FloatArray, tuple[float, ...]], FloatArray]
Text = Callable[[FloatArray, tuple[float, ...]], str]


def _wave(law: Law, symbol: str, scale: float, size: float) -> str:
    period = law.setting / scale
    terms = []
    for place, weight in enumerate(law.weights):
        order = "" if place < 2 else f"{place // 2 + 1}*"
        terms.append(f"{weight / size:.3g}*{('sin', 'cos')[place % 2]}(2*pi*{order}{symbol}/{period:.4g})")
    return " + ".join(terms).replace("+ -", "- ")


def _forms(x: FloatArray, name: str) -> Iterator[tuple[str, tuple[Columns, list[tuple[float, ...]]], Text]]:
    """Yield each form, simplest first: its columns for given shape values, the shapes to try, and its equation."""
    span = float(np.ptp(x)) or 1.0
    one = np.ones_like(x)
    first = float(_rounded(x[:1], _DIGITS[0])[0])
    places: list[tuple[float, ...]] = [(float(b),) for b in np.linspace(x[0], x[-1], 42)[1:-1]]
    widths: list[tuple[float, ...]] = [(float(w),) for w in span * np.array([0.05, 0.1, 0.2, 0.35, 0.6, 1.0])]
    humps: list[tuple[float, ...]] = [(b[0], w[0]) for b in places[::2] for w in widths]
    yield "constant", (lambda x, _: np.ones((x.size, 1)), [()]), lambda c, _: _sum(c, ("",))
    yield "a line", (lambda x, _: np.stack([one, x], 1), [()]), lambda c, _: _sum(c, ("", name))
    yield "a square", (lambda x, _: np.stack([one, x**2], 1), [()]), lambda c, _: _sum(c, ("", f"{name}^2"))
    yield (
        "a knee",
        (lambda x, b: np.stack([one, np.maximum(x - b[0], 0.0)], 1), places),
        lambda c, b: _sum(c, ("", f"max({name}{_less(b[0])}, 0)")),
    )
    yield (
        "a square beyond a knee",
        (lambda x, b: np.stack([one, np.maximum(x - b[0], 0.0) ** 2], 1), places),
        lambda c, b: _sum(c, ("", f"max({name}{_less(b[0])}, 0)^2")),
    )
    yield (
        "a saturating curve",
        (lambda x, w: np.stack([one, np.tanh((x - first) / w[0])], 1), widths),
        lambda c, w: _sum(c, ("", f"tanh({f'({name}{_less(first)})' if first else name}/{w[0]:.6g})")),
    )
    yield (
        "a hump",
        (lambda x, s: np.stack([one, np.exp(-0.5 * ((x - s[0]) / s[1]) ** 2)], 1), humps),
        lambda c, s: _sum(c, ("", f"exp(-(({name}{_less(s[0])})/{s[1]:.6g})^2/2)")),
    )
    yield (
        "a line with a knee",
        (lambda x, b: np.stack([one, x, np.maximum(x - b[0], 0.0)], 1), places),
        lambda c, b: _sum(c, ("", name, f"max({name}{_less(b[0])}, 0)")),
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
    parts = [
        f"{value:.6g}{'*' if term else ''}{term}"
        for value, term in zip(coefficients.tolist(), terms, strict=True)
        if value != 0.0
    ]
    return " + ".join(parts).replace("+ -", "- ") or "0"


def _less(value: float) -> str:
    return f" - {value:.6g}" if value >= 0.0 else f" + {-value:.6g}"


def _rounded(values: FloatArray, digits: int) -> FloatArray:
    return np.array([float(f"{value:.{digits}g}") for value in values.tolist()])


def _remembered(law: UnnamedLaw, symbol: str, display: Display) -> tuple[str, str]:
    """Return the symbol of a law's remembered variable, and how it is made where it is not a variable itself."""
    drive = "F" if display.driven_by_tension else "X1"
    if law.memory == "relaxation":
        return "y", f"{symbol} late by {law.setting:.3g} s less {symbol}"
    if law.memory == "maximum":
        return "y", f"largest {symbol} so far"
    if law.memory == "path":
        return "y", f"path of {symbol}"
    if law.variable == "path":
        return "y", f"path of {drive}"
    return (symbol, f"d{drive}/dt") if law.variable == "rate" else (symbol, "")


def law_deviation(law: Law, along: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the standard deviation of what a law adds at values of its remembered variable, (n,), to first order."""
    slopes = [law.basis(along)]
    if len(law.values()) > len(law.weights):
        step = _STEP * law.setting
        moved = law.with_values(np.array([*law.weights, law.setting + step]))
        slopes.append(((moved.of(along) - law.of(along)) / step)[:, np.newaxis])
    matrix = np.concatenate(slopes, axis=1)
    return np.asarray(np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", matrix, covariance, matrix), 0.0)))


def _in(unit: str) -> str:
    return f" ({unit})" if unit else ""


def _figure(value: float, largest: float) -> str:
    """Return a number to a hundredth of the largest beside it, or better."""
    digits = 0 if largest == 0.0 else max(2 - int(np.floor(np.log10(largest))), 0)
    return f"{value:.{digits}f}"
