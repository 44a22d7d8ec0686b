"""What is known of a law without a name, in a sentence: only what all explanations that the recording cannot tell apart agree on.

An explanation is one law or two side by side. What it adds is said with its numbers (``trend``), then whether it
remembers and whether speed matters, what it dissipates, and which other explanations and names come near.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from coast_cli.diagnosis.unnamed.forms import Curve, Display, drawn, equation
from coast_cli.diagnosis.unnamed.trend import added_by, subject
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.effects.unnamed_shape import Law
from coast_cli.mechanics.section import FloatArray

_MOST_TOLD = 3


@dataclass(frozen=True, slots=True)
class Known:
    """What a recording says of the laws that lead, beside their numbers.

    Attributes:
        covariance: of each law's parameters in declared order, by the law's number. energy: taken in a loop, J.
        loop: that loop in words. held_out: noise widths that rows not fitted miss, without the laws and with them.
        memory, rate: whether the recording can show them at all. open: what it cannot hold, a clause each.
    """

    covariance: Mapping[int, FloatArray] = field(default_factory=dict)
    energy: float | None = None
    loop: str = ""
    held_out: tuple[float, float] | None = None
    memory: bool = True
    rate: bool = True
    open: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Description:
    """What a diagnosis says of a law without a name.

    Attributes:
        stages, variables: of every law of every explanation that the recording cannot tell apart; the leading one first.
        memory, rate, dissipative: whether any law of an explanation has it; None where explanations do not agree, or
            where the recording cannot show it.
        equation: of the leading law; a short form where one holds. words: a sentence. parameters: of the leading law.
        nearest: effects of the catalogue by what each leaves, in noise widths, least first.
        curves: of every law of the leading explanation, over the range seen, the leading law first.
        laws: the leading law first, then the one beside it, then those of the other explanations.
        energy_uj: that a loop dissipates, where it does. open: what the recording cannot hold, a clause each.
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
    curves: tuple[Curve, ...] = ()
    laws: tuple[Law, ...] = field(default=())
    energy_uj: float | None = None
    open: tuple[str, ...] = ()


def remembers(law: UnnamedLaw) -> bool:
    """Return whether the law depends on the past."""
    return law.memory in ("friction", "relaxation", "maximum", "path") or law.variable == "path"


def depends_on_rate(law: UnnamedLaw) -> bool:
    """Return whether the same sweep at another speed answers otherwise."""
    return law.memory == "relaxation" or law.variable == "rate"


def dissipates(law: UnnamedLaw) -> bool:
    """Return whether the law takes energy of the robot in a loop."""
    return law.kind == "physics" and (law.memory in ("friction", "relaxation") or law.variable == "rate")


def describe(
    explanations: Sequence[Sequence[UnnamedLaw]],
    display: Display,
    nearest: Sequence[tuple[str, float]] = (),
    known: Known | None = None,
) -> Description:
    """Return what is known of a law: the leading explanation, and others that the recording cannot tell from it.

    Args:
        explanations: laws side by side, the leading explanation first and in it the leading law.
        display: units of the recording. nearest: ids and noise widths left. known: what the recording says besides.
    """
    known = known or Known()
    leading = explanations[0]
    laws = tuple(law for laws in explanations for law in laws)
    curves = tuple(drawn(law, display, known.covariance.get(law.number)) for law in leading)
    takes = None if known.energy is None or known.energy <= 0.0 else known.energy
    memory = _agreed([any(remembers(law) for law in laws) for laws in explanations]) if known.memory else None
    rate = _agreed([any(depends_on_rate(law) for law in laws) for laws in explanations]) if known.rate else None
    told = [", together with ".join(added_by(law, display) for law in laws) for laws in explanations]
    words = [
        f"Behaves like {told[0]}{_facts(leading, memory=memory, rate=rate)}{_dissipated(leading, takes, known.loop)}.",
        _open(known.open),
        _others([one for one in dict.fromkeys(told[1:]) if one != told[0]]),
        _names(nearest),
        _held_out(known.held_out),
    ]
    return Description(
        stages=tuple(dict.fromkeys(law.place for law in laws)),
        variables=tuple(dict.fromkeys(law.variable for law in laws)),
        memory=memory,
        rate=rate,
        dissipative=_agreed([any(dissipates(law) for law in laws) for laws in explanations]),
        equation="; ".join(equation(curve) for curve in curves),
        words=" ".join(word for word in words if word),
        parameters={p.name: v for p, v in zip(leading[0].parameters, leading[0].values(), strict=True)},
        nearest=tuple(nearest),
        curves=curves,
        laws=laws,
        energy_uj=None if takes is None else 1e6 * takes,
        open=known.open,
    )


def _agreed(answers: Sequence[bool]) -> bool | None:
    return answers[0] if len(set(answers)) == 1 else None


def _facts(leading: Sequence[UnnamedLaw], *, memory: bool | None, rate: bool | None) -> str:
    who = list(dict.fromkeys(subject(law) for law in leading if remembers(law)))
    facts = []
    if memory is not None:
        facts.append(
            f"{' and '.join(who)} remember{'s' if len(who) == 1 else ''}" if memory else "it does not remember"
        )
    if rate is not None:
        facts.append("speed matters" if rate else "speed does not matter")
    return f": {', '.join(facts)}" if facts else ""


def _dissipated(leading: Sequence[UnnamedLaw], energy: float | None, loop: str) -> str:
    if energy is None or not any(dissipates(law) for law in leading):
        return ""
    return f"; dissipates {1e6 * energy:.2g} uJ in {loop or 'a loop'}"


def _open(clauses: Sequence[str]) -> str:
    return f"Not held by this recording: {'; '.join(clauses)}." if clauses else ""


def _others(told: Sequence[str]) -> str:
    more = f"; and {len(told) - _MOST_TOLD} more" if len(told) > _MOST_TOLD else ""
    return f"The recording cannot tell it from {'; or from '.join(told[:_MOST_TOLD])}{more}." if told else ""


def _names(nearest: Sequence[tuple[str, float]]) -> str:
    names = ", ".join(f"{name.replace('_', ' ')} (leaves {left:.2g} noise widths)" for name, left in nearest[:3])
    return f"Nearest names: {names}." if names else ""


def _held_out(widths: tuple[float, float] | None) -> str:
    return f"Held out: {widths[0]:.1f} to {widths[1]:.1f} times the noise." if widths else ""
