"""What an effect owes before it takes part: it declares itself, its null changes nothing, and its whole range answers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import Any, get_args

import numpy as np

from coast_cli.effects import shape_stages, stages
from coast_cli.effects.effect import Effect, History, Kind, Need, Parameter, RecordingKind, Scale, Scope, declared
from coast_cli.effects.forward import Layout, predict
from coast_cli.mechanics.joint import Joint, Tendon
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube

_SCALES: dict[RecordingKind, tuple[str, ...]] = {
    "joint": tuple(scale for scale in get_args(Scale) if scale not in ("weight", "gradient")),
    "shapes": ("", "weight", "gradient"),
}
_METHODS: dict[type[Effect], tuple[str, ...]] = {
    stages.OnTubes: ("geometry", "joint"),
    stages.OnDrive: ("drive",),
    stages.OnStretch: ("stretch",),
    stages.OnSlack: ("slack",),
    stages.OnTransmission: ("friction", "notch_friction"),
    stages.OnStructure: ("moment",),
    stages.OnDrift: ("drift",),
    stages.OnDrag: ("drag",),
    stages.OnSettling: ("settle",),
    stages.OnSensor: ("sense",),
    stages.OnLoadCell: ("weigh",),
    shape_stages.OnPieces: ("pieces",),
    shape_stages.OnBench: ("loads",),
    shape_stages.OnImage: ("see",),
}
_ID = re.compile(r"(?!unnamed_)[a-z][a-z0-9]*(_[a-z0-9]+)*")
_WORDS = ("title", "component", "equation", "source", "decided_by")


def broken(kind: type[Effect]) -> str | None:
    """Return in a clause what of the contract an effect breaks, or None."""
    for check in (_undeclared, _stageless, _parameters, _unanswered):
        found = next(check(kind), None)
        if found is not None:
            return found
    return None


def _undeclared(kind: type[Effect]) -> Iterator[str]:
    if _ID.fullmatch(str(getattr(kind, "id", ""))) is None:
        yield "its id must be small letters, digits and single underscores, and not begin with unnamed_"
    for name in _WORDS:
        if not (isinstance(getattr(kind, name, None), str) and len(getattr(kind, name)) > 3):
            yield f"it says no {name}"
    for name, choices in (("kind", Kind), ("scope", Scope)):
        if getattr(kind, name) not in get_args(choices):
            yield f"its {name} is {getattr(kind, name)!r}; allowed: {', '.join(get_args(choices))}"
    if not getattr(kind.__dict__.get("__dataclass_params__"), "frozen", False):
        yield "it must be a frozen dataclass"
    if set(getattr(kind, "needs", ())) - set(get_args(Need)):
        yield f"it needs what no recording has; allowed: {', '.join(get_args(Need))}"


def _stageless(kind: type[Effect]) -> Iterator[str]:
    if not kind.recordings:
        yield "it acts at no stage, as OnStructure or OnBench"
    for stage, methods in _METHODS.items():
        if issubclass(kind, stage) and all(getattr(kind, name) is getattr(stage, name) for name in methods):
            yield f"it acts at {stage.__name__} and has no method {' or '.join(methods)}"


def _parameters(kind: type[Effect]) -> Iterator[str]:
    defaults = {field.name: field.default for field in fields(kind)}
    for recording in kind.recordings:
        owned = kind.parameters_on(recording) if hasattr(kind, "parameters") else ()
        if not owned or not all(isinstance(parameter, Parameter) for parameter in owned):
            yield "its parameters must be a tuple of one Parameter or more"
            return
        for p in owned:
            if p.name not in defaults:
                yield f"its parameter {p.name} is no field of the class"
            elif defaults[p.name] != p.null:
                yield f"{p.name} is {defaults[p.name]} by default and its null is {p.null:g}; they must agree"
            elif not p.low <= p.null <= p.high:
                yield f"the null of {p.name}, {p.null:g}, is not from {p.low:g} to {p.high:g}"
            elif not p.starts or not p.source:
                yield f"{p.name} must say from where fits start, and where its range comes from"
            elif p.relative_to not in _SCALES[recording]:
                allowed = ", ".join(filter(None, _SCALES[recording]))
                yield f"{p.name} is relative to {p.relative_to!r}; allowed on {recording}: {allowed}"


def _unanswered(kind: type[Effect]) -> Iterator[str]:
    """Yield where its null changes something, where it fails, or where an end of its range gives no finite number."""
    for recording in kind.recordings:
        answer = _of_joint if recording == "joint" else _of_shapes
        clean = answer(kind.null(), changed=False)
        found = _tried(answer, kind.null())
        if isinstance(found, str):
            yield found
        elif not np.array_equal(found, clean):
            yield "at its null it changes what is predicted"
        for parameter in declared(kind, recording).parameters:
            for end in (parameter.low, parameter.high):
                found = _tried(answer, kind.null().with_numbers({parameter.name: end}))
                if isinstance(found, str):
                    yield found
                elif found.shape != clean.shape or not np.all(np.isfinite(found)):
                    yield f"at {parameter.name} = {end:g} it gives what is no finite number"


def _tried(answer: Callable[..., FloatArray], effect: Effect) -> FloatArray | str:
    try:
        with np.errstate(all="ignore"):
            return np.asarray(answer(effect, changed=True), dtype=np.float64)
    except Exception as error:  # noqa: BLE001 -- whatever a user's own code raises is said in a sentence
        return f"it fails where it acts: {type(error).__name__}: {error}"


def _tube(outer: float, inner: float, depth: float) -> NotchedTube:
    cut = np.full(60, 3e-4)
    return NotchedTube("tube", outer, inner, np.full(60, depth), cut, cut, 45e9, 6450.0, 3.0)


def _of_joint(effect: Effect, *, changed: bool) -> FloatArray:
    """Return response and tension of a small joint that is pulled, held and released twice."""
    joint = Joint(
        _tube(2.5e-4, 2e-4, 4e-4),
        _tube(1.8e-4, 1.4e-4, 2.43e-4),
        Tendon(3.8e-5, 54e9, 0.39),
        42e9,
        0.3,
        np.pi,
        1.006,
        1e-3,
    )
    up = np.linspace(0.0, 3e-3, 30)
    stroke = np.concatenate([up, up[::-1]])
    time, load = np.linspace(0.0, 30.0, stroke.size), np.linspace(0.0, 1.0, stroke.size)
    runs = [
        History(time, stroke, None, np.full(stroke.size, x2), run=n, load=load) for n, x2 in enumerate((0.02, 0.03))
    ]
    with_it = [effect] if changed else []
    seen = predict(joint, with_it, runs, Layout("curvature", 1, 120.0))
    return np.concatenate([part for one in seen for part in (one.response[:, 0], one.tension)])


def _of_shapes(effect: Effect, *, changed: bool) -> FloatArray:
    """Return what a photographed tube has, stage by stage, as one row of numbers."""
    tube = _tube(2.5e-4, 2e-4, 4e-4)
    if changed and isinstance(effect, stages.OnTubes):
        tube = effect.geometry(tube)
    cut = tube.segments
    pieces = shape_stages.Pieces(cut.length, cut.rigidity, cut.weight, np.zeros(120), np.zeros(120), np.ones(120))
    if changed and isinstance(effect, shape_stages.OnPieces):
        pieces = effect.pieces(pieces)
    loads = shape_stages.Loads()
    if changed and isinstance(effect, shape_stages.OnBench):
        loads = effect.loads(loads)
    x, y = np.linspace(0.0, 0.03, 20), np.linspace(0.0, 0.01, 20)
    if changed and isinstance(effect, shape_stages.OnImage):
        x, y = effect.see(x, y, (0.015, 0.005))
    return np.concatenate([*map(_numbers, (pieces, loads)), x, y])


def _numbers(part: Any) -> FloatArray:  # noqa: ANN401 -- pieces or loads, all of numbers
    return np.concatenate([np.atleast_1d(getattr(part, field.name)) for field in fields(part)])
