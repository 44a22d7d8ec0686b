"""One answer against one truth: what was named, in which class, how much it scores.

And whether the place is right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

CLASSES = ("none", "parameter", "physics", "sensor", "unknown")
VERDICTS = {
    "agrees": "none",
    "parameters": "parameter",
    "physics": "physics",
    "sensor": "sensor",
    "unexplained": "unknown",
    "ambiguous": "undecided",
    "insufficient": "undecided",
}


@dataclass(frozen=True)
class Judgement:
    """What one case shows; None where a figure does not apply."""

    case: str
    level: str
    truth: tuple[str, ...]
    verdict: str
    named: tuple[str, ...]
    group: tuple[str, ...]
    truth_class: str
    said_class: str
    score: float
    alarm: bool | None
    first: bool | None
    first_two: bool | None
    wrong: bool | None
    unexplained: bool | None
    second_found: bool | None
    second_wrong: bool | None
    overlap: float | None
    component: bool | None
    confidence: float | None
    seconds: float
    after_request: str | None = None
    figures: dict[str, float] = field(default_factory=dict)


def names(diagnosis: dict[str, Any]) -> tuple[list[str], list[str]]:
    """Effects named, leading one first, and every name in a group the answer could not tell apart."""
    named = [str(effect["id"]) for effect in diagnosis.get("effects") or []]
    group = [
        str(name)
        for entry in diagnosis.get("alternatives") or []
        for name in ([entry] if isinstance(entry, str) else entry)
    ]
    return named, group


def judge(case: str, truth: dict[str, Any], answer: dict[str, Any]) -> Judgement:
    """Return the judgement of one case; no answer at all is a verdict of its own, `failed`."""
    diagnosis = answer.get("diagnosis") or {"verdict": "failed", "effects": []}
    verdict = str(diagnosis.get("verdict"))
    named, group = names(diagnosis)
    effects = [name for name in named if _kind(diagnosis, name) != "parameter"] or named
    level, true = truth["level"], [str(effect["id"]) for effect in truth["effects"]]
    truth_class = _truth_class(level, truth)
    said = VERDICTS.get(verdict, "failed")
    near = set(truth.get("near", ()))
    twins = set(truth.get("twins", ()))
    first = bool(effects and true and effects[0] == true[0]) and said not in ("none", "failed")
    allowed = set(true) | twins | near
    wrong = bool(true and effects and said in ("physics", "sensor") and effects[0] not in allowed)
    if level == "L6":
        wrong = bool(effects and said in ("physics", "sensor") and effects[0] not in near)
    scored = _score(said, effects, group, true, truth)
    identified = level in ("L1", "L5") and not twins
    overlap = component = None
    if identified and first:
        overlap = _overlap(truth.get("where", []), diagnosis.get("where") or [])
        component = _same_component(
            truth["effects"][0]["component"], str(diagnosis["effects"][named.index(true[0])].get("component", ""))
        )
    second = answer.get("second")
    return Judgement(
        case,
        level,
        tuple(true),
        verdict,
        tuple(named),
        tuple(group),
        truth_class,
        said,
        scored,
        alarm=_alarm(said, effects) if level in ("L0", "LP") else None,
        first=first if identified else None,
        first_two=(first or true[0] in [*effects[:2], *group[:1]]) if identified else None,
        wrong=wrong if level not in ("L0", "LP") else None,
        unexplained=(said == "unknown") if level == "L6" else None,
        second_found=(len(true) == 2 and set(true) <= set(effects)) if level == "L4" else None,
        second_wrong=bool(set(effects) - set(true)) if level == "L4" else None,
        overlap=overlap,
        component=component,
        confidence=_confidence(diagnosis, effects),
        seconds=float(answer.get("seconds", math.nan)),
        after_request=None if level != "L2" else _after(second, true),
    )


def _kind(diagnosis: dict[str, Any], name: str) -> str:
    return next((str(effect.get("kind", "")) for effect in diagnosis["effects"] if effect["id"] == name), "")


def _truth_class(level: str, truth: dict[str, Any]) -> str:
    if level in ("L0", "LP"):
        return "none" if level == "L0" else "parameter"
    return "unknown" if level == "L6" else str(truth["effects"][0]["kind"])


def _alarm(said: str, effects: list[str]) -> bool:
    """On a clean record: anything but agreement, refitted parameters.

    Or an honest "cannot decide" that names nothing.
    """
    return said in ("physics", "sensor", "unknown", "failed") or (said == "undecided" and bool(effects))


def _score(said: str, effects: list[str], group: list[str], true: list[str], truth: dict[str, Any]) -> float:
    """Return +1 right, +0.5 second, +0.25 honest "cannot tell", -2 wrong name or false alarm, 0 missed."""
    level, near, twins = truth["level"], set(truth.get("near", ())), set(truth.get("twins", ()))
    if said == "failed":
        return -2.0 if level in ("L0", "LP") else 0.0
    if level in ("L0", "LP"):
        return _score_clean(level, said, effects)
    if level == "L6":
        if said == "unknown":
            return 1.0
        honest = said == "undecided" or (bool(effects) and effects[0] in near)
        return 0.25 if honest else -2.0 if said in ("physics", "sensor") else 0.0
    if said == "unknown":
        return 0.25
    if said == "undecided":
        offered = {*effects, *group}
        return 0.25 if not offered or offered & {*true, *twins} else -2.0
    if effects[:1] == true[:1]:
        return 1.0
    if said in ("none", "parameter"):
        # Nothing to see, or a camera's scale taken for the stiffness that it is to this recording.
        hidden = all(float(effect["noise_widths"]) < 1.0 for effect in truth["effects"])
        return 1.0 if "youngs_modulus" in twins else 0.25 if hidden else 0.0
    return 0.5 if true[0] in effects[1:2] or (effects and effects[0] in {*true, *twins}) else -2.0


def _score_clean(level: str, said: str, effects: list[str]) -> float:
    if _alarm(said, effects):
        return -2.0
    if said == "undecided":
        return 0.25
    return 1.0 if level == "L0" or said == "parameter" else 0.0


def _overlap(true: list[dict[str, Any]], said: list[dict[str, Any]]) -> float:
    """Best overlap (intersection over union) of the answer's first three places with a true window on the same axis."""
    best = 0.0
    for window in true:
        for place in said[:3]:
            if place.get("axis") != window["axis"]:
                continue
            if window["value"] is not None:
                best = max(best, float(str(place.get("value")) == window["value"]))
            elif window["low"] is None or place.get("low") is None or place.get("high") is None:
                best = max(best, float(window["low"] is None))
            else:
                low, high = float(place["low"]), float(place["high"])
                shared = max(0.0, min(high, window["high"]) - max(low, window["low"]))
                whole = max(high, window["high"]) - min(low, window["low"])
                best = max(best, shared / whole if whole > 0 else 1.0)
    return best


def _same_component(true: str, said: str) -> bool:
    return bool({word.strip() for word in true.split(",")} & {word.strip() for word in said.split(",")})


def _confidence(diagnosis: dict[str, Any], effects: list[str]) -> float | None:
    for effect in diagnosis.get("effects") or []:
        if effects and effect["id"] == effects[0] and effect.get("confidence") is not None:
            return float(effect["confidence"])
    return None


def _after(second: dict[str, Any] | None, true: list[str]) -> str | None:
    """Return what was said once the proposed recording was added: right, wrong, undecided, or not asked."""
    if not second or not second.get("diagnosis"):
        return None
    named, group = names(second["diagnosis"])
    if named and named[0] == true[0]:
        return "right"
    said = VERDICTS.get(str(second["diagnosis"].get("verdict")), "failed")
    return "wrong" if said in ("physics", "sensor") and true[0] not in group else "undecided"
