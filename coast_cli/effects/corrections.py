"""What a ``[corrections]`` table may hold: the effects of joints and of shapes together, by id and parameter.

A model that was corrected on shapes is compared on joints too. What belongs to the tubes goes along; what belongs to the bench
or the camera stays with the kind of recording that it was found on, which the table's ``recording`` key says. A law without
a name is a table of its own form (``unnamed.UnnamedLaw.table``).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from coast_cli.effects.effect import Effect, RecordingKind
from coast_cli.effects.unnamed import DamagedLaw, UnnamedLaw
from coast_cli.effects.unnamed_shape import Law, ShapeLaw
from coast_cli.errors import nearest

Correction = Mapping[str, float | str | Sequence[float]]
_OWN = "One of your own takes part once its file is given (`coast guide own-effects`)."
_UNNAMED = re.compile(r"unnamed_([1-9])")


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong in a ``[corrections]`` table: the keys below it, and what to say."""

    path: tuple[str, ...]
    message: str
    found: float | str | None = None
    allowed: str | None = None
    hint: str | None = None


def correction_parameters(*catalogues: Mapping[str, type[Effect]]) -> Mapping[str, Mapping[str, tuple[float, float]]]:
    """Return the range of every parameter of every effect; of one that several kinds have, the widest range."""
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for effect in (effect for catalogue in catalogues for effect in catalogue.values()):
        ranges = found.setdefault(effect.id, {})
        for parameter in (p for recording in effect.recordings for p in effect.parameters_on(recording)):
            low, high = ranges.get(parameter.name, (parameter.low, parameter.high))
            ranges[parameter.name] = min(low, parameter.low), max(high, parameter.high)
    return found


def faults(corrections: Mapping[str, Correction], *catalogues: Mapping[str, type[Effect]]) -> Iterator[Fault]:
    """Yield what is wrong in a table of corrections."""
    known = correction_parameters(*catalogues)
    for effect, values in corrections.items():
        if _UNNAMED.fullmatch(effect):
            try:
                unnamed_law(effect, values)
            except DamagedLaw as error:
                path = (effect, error.key) if error.key in values else (effect,)
                yield Fault(path, f"a damaged law without a name: {error}")
        elif effect not in known:
            yield Fault(
                (effect,), "there is no such effect", allowed=", ".join(known), hint=nearest(effect, known) or _OWN
            )
        else:
            yield from _value_faults(effect, values, known[effect])


def _value_faults(effect: str, values: Correction, ranges: Mapping[str, tuple[float, float]]) -> Iterator[Fault]:
    for name, value in values.items():
        if name == "recording":
            if value not in ("joint", "shapes"):
                yield Fault((effect, name), "not allowed", str(value), "joint or shapes")
            continue
        if name not in ranges:
            allowed, hint = ", ".join(ranges), nearest(name, ranges)
            yield Fault((effect, name), "there is no such parameter", allowed=allowed, hint=hint)
            continue
        low, high = ranges[name]
        if not isinstance(value, int | float):
            yield Fault((effect, name), "not a number", str(value), f"from {low:g} to {high:g}")
        elif not low <= value <= high:
            yield Fault((effect, name), "not allowed", float(value), f"from {low:g} to {high:g}")


def unnamed_law(effect: str, values: Correction) -> Law:
    """Return the law of a table ``unnamed_N``: of shapes where its ``recording`` says so, else of joints.

    Raises:
        DamagedLaw: the table is damaged; the message says how.
    """
    if values.get("recording") == "shapes":
        return ShapeLaw.from_table(values, int(effect[-1]))
    return UnnamedLaw.from_table({k: v for k, v in values.items() if k != "recording"}, int(effect[-1]))


def own_values(effect: type[Effect], values: Correction, recording: RecordingKind) -> dict[str, float]:
    """Return the values that an effect has on a kind of recording, none where they stay with the other kind."""
    if effect.scope != "tube" and values.get("recording", recording) != recording:
        return {}
    known = {parameter.name for parameter in effect.parameters_on(recording)}
    return {name: float(value) for name, value in values.items() if name in known and isinstance(value, int | float)}
