"""A diagnosis as JSON, schema ``coast.diagnosis/1``; a number that could not be determined is null, never NaN."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from typing import IO, TYPE_CHECKING, Any

from coast_cli.output.diagnosis_words import axis_unit

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Carried, Diagnosis, Level, Named, SideBySide, Value
    from coast_cli.diagnosis.locate import Region
    from coast_cli.diagnosis.unnamed.forms import Curve
    from coast_cli.diagnosis.unnamed.words import Description
    from coast_cli.output.diagnosis import DiagnosisAnswer


def render(answer: DiagnosisAnswer, stream: IO[str]) -> None:
    """Write the diagnosis as JSON."""
    stream.write(json.dumps(document(answer), indent=2, allow_nan=False, ensure_ascii=False))
    stream.write("\n")


def document(answer: DiagnosisAnswer) -> dict[str, Any]:
    """Return the diagnosis as plain tables and lists."""
    notes = [*answer.diagnosis.notes, *answer.notes]
    return {
        "schema": "coast.diagnosis/1",
        **_answers(answer.diagnosis, answer.drive_unit, notes),
        "provenance": dict(answer.provenance),
    }


def _answers(found: Diagnosis, drive_unit: str, notes: list[str]) -> dict[str, Any]:
    return {
        "verdict": found.verdict,
        "reason": found.reason,
        "noise": {"unit": found.noise_unit, "value": number(found.noise)},
        "where": [_region(region, drive_unit) for region in found.where],
        "effects": [_effect(effect) for effect in found.effects],
        "alternatives": [list(ids) for ids in found.alternatives],
        "attempts": list(found.attempts),
        "parameters": {
            name: {**_value(value), "configured": number(found.configured.get(name))}
            for name, value in found.parameters.items()
        },
        "fit": None if found.comparison is None else _fit(found.comparison),
        "next_recording": found.next_recording,
        "probabilities": {name: number(round(value, 4)) for name, value in found.probabilities.items()},
        "tests": [{"name": one.name, "p": number(one.p), "passed": one.passed} for one in found.tests],
        "evidence": {name: number(value) for name, value in found.evidence.items()},
        "unnamed": None if found.unnamed is None else _unnamed(found.unnamed),
        "notes": notes,
        **({} if found.carried is None else _carried(found.carried)),
    }


def _carried(carried: Carried) -> dict[str, Any]:
    def levels(pair: tuple[Level, Level] | None) -> dict[str, Any] | None:
        if pair is None:
            return None
        names = zip(("configured", "refitted"), pair, strict=True)
        return {name: {"train": number(level.train), "held_out": number(level.held_out)} for name, level in names}

    return {
        "shapes": _answers(carried.shapes, "mm", list(carried.shapes.notes)),
        "shared": [
            {
                "name": one.name,
                "shapes": _value(one.shapes),
                "joint": None if one.joint is None else _value(one.joint),
                "together": None if one.together is None else _value(one.together),
                "agree": one.agree,
            }
            for one in carried.shared
        ],
        "carried_over": {
            "used": carried.config is not None,
            "without": levels(carried.without),
            "with": levels(carried.with_it),
        },
    }


def _unnamed(law: Description) -> dict[str, Any]:
    return {
        "stages": list(law.stages),
        "variables": list(law.variables),
        "memory": law.memory,
        "rate": law.rate,
        "dissipative": law.dissipative,
        "equation": law.equation,
        "words": law.words,
        "parameters": {name: number(value) for name, value in law.parameters.items()},
        "nearest": [{"id": identifier, "left_over": number(left)} for identifier, left in law.nearest],
        "laws": [one.table() for one in law.laws],
        "curve": _curve(law.curves[0]),
        "curves": [_curve(curve) for curve in law.curves],
        "dissipated_uj": number(law.energy_uj),
        "not_held": list(law.open),
    }


def _curve(curve: Curve) -> dict[str, Any]:
    return {
        "axis": curve.axis,
        "unit": curve.unit,
        "x": [number(value) for value in curve.x],
        "y": [number(value) for value in curve.y],
        "low_90": [number(value) for value in curve.low],
        "high_90": [number(value) for value in curve.high],
    }


def number(value: float | None) -> float | None:
    """Return a finite number, or None."""
    return float(value) if value is not None and isfinite(value) else None


def _region(region: Region, drive_unit: str) -> dict[str, Any]:
    return {
        "axis": region.axis,
        "value": region.value,
        "low": number(region.low),
        "high": number(region.high),
        "unit": axis_unit(region, drive_unit) or None,
        "share": number(region.share),
        "p_value": number(region.p_value),
    }


def _effect(effect: Named) -> dict[str, Any]:
    return {
        "id": effect.id,
        "kind": effect.kind,
        "component": effect.component,
        "title": effect.title,
        "equation": effect.equation,
        "confidence": number(effect.confidence),
        "parameters": {name: _value(value) for name, value in effect.parameters.items()},
    }


def _value(value: Value) -> dict[str, Any]:
    return {"value": number(value.value), "std": number(value.std), "at_bound": bool(value.at_bound)}


def _fit(fit: SideBySide) -> dict[str, Any]:
    levels: Mapping[str, Level] = {
        "configured": fit.configured,
        "refitted": fit.refitted,
        "with_effects": fit.with_effects,
    }
    return {
        "unit": fit.unit,
        "held_out_runs": list(fit.held_out_runs),
        "rule": fit.rule,
        **{name: {"train": number(level.train), "held_out": number(level.held_out)} for name, level in levels.items()},
        "tip_mm": {"refitted": number(fit.tip_mm_refitted), "with_effects": number(fit.tip_mm_with_effects)},
    }
