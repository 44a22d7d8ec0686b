"""What is known of a law without a name of shapes, in a sentence, an equation and a curve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from coast_cli.diagnosis.unnamed.forms import WIDTH_90, Curve, curve_of, equation, law_deviation, typed
from coast_cli.diagnosis.unnamed.words import Description
from coast_cli.effects.unnamed_shape import Adds, ShapeLaw
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

_ADDED: Mapping[Adds, str] = {
    "curvature": "a natural curvature of its own",
    "compliance": "a compliance that changes",
    "force": "a force on the tube",
    "height": "heights that the camera moves",
}
_EQUATION: Mapping[Adds, str] = {
    "curvature": "k0(s) -> k0 + g",
    "compliance": "1/EI(s) -> e^g/EI",
    "force": "w(s) -> w + g",
    "height": "y -> y + g",
}
_UNIT: Mapping[Adds, tuple[str, float]] = {
    "curvature": ("1/m", 1.0),
    "compliance": ("", 1.0),
    "force": ("N/m", 1.0),
    "height": ("mm", MILLIMETRE),
}
_LABELS: Mapping[Adds, str] = {
    "curvature": "added natural curvature",
    "compliance": "ln of the compliance's factor",
    "force": "added weight",
    "height": "added height",
}


def describe_shape(
    laws: Sequence[ShapeLaw],
    tubes: Mapping[int, str],
    nearest: Sequence[tuple[str, float]],
    covariance: FloatArray | None = None,
    held_out: tuple[float, float] | None = None,
) -> Description:
    """Return what is known: of the leading law, and what all that the photographs cannot tell from it agree on.

    Args:
        covariance: of the leading law's parameters (q, q), where it is known.
        held_out: noise widths that points not fitted miss, without the law and with it.
    """
    leading = laws[0]
    curve = _drawn(leading, covariance)
    return Description(
        stages=tuple(dict.fromkeys(law.place for law in laws)),
        variables=tuple(dict.fromkeys(law.variable for law in laws)),
        memory=False,
        rate=False,
        dissipative=False,
        equation=equation(curve),
        words=_sentence(laws, tubes, nearest, held_out),
        parameters={p.name: value for p, value in zip(leading.parameters, leading.values(), strict=True)},
        nearest=tuple(nearest),
        curves=(curve,),
        laws=tuple(laws),
    )


def _drawn(law: ShapeLaw, covariance: FloatArray | None) -> Curve:
    along, values = curve_of(law)
    unit, size = _UNIT[law.adds]
    symbol = "x" if law.place == "camera" else "s"
    y = values / size
    low, high = np.zeros(0), np.zeros(0)
    if covariance is not None and np.all(np.isfinite(covariance)):
        half = WIDTH_90 * law_deviation(law, along, covariance) / size
        low, high = y - half, y + half
    x, y_, low_, high_ = (tuple(column.tolist()) for column in (along / MILLIMETRE, y, low, high))
    label = f"{_LABELS[law.adds]} ({unit})" if unit else _LABELS[law.adds]
    form = typed(law, symbol, MILLIMETRE, size)
    return Curve(law, x, y_, low_, high_, f"{symbol} (mm)", label, symbol, "", _EQUATION[law.adds], form)


def _sentence(
    laws: Sequence[ShapeLaw],
    tubes: Mapping[int, str],
    nearest: Sequence[tuple[str, float]],
    held_out: tuple[float, float] | None,
) -> str:
    leading = laws[0]
    text = f"Behaves like {_told(leading, tubes)}"
    if leading.adds == "curvature":
        text += "; it turns over with the tube"
    if leading.adds == "force":
        text += "; it keeps its side when the tube is turned over"
    text += "."
    others = [one for one in dict.fromkeys(_told(law, tubes) for law in laws[1:]) if one != _told(leading, tubes)]
    if others:
        text += f" The photographs cannot tell it from {'; '.join(others[:3])}."
    if nearest:
        names = ", ".join(f"{name.replace('_', ' ')} (leaves {left:.2g} noise widths)" for name, left in nearest[:3])
        text += f" Nearest names: {names}."
    if held_out is not None:
        text += f" Held out: {held_out[0]:.1f} to {held_out[1]:.1f} noise widths."
    return text


def _told(law: ShapeLaw, tubes: Mapping[int, str]) -> str:
    number = round(law.tube)
    whose = f" on {tubes.get(number, number)}" if number else " on every tube alike" if len(tubes) > 1 else ""
    where = "across the picture" if law.place == "camera" else "along the tube"
    if law.period:
        return f"{_ADDED[law.adds]}{whose}, a wave {where} of {law.period / MILLIMETRE:.3g} mm"
    return f"{_ADDED[law.adds]}{whose} and {_trend(law)} {where}"


def _trend(law: ShapeLaw) -> str:
    """Return in words how the curve runs."""
    _, values = curve_of(law)
    change = values - values[0]
    largest = float(np.max(np.abs(change)))
    if largest < 1e-9 + 0.05 * float(np.max(np.abs(values))):
        return "is the same all"
    turns = int(np.sum(np.diff(np.sign(np.diff(values))) != 0))
    if turns > 2:
        return "swings"
    if turns == 0:
        return "grows" if change[-1] > 0.0 else "falls"
    return "rises and falls" if change[int(np.argmax(np.abs(change)))] > 0.0 else "falls and rises"
