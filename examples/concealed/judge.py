"""One answer against one truth: what was named, in which class, where, with which odds, and how a nameless law is described.

A judgement holds all that the table and the pictures need; it is what is kept of a case.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from examples.concealed.points import CLEAN, OPEN, Said, blind, is_alarm, points

CLASSES = ("none", "parameter", "physics", "sensor", "unknown")
FACTS = ("stage", "variable", "memory", "rate")


@dataclass(frozen=True)
class Judgement:
    """What one case shows; None where a figure does not apply.

    `wrong` is a wrong name (any name outside the catalogue's reach), `told` whether none, parameter, physics, sensor and
    unknown were told apart; `facts` are stage, variable, memory and rate of a nameless law, right or not; `beliefs` are
    pairs of a stated probability and whether it came true; `intervals` name, hit and bias (%) of base parameters.
    """

    case: str
    seed: int
    kind: str
    level: str
    truth: tuple[str, ...]
    laws: tuple[str, ...]
    sizes: tuple[float, ...]
    noise: str
    sigma: float
    verdict: str
    named: tuple[str, ...]
    group: tuple[str, ...]
    truth_class: str
    said_class: str
    score: float
    confidence: float | None
    alarm: bool | None
    first: bool | None
    first_two: bool | None
    wrong: bool | None
    told: bool | None
    unexplained: bool | None
    facts: tuple[bool, bool, bool, bool] | None
    second_found: bool | None
    second_wrong: bool | None
    overlap: float | None
    component: bool | None
    bench_right: bool | None
    blind: bool | None
    seconds: float
    after_request: str | None = None
    beliefs: tuple[tuple[float, bool], ...] = ()
    intervals: tuple[tuple[str, bool, float], ...] = ()
    figures: dict[str, float] = field(default_factory=dict)

    @property
    def described(self) -> bool | None:
        """Whether stage, variable, memory and rate are all right."""
        return None if self.facts is None else all(self.facts)


def judge(
    case: str, truth: dict[str, Any], answer: dict[str, Any], figures: dict[str, float] | None = None
) -> Judgement:
    """Return the judgement of one case; no answer at all is a verdict of its own, `failed`.

    `figures` are the held-out errors of the answer's model, `recorded` and `noiseless`, where they were recomputed.
    """
    figures = figures or {}
    diagnosis = answer.get("diagnosis") or {"verdict": "failed", "effects": []}
    said = Said.of(diagnosis)
    level, effects = truth["level"], truth["effects"]
    true = [str(effect["id"]) for effect in effects]
    facts = describe(diagnosis, effects) if level in OPEN and "nature" in effects[0] else None
    leading = said.effects[0] if said.effects and said.kind in ("physics", "sensor") else None
    twins = set(truth.get("twins", ()))
    # As in the first round: a leading name counts where others fit alike too; the score tells the difference.
    first = bool(true) and said.effects[:1] == true[:1] and said.kind not in ("none", "unknown", "failed")
    identified = level in ("L1", "L5") and not twins
    placed = (identified or level == "L9") and bool(said.effects)
    return Judgement(
        case,
        int(truth.get("seed", 0)),
        str(truth.get("kind", "joint")),
        level,
        tuple(true),
        tuple(str(effect.get("law", effect["id"])) for effect in effects),
        tuple(float(effect.get("noise_widths", 0.0)) for effect in effects),
        str(truth.get("noise", {}).get("kind", "")),
        float(truth.get("noise", {}).get("sigma", math.nan)),
        str(diagnosis.get("verdict")),
        tuple(said.named),
        tuple(said.group),
        _truth_class(level, effects),
        said.kind,
        points(said, truth, facts, figures),
        _confidence(diagnosis, said.effects),
        alarm=is_alarm(said) if level in CLEAN else None,
        first=first if identified else None,
        first_two=(first or true[0] in [*said.effects[:2], *said.group[:1]]) if identified else None,
        wrong=None if level in CLEAN else bool(leading and (level in OPEN or leading not in {*true, *twins})),
        told=_told(level, said, effects, twins),
        unexplained=said.kind == "unknown" if level in OPEN else None,
        facts=facts,
        second_found=(len(true) == 2 and set(true) <= set(said.effects)) if level == "L4" else None,
        second_wrong=bool(set(said.effects) - set(true)) if level == "L4" else None,
        overlap=_overlap(truth.get("where", []), diagnosis.get("where") or []) if placed else None,
        component=_component(effects[0], diagnosis) if placed else None,
        bench_right=_bench_right(said, effects[0], diagnosis) if level == "L9" else None,
        blind=blind(said, truth, figures) if level == "L9" else None,
        seconds=float(answer.get("seconds", math.nan)),
        after_request=None if level != "L2" else _after(answer.get("second"), true),
        beliefs=_beliefs(diagnosis, said, true, level),
        intervals=_intervals(truth, diagnosis),
        figures=figures,
    )


def describe(diagnosis: dict[str, Any], effects: list[dict[str, Any]]) -> tuple[bool, bool, bool, bool]:
    """Return whether stage, variable, memory and rate of the law given are right; of two laws the better told counts.

    An answer lists what it cannot tell apart: a list is right that holds the truth and at most one word that is wrong.
    """
    law = diagnosis.get("unnamed") or {}
    best = (False, False, False, False)
    for effect in effects if diagnosis.get("verdict") in ("unnamed", "ambiguous") else ():
        nature = effect["nature"]
        stages, variables = (
            {str(word).replace(" ", "_") for word in law.get(key) or ()} for key in ("stages", "variables")
        )
        right = {word for words in nature["variables"] for word in words}
        found = (
            bool(stages & set(nature["stages"])) and len(stages - set(nature["stages"])) <= 1,
            bool(law) and all(variables & set(words) for words in nature["variables"]) and len(variables - right) <= 1,
            law.get("memory") is not None and bool(law["memory"]) == nature["memory"],
            law.get("rate") is not None and bool(law["rate"]) == nature["rate"],
        )
        best = max(best, found, key=sum)
    return best


def _truth_class(level: str, effects: list[dict[str, Any]]) -> str:
    if level in CLEAN:
        return "none" if level == "L0" else "parameter"
    return "unknown" if level in OPEN else str(effects[0]["kind"])


def _told(level: str, said: Said, effects: list[dict[str, Any]], twins: set[str]) -> bool | None:
    """On a clean record refitted parameters are right; a bench fault is not of one class."""
    if twins or level not in ("L0", "LP", "L1", "L5", "L6"):
        return None
    true = _truth_class(level, effects)
    return said.kind == true or (true == "none" and said.kind == "parameter")


def _overlap(true: list[dict[str, Any]], said: list[dict[str, Any]]) -> float | None:
    """Overlap (intersection over union) of the answer's first place with the true window on the same axis.

    None where the truth has no window on that axis: such a place is neither right nor wrong.
    """
    if not said:
        return 0.0
    place, best = said[0], 0.0
    same = [window for window in true if window["axis"] == place.get("axis")]
    if same and all(window["value"] is None and window["low"] is None for window in same):
        return None
    for window in same:
        if window["value"] is not None:
            best = max(best, float(str(place.get("value")) == window["value"]))
        elif window["low"] is not None and place.get("low") is not None and place.get("high") is not None:
            low, high = float(place["low"]), float(place["high"])
            shared = max(0.0, min(high, window["high"]) - max(low, window["low"]))
            whole = max(high, window["high"]) - min(low, window["low"])
            best = max(best, shared / whole if whole > 0 else 1.0)
    return best


def _component(effect: dict[str, Any], diagnosis: dict[str, Any]) -> bool:
    """Whether the first effect named is in the right component, whatever its name."""
    named = [entry for entry in diagnosis["effects"] if entry.get("kind") != "parameter"] or diagnosis["effects"]
    words = {word.strip() for word in str(named[0].get("component", "")).split(",")}
    return bool(words & {word.strip() for word in str(effect["component"]).split(",")})


def _bench_right(said: Said, effect: dict[str, Any], diagnosis: dict[str, Any]) -> bool:
    """Whether a bench fault is named first and, where it is of one run, that run is given as its place."""
    if effect["law"] == "doubled_rows":
        # A fault of the file: the robot is as configured, and nothing is to be named.
        return not is_alarm(said)
    if said.kind not in ("physics", "sensor") or said.effects[:1] != [effect["id"]]:
        return False
    if effect.get("run") is None:
        return _component(effect, diagnosis)
    named = next(entry for entry in diagnosis["effects"] if entry["id"] == effect["id"])
    places = [str(place.get("value")) for place in diagnosis.get("where") or () if place.get("axis") == "run"]
    return effect["run"] in (places[:1] or [str(named.get("run"))])


def _confidence(diagnosis: dict[str, Any], effects: list[str]) -> float | None:
    for effect in diagnosis.get("effects") or []:
        if effects and effect["id"] == effects[0] and effect.get("confidence") is not None:
            return float(effect["confidence"])
    return None


def _beliefs(diagnosis: dict[str, Any], said: Said, true: list[str], level: str) -> tuple[tuple[float, bool], ...]:
    """Stated probabilities and whether they came true; `something_else` does where no name given is the truth.

    An answer without probabilities stands by the confidence of its first name.
    """
    stated = diagnosis.get("probabilities") or {}
    present = set() if level in OPEN else set(true)
    if not stated:
        level_of_trust = _confidence(diagnosis, said.effects)
        named = said.kind in ("physics", "sensor") and level_of_trust is not None
        return ((float(level_of_trust), said.effects[0] in present),) if named else ()  # type: ignore[arg-type]
    names = {name for name in stated if name != "something_else"}
    return tuple(
        (float(p), not (names & present) if name == "something_else" else name in present)
        for name, p in stated.items()
        if isinstance(p, (int, float))
    )


def _intervals(truth: dict[str, Any], diagnosis: dict[str, Any]) -> tuple[tuple[str, bool, float], ...]:
    """Whether each base parameter lies in its 90 % interval, and its bias in per cent, in every case.

    A recording fixes the modulus only together with the pulley friction, so it is compared as E exp(mu alpha).
    """
    reported = diagnosis.get("parameters") or {}
    if truth.get("kind") != "joint" or not reported:
        return ()
    true, configured = dict(truth["parameters"]), truth["configured"]
    entry = reported.get("pulley_friction")
    friction = float(entry["value"]) if isinstance(entry, dict) else configured["pulley_friction"]
    true["youngs_modulus_gpa"] *= math.exp((true["pulley_friction"] - friction) * configured["wrap_angle_rad"])
    # With one bending length the friction per notch is not fitted, and stiffness holds what it is off by.
    merged = not (reported.get("notch_friction") or {}).get("std")
    merged = merged and true["notch_friction"] != configured["notch_friction"]
    out = []
    for name in ("youngs_modulus_gpa", "notch_friction", "deadband_mm"):
        entry = None if merged and name == "youngs_modulus_gpa" else reported.get(name)
        if isinstance(entry, dict) and entry.get("std") and not entry.get("at_bound"):
            off = float(entry["value"]) - true[name]
            bias = 100 * off / true[name] if true[name] else 0.0
            out.append((name, abs(off) < 1.645 * float(entry["std"]), round(bias, 4)))
    return tuple(out)


def _after(second: dict[str, Any] | None, true: list[str]) -> str | None:
    """Return what was said once the proposed recording was added: right, wrong, undecided, or not asked."""
    if not second or not second.get("diagnosis"):
        return None
    said = Said.of(second["diagnosis"])
    if said.effects[:1] == true[:1]:
        return "right"
    return "wrong" if said.kind in ("physics", "sensor") and true[0] not in said.group else "undecided"
