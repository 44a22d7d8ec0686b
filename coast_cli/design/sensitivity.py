"""Exact derivatives of what a design answers with respect to every input, by complex steps through the mechanics.

A figure f of an input p has f(p + i h) = f(p) + i h f'(p) + O(h^2); with h of 1e-30 nothing is lost, so the derivative
has the digits of the figure itself (Squire and Trapp, SIAM Review 40, 1998). Inputs whose logarithmic derivatives are
proportional in every stroke enter as one product only, which no recording of strokes can take apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from coast_cli.errors import NotConverged
from coast_cli.mechanics.beam import BeamSolution, solve_beam
from coast_cli.mechanics.beam.tangent import complex_shape
from coast_cli.mechanics.joint import Joint, stroke
from coast_cli.mechanics.pairs import integrated
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.spec.build import Design
from coast_cli.units import GIGAPASCAL, MICROMETRE, MILLIMETRE

Row = dict[str, str | float | None]

_STEP = 1e-30
_PROPORTIONAL, _NOTHING = 1e-9, 1e-13  # relative
# Where the strokes are taken: curvature (1/m) and bending length (m).
_CURVATURE, _BENDING_LENGTH = 40.0, 40e-3


@dataclass(frozen=True, slots=True)
class SensitivityInput:
    """An input: its field, the unit its change is counted in, and that unit in SI; 0 means per cent of the value."""

    name: str
    field: str
    unit: str
    size: float

    def step(self, value: Any) -> Any:  # noqa: ANN401
        """Return one unit of change in SI."""
        return self.size or 0.01 * value


TUBE_INPUTS = (
    SensitivityInput("outer_diameter", "outer_radius", "um", 0.5 * MICROMETRE),
    SensitivityInput("inner_diameter", "inner_radius", "um", 0.5 * MICROMETRE),
    SensitivityInput("depth", "depth", "um", MICROMETRE),
    SensitivityInput("cut", "cut", "um", MICROMETRE),
    SensitivityInput("uncut", "uncut", "um", MICROMETRE),
    SensitivityInput("youngs_modulus", "youngs_modulus", "GPa", GIGAPASCAL),
    SensitivityInput("density", "density", "%", 0.0),
    SensitivityInput("natural_curvature", "natural_curvature", "1/m", 1.0),
)
JOINT_INPUTS = (
    SensitivityInput("youngs_modulus", "youngs_modulus", "GPa", GIGAPASCAL),
    SensitivityInput("pulley_friction", "pulley_friction", "%", 0.0),
    SensitivityInput("wrap_angle", "wrap_angle", "%", 0.0),
    SensitivityInput("notch_friction", "notch_friction", "%", 0.0),
    SensitivityInput("deadband", "deadband", "um", MICROMETRE),
)
TENDON_INPUTS = (
    SensitivityInput("radius", "radius", "um", MICROMETRE),
    SensitivityInput("youngs_modulus", "youngs_modulus", "GPa", GIGAPASCAL),
    SensitivityInput("length", "length", "mm", MILLIMETRE),
)
_PATTERN = ("cut", "uncut")


def sensitivity_rows(design: Design) -> tuple[list[Row], tuple[str, ...]]:
    """Return one row for each figure and input that moves it, and what the inputs' products leave open, in words.

    Of a ``design`` from ``build``; units are in the names.

    Figures: the tip of each tube under gravity; total pre-curvature, rigidity ratios and total rigidities of the
    joint's pair; and the stroke at 40/m and 40 mm (or the tube's length).

    Raises:
        NotConverged: a beam was not solved.

    Example:
        >>> rows, notes = coast.sensitivity_rows(coast.build(coast.load_config(coast.REFERENCE)))
        >>> sorted({row["figure"] for row in rows})[:2]
        ['ratio_mean', 'ratio_series']
    """
    gravity = design.gravity
    solved = {tube.name: _solved(tube, gravity) for tube in (*design.outer, *design.middle)}
    rows = [row for tube in (*design.outer, *design.middle) for row in _tip_rows(tube, gravity, solved[tube.name])]
    notes = [
        "each tip depends on modulus, density and gravity only through density * gravity / modulus.",
        "natural curvature counts positive against gravity.",
    ]
    if design.joint_pair is not None and "/" in design.joint_pair:
        outer, middle = (design.tube(name) for name in design.joint_pair.split("/"))
        rows += _pair_rows((outer, middle), gravity, (solved[outer.name], solved[middle.name]))
        notes.append(
            "a pair's pre-curvature and total rigidity have no derivative by one tube's cut or uncut: where the notch "
            "edges of both tubes coincide it differs from side to side."
        )
    if design.joint_pair is not None and design.config.joint is not None:
        joint = design.joint()
        if joint.softening.parts:
            notes.append("strokes are derived below the stress plateau of [materials.NAME.superelastic].")
            joint = joint.elastic
        if joint.tendon is not None:
            rows += _stroke_rows(joint)
            notes += _products(joint)
    return rows, tuple(notes)


def tip_derivative(tube: NotchedTube, gravity: float, field: str, solution: BeamSolution | None = None) -> FloatArray:
    """Return d(x, y)/d(field) of a tube's tip, m per SI unit; every notch changes alike where the field has one each."""
    base = solution or _solved(tube, gravity)
    shape = complex_shape(_stepped(tube, field, 1.0), gravity, base)
    return np.array([shape.x.imag, shape.y.imag]) / _STEP


def _stepped(thing: Any, field: str, size: Any) -> Any:  # noqa: ANN401
    """Return the tube, joint or tendon with a complex step of ``size`` in one field."""
    return replace(thing, **{field: getattr(thing, field) + 1j * _STEP * size})


def _solved(tube: NotchedTube, gravity: float) -> BeamSolution:
    solution = solve_beam(tube, gravity)
    if not solution.verdict.converged:
        raise NotConverged(f"{tube.name}: {solution.verdict.message}.")
    return solution


def _row(
    subject: str, figure: str, unit: str, value: float | None, of: str, by: SensitivityInput, change: float
) -> Row:
    return {
        "subject": subject,
        "figure": figure,
        "value": value,
        "unit": unit,
        "input_of": of,
        "input": by.name,
        "per": by.unit,
        "change": change,
        "change_percent": 100.0 * change / abs(value) if value else None,
    }


def _tip_rows(tube: NotchedTube, gravity: float, solution: BeamSolution) -> Iterator[Row]:
    values = (float(solution.x[-1]) / MILLIMETRE, float(solution.y[-1]) / MILLIMETRE)
    for by in TUBE_INPUTS:
        per_unit = by.step(getattr(tube, by.field)) / MILLIMETRE
        change = tip_derivative(tube, gravity, by.field, solution) * per_unit
        for name, value, moved in zip(("tip_x", "tip_y"), values, change.tolist(), strict=True):
            yield _row(tube.name, name, "mm", value, tube.name, by, moved)
        yield _row(tube.name, "tip_shift", "mm", None, tube.name, by, float(np.hypot(*change)))


def _pair_rows(
    tubes: tuple[NotchedTube, NotchedTube], gravity: float, solved: tuple[BeamSolution, BeamSolution]
) -> Iterator[Row]:
    subject = "/".join(tube.name for tube in tubes)
    for index, tube in enumerate(tubes):
        for by in TUBE_INPUTS:
            stepped = _stepped(tube, by.field, by.step(getattr(tube, by.field)))
            both = (stepped, tubes[1]) if index == 0 else (tubes[0], stepped)
            for name, unit, value in _pair_figures(both, gravity, solved, pattern=by.field not in _PATTERN):
                change = float(np.imag(value)) / _STEP
                if change != 0.0:
                    yield _row(subject, name, unit, float(np.real(value)), tube.name, by, change)


def _pair_figures(
    tubes: tuple[NotchedTube, NotchedTube], gravity: float, solved: tuple[BeamSolution, BeamSolution], *, pattern: bool
) -> Iterator[tuple[str, str, complex]]:
    outer, middle = tubes
    yield "ratio_mean", "1", outer.rigidity_mean / middle.rigidity_mean
    yield "ratio_series", "1", outer.rigidity_series / middle.rigidity_series
    if pattern:
        one, two = (complex_shape(tube, gravity, base).angle for tube, base in zip(tubes, solved, strict=True))
        sums = integrated(outer, middle, (one, two))
        for name, unit in (("total_precurvature", "rad"), ("total_mean", "N m^2"), ("total_series", "N m^2")):
            yield name, unit, sums[name]


def _stroke_rows(joint: Joint) -> Iterator[Row]:
    length = min(_BENDING_LENGTH, joint.middle.length)
    for of, by, stepped in _stepped_joints(joint):
        value = stroke(stepped, _CURVATURE, length).stroke / MILLIMETRE
        change = float(np.imag(value)) / _STEP
        if abs(change) > _NOTHING * abs(value):
            yield _row(_pair_name(joint), "stroke", "mm", float(np.real(value)), of, by, change)


def _stepped_joints(joint: Joint) -> Iterator[tuple[str, SensitivityInput, Joint]]:
    for by in JOINT_INPUTS:
        yield "joint", by, _stepped(joint, by.field, by.step(getattr(joint, by.field)))
    for by in TENDON_INPUTS:
        stepped = _stepped(joint.tendon, by.field, by.step(getattr(joint.tendon, by.field)))
        yield "tendon", by, replace(joint, tendon=stepped)
    for role, tube in (("outer", joint.outer), ("middle", joint.middle)):
        if tube is not None:
            for by in TUBE_INPUTS:
                stepped = _stepped(tube, by.field, by.step(getattr(tube, by.field)))
                yield tube.name, by, replace(joint, **{role: stepped})


def _pair_name(joint: Joint) -> str:
    return "/".join(tube.name for tube in (joint.outer, joint.middle) if tube is not None)


def _products(joint: Joint) -> Iterator[str]:
    """Say which inputs move every stroke alike, over all curvatures and bending lengths."""
    curvature, length = np.meshgrid(np.linspace(2.0, 40.0, 7), np.linspace(0.2, 1.0, 5) * joint.middle.length)
    moves: dict[str, FloatArray] = {}
    for of, by, stepped in _stepped_joints(joint):
        change = np.imag(stroke(stepped, curvature, length).stroke).ravel()
        if np.max(np.abs(change)) > _NOTHING * _STEP * MILLIMETRE:
            moves[f"{of}.{by.name}"] = change / np.linalg.norm(change)
    while moves:
        first, shape = moves.popitem()
        across = {name: np.linalg.norm(other - shape * (other @ shape)) for name, other in moves.items()}
        alike = [name for name, distance in across.items() if distance < _PROPORTIONAL]
        if alike:
            names = ", ".join([*alike, first])
            yield f"strokes alone can only find one combination of {names}: each moves every stroke alike."
        for name in alike:
            del moves[name]
