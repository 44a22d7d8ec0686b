"""What an answer is worth: the rules of scoring, the same for every answer.

+1 right name, +0.5 named second or a twin named, +0.25 an honest "cannot tell", -1 blind (a mismatch above two noise
widths is called agreement), -2 a wrong name or a false alarm. Where no name can be right: +1 "unexplained" or a law whose
stage, variable, memory and rate are all right, +0.5 with the stage right, -1 a law that predicts unseen rows no better
than the base model does. No name is forgiven for being near.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

CLEAN = ("L0", "LP")
# Levels at which no name of the catalogue is right.
OPEN = ("L6", "L8")
# A group of more names than this tells nothing.
GROUP = 4
NOISE_WIDTHS_OF_BLINDNESS = 2.0
# A law helps if it takes away a third of the base model's error on unseen rows.
HELPS = 2 / 3

VERDICTS = {
    "agrees": "none",
    "parameters": "parameter",
    "physics": "physics",
    "sensor": "sensor",
    "unexplained": "unknown",
    "unnamed": "unknown",
    "ambiguous": "undecided",
    "insufficient": "undecided",
}


@dataclass(frozen=True)
class Said:
    """An answer in short: its class, names in order, names without parameters, every name of its groups, a law given."""

    kind: str
    named: list[str]
    effects: list[str]
    group: list[str]
    law: bool

    @classmethod
    def of(cls, diagnosis: dict[str, Any]) -> Said:
        """Return what an answer's JSON says."""
        entries = diagnosis.get("effects") or []
        named = [str(effect["id"]) for effect in entries]
        group = [
            str(name)
            for entry in diagnosis.get("alternatives") or []
            for name in ([entry] if isinstance(entry, str) else entry)
        ]
        effects = [str(effect["id"]) for effect in entries if effect.get("kind") != "parameter"] or named
        return cls(
            VERDICTS.get(str(diagnosis.get("verdict")), "failed"), named, effects, group, bool(diagnosis.get("unnamed"))
        )


def is_alarm(said: Said) -> bool:
    """On a clean record: anything but agreement, refitted parameters, or a "cannot decide" that names nothing."""
    return said.kind in ("physics", "sensor", "unknown", "failed") or (said.kind == "undecided" and bool(said.effects))


def points(
    said: Said, truth: dict[str, Any], facts: tuple[bool, bool, bool, bool] | None, figures: dict[str, float]
) -> float:
    """Return the score of one case."""
    level, effects = truth["level"], truth["effects"]
    if level in CLEAN or (effects and effects[0].get("law") == "doubled_rows"):
        return _clean(level, said)
    if said.kind == "failed":
        return 0.0
    if level in OPEN:
        return _open(said, truth, facts, figures)
    true, twins = [str(effect["id"]) for effect in effects], set(truth.get("twins", ()))
    if said.kind == "unknown":
        return 0.25
    if said.kind == "undecided":
        offered = {*said.effects, *said.group}
        known = offered & {*true, *twins}
        return -2.0 if offered and not known else 0.0 if len(offered) > GROUP else 0.25
    # What is cut into a tube is a parameter of it, and named as one.
    if said.effects[:1] == true[:1] and said.kind != "none":
        return 1.0
    if said.kind in ("none", "parameter"):
        return _missed(truth, twins)
    return 0.5 if true[0] in said.effects[1:2] or (said.effects and said.effects[0] in {*true, *twins}) else -2.0


def _clean(level: str, said: Said) -> float:
    if is_alarm(said):
        return -2.0
    if said.kind == "undecided":
        return 0.25
    return 1.0 if level != "LP" or said.kind == "parameter" else 0.0


def _missed(truth: dict[str, Any], twins: set[str]) -> float:
    """Nothing seen: right where a camera's scale is the stiffness that it is to this recording, honest below the noise."""
    size = max(float(effect["noise_widths"]) for effect in truth["effects"])
    if "youngs_modulus" in twins:
        return 1.0
    return 0.25 if size < 1.0 else 0.0 if size < NOISE_WIDTHS_OF_BLINDNESS else -1.0


def _open(
    said: Said, truth: dict[str, Any], facts: tuple[bool, bool, bool, bool] | None, figures: dict[str, float]
) -> float:
    """Return the score where no name can be right."""
    if said.kind in ("physics", "sensor"):
        return -2.0
    if said.kind in ("none", "parameter"):
        return _missed(truth, set())
    if said.law:
        if not helps(truth, figures):
            return -1.0
        if facts is None:
            return 0.5
        return 1.0 if all(facts) else 0.5 if facts[0] else 0.0
    if said.kind == "unknown":
        return 1.0
    return -2.0 if {*said.effects, *said.group} else 0.25


def helps(truth: dict[str, Any], figures: dict[str, float]) -> bool:
    """Whether the model given predicts unseen rows better than the base model; true where that was not measured."""
    base, mine = truth.get("base_held_out"), figures.get("noiseless")
    if base is None or mine is None:
        return True
    return mine < max(HELPS * float(base), float(truth["noise"]["sigma"]))


def blind(said: Said, truth: dict[str, Any], figures: dict[str, float]) -> bool | None:
    """Whether agreement was said of an error above two noise widths on unseen rows; None where that was not measured."""
    if "recorded" not in figures:
        return None
    worst = figures["recorded"] / float(truth["noise"]["sigma"])
    return said.kind in ("none", "parameter") and worst > NOISE_WIDTHS_OF_BLINDNESS
