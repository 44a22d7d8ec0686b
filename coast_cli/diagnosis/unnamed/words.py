"""What is known of a law without a name, in a sentence: only what all laws that the recording cannot tell apart agree on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from coast_cli.diagnosis.unnamed.forms import UNITS, curve_of, symbol, typed
from coast_cli.effects.unnamed import Place, UnnamedLaw, Variable
from coast_cli.units import DEGREE

_ADDED: Mapping[Place, str] = {
    "drive": "an added stroke",
    "tendon": "an added length of the tendon",
    "transmission": "a changed ratio of tensions along the tendon",
    "structure": "an added bending moment",
    "sensor": "an added response of the camera",
    "load_cell": "an added reading of the load cell",
}
_NAMES: Mapping[Variable, str] = {
    "stroke": "the stroke",
    "tension": "the tension",
    "curvature": "the curvature",
    "bending_length": "the bending length",
    "position": "the place along the segment",
    "time": "time",
    "rate": "the speed of the drive",
    "path": "the path travelled",
    "run": "the run",
}
_LEVEL = 0.15  # of the curve's largest value, within which it counts as none


@dataclass(frozen=True, slots=True)
class Description:
    """What a diagnosis says of a law without a name.

    Attributes:
        stages, variables: of every law that the recording cannot tell from the leading one; the leading one first.
        memory, rate, dissipative: None where those laws do not agree.
        equation: of the leading law; a short form where one holds. words: a sentence. parameters: of the leading law.
        nearest: effects of the catalogue by what each leaves, in noise widths, least first.
        curve: the leading law over the range seen: remembered variable and what is added, in display units.
        axis, unit: what the curve is drawn over, and what is added, in words with units.
    """

    stages: tuple[str, ...]
    variables: tuple[str, ...]
    memory: bool | None
    rate: bool | None
    dissipative: bool | None
    equation: str
    words: str
    parameters: Mapping[str, float]
    nearest: tuple[tuple[str, float], ...] = ()
    curve: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    axis: str = ""
    unit: str = ""
    laws: tuple[UnnamedLaw, ...] = field(default=())


def remembers(law: UnnamedLaw) -> bool:
    """Return whether the law depends on the past."""
    return law.memory in ("friction", "relaxation", "maximum", "path") or law.variable == "path"


def depends_on_rate(law: UnnamedLaw) -> bool:
    """Return whether the same sweep at another speed answers otherwise."""
    return law.memory == "relaxation" or law.variable == "rate"


def dissipates(law: UnnamedLaw) -> bool:
    """Return whether the law takes energy of the robot in a loop."""
    return law.kind == "physics" and (law.memory in ("friction", "relaxation") or law.variable == "rate")


def unit_of(law: UnnamedLaw, response: str) -> tuple[str, float]:
    """Return the display unit of what a law adds, and that unit in the law's own."""
    if law.place == "sensor":
        return ("1/m", 1.0) if response == "curvature" else ("degrees", DEGREE)
    units = {
        "drive": "mm",
        "tendon": "mm",
        "transmission": "1",
        "structure": "1/m of curvature times EI",
        "load_cell": "N",
    }
    return units[law.place], 1.0


def describe(
    laws: Sequence[UnnamedLaw],
    response: str,
    nearest: Sequence[tuple[str, float]] = (),
    *,
    driven_by_tension: bool = False,
) -> Description:
    """Return what is known of a law: the leading one, and others that the recording cannot tell from it.

    Args:
        laws: the leading one first. response: kind of response of the recording. nearest: ids and noise widths left.
        driven_by_tension: whether the drive is a tension, in which a law of the drive is then added.
    """
    leading = laws[0]
    unit, size = ("N", 1.0) if leading.place == "drive" and driven_by_tension else unit_of(leading, response)
    form = typed(leading, size)
    along, values = curve_of(leading)
    scale = UNITS[leading.variable][2]
    return Description(
        stages=tuple(dict.fromkeys(law.place for law in laws)),
        variables=tuple(dict.fromkeys(law.variable for law in laws)),
        memory=_agreed([remembers(law) for law in laws]),
        rate=_agreed([depends_on_rate(law) for law in laws]),
        dissipative=_agreed([dissipates(law) for law in laws]),
        equation=_equation(leading, unit, None if form is None else form.equation),
        words=_sentence(laws, nearest),
        parameters={p.name: value for p, value in zip(leading.parameters, leading.values(), strict=True)},
        nearest=tuple(nearest),
        curve=(tuple((along / scale).tolist()), tuple((values / size).tolist())),
        axis=f"{symbol(leading)} ({UNITS[leading.variable][1]})",
        unit=f"{_ADDED[leading.place]} ({unit})",
        laws=tuple(laws),
    )


def _agreed(answers: Sequence[bool]) -> bool | None:
    return answers[0] if len(set(answers)) == 1 else None


def _equation(law: UnnamedLaw, unit: str, form: str | None) -> str:
    what = {
        "drive": "X1 -> X1 + g",
        "tendon": "tendon length -> + g",
        "transmission": "F -> F e^g",
        "structure": "M -> M + EI g",
        "sensor": "response -> response + g",
        "load_cell": "tension read -> + g",
    }[law.place]
    if law.memory == "friction":
        what = {"structure": "M -> M +- EI g", "transmission": "F -> F e^(+-g)"}.get(
            law.place, f"play of half width g: {what}"
        )
    tail = f", time constant {law.setting:.3g} s" if law.memory == "relaxation" else ""
    shape = form if form is not None else f"a curve over {symbol(law)}, drawn"
    return f"{what}, g = {shape} ({unit}){tail}"


def _sentence(laws: Sequence[UnnamedLaw], nearest: Sequence[tuple[str, float]]) -> str:
    leading = laws[0]
    text = f"Behaves like {_ADDED[leading.place]} {_dependence(leading)}"
    facts = []
    memory, rate = _agreed([remembers(law) for law in laws]), _agreed([depends_on_rate(law) for law in laws])
    if memory is not None:
        facts.append("it remembers" if memory else "it does not remember")
    if rate is not None:
        facts.append("speed matters" if rate else "speed does not matter")
    if _agreed([dissipates(law) for law in laws]):
        facts.append("it takes energy in every loop")
    if facts:
        text += ": " + ", ".join(facts)
    text += "."
    told = f"{_ADDED[leading.place]} {_dependence(leading)}"
    others = [
        one for one in dict.fromkeys(f"{_ADDED[law.place]} {_dependence(law)}" for law in laws[1:]) if one != told
    ]
    if others:
        text += f" The recording cannot tell it from {'; '.join(others[:3])}."
    if nearest:
        names = ", ".join(
            f"{identifier.replace('_', ' ')} (leaves {left:.2g} noise widths)" for identifier, left in nearest[:3]
        )
        text += f" Nearest names: {names}."
    return text


def _dependence(law: UnnamedLaw) -> str:
    name, (_, unit, scale) = _NAMES[law.variable], UNITS[law.variable]
    if law.memory == "step":
        return f"that sets in at {law.setting:.3g} s"
    if law.memory == "period":
        return f"that swings with {name}, period {law.setting / scale:.3g} {unit}"
    if law.memory == "relaxation":
        return f"that follows {name} late, within about {law.setting:.3g} s"
    if law.memory == "friction":
        return f"against the motion, {_trend(law)}"
    if law.memory == "maximum":
        return f"by the largest value of {name.removeprefix('the ')} so far"
    if law.memory == "path":
        return f"that builds up with the path of {name.removeprefix('the ')}"
    return f"that {_trend(law)}"


def _trend(law: UnnamedLaw) -> str:
    """Return in words how the curve runs over its variable."""
    along, values = curve_of(law)
    name, (_, unit, scale) = _NAMES[law.variable], UNITS[law.variable]
    largest = float(np.max(np.abs(values))) or 1.0
    if float(np.ptp(values)) < _LEVEL * largest:
        return "is constant" if law.memory != "friction" else "constant"
    size = np.abs(values - values[0]) if law.memory != "friction" else np.abs(values)
    quiet = np.flatnonzero(np.abs(values - values[0]) > _LEVEL * float(np.ptp(values)))
    begins = float(along[quiet[0]]) / scale if quiet.size else float(along[0]) / scale
    grows = bool(size[-1] > 0.6 * float(size.max()))
    verb = ("grows" if size[-1] >= size[0] else "falls") if grows or size[-1] < size[0] else "rises and falls"
    late = begins > along[0] / scale + 0.3 * float(np.ptp(along)) / scale
    return f"{verb} with {name}" + (f" beyond {begins:.3g} {unit}" if late else "")
