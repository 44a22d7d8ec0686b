"""Stroke tables: every curvature (or stroke) with every bending length of one joint."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from coast_cli.design.bands import WIDTH_90, Alternative
from coast_cli.design.loading import acting_on_load, corrected_stroke
from coast_cli.design.memory import STROKE_ROW, require_memory
from coast_cli.design.reach import PLATEAU_STRAIN, Pulled, bent_webs, softens, tendon_limits, web_limits
from coast_cli.design.released import released_stroke
from coast_cli.effects.effect import Effect
from coast_cli.effects.seen import outside_at
from coast_cli.errors import NotConverged, UsageError
from coast_cli.mechanics.joint import Joint, StrokeSolution, curvature_from_stroke, segment_tip, stroke, tension
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.verdict import Verdict
from coast_cli.rows import Drawn, Rows, rows_of
from coast_cli.spec.config import Checks
from coast_cli.units import MILLIMETRE

Way = Literal["load", "release", "inverse"]
_HARDLY_BENT = 0.5  # 1/m
LARGEST_DRIVE = 1e5  # 1/m or m: a circle smaller than any tube, a tendon longer than any


@dataclass(frozen=True, eq=False, repr=False)
class StrokeTable(Rows, Drawn):
    """Columns by name, as `coast stroke` prints them, units in their names, and notes on where the model is stretched."""

    columns: Mapping[str, Any]
    notes: tuple[str, ...]

    def _table(self) -> list[dict[str, Any]]:
        return rows_of(self.columns)


def stroke_table(
    joint: Joint,
    bending_lengths: Sequence[float],
    *,
    curvatures: Sequence[float] = (),
    strokes: Sequence[float] = (),
    effects: Sequence[Effect] = (),
    checks: Checks | None = None,
    alternatives: Sequence[Alternative] = (),
    steps_per_mm: float | None = None,
    release: bool = False,
) -> StrokeTable:
    """Return every curvature (or stroke) with every bending length, the length slowest.

    Args:
        joint: one pair, or one tube. Without a tendon, stroke and strain have no value.
        bending_lengths: X2, m.
        curvatures: 1/m; or
        strokes: X1, m, each inverted to the curvature it reaches.
        effects: corrections of the joint; strokes are then those of the corrected model's loading branch.
        checks: whose limits on stroke, tendon and webs are noted where a row passes them.
        alternatives: what may be otherwise of the joint; it gives 90 % bands of what is answered.
        steps_per_mm: of the actuator's motor.
        release: whether curvatures are held on the way back from the largest of them.

    Raises:
        UsageError: a value or a release branch that the joint does not have, or more rows than there is memory for.
        NotConverged: the inverse found no curvature.

    Example:
        >>> joint = coast.build(coast.load_config(coast.REFERENCE)).joint()
        >>> table = coast.stroke_table(joint, [20e-3, 30e-3], curvatures=[20.0])
        >>> [round(float(value), 3) for value in table.columns["stroke_mm"]]
        [2.6, 2.79]
    """
    _check(joint, bending_lengths, curvatures or strokes)
    require_memory(len(bending_lengths) * len(curvatures or strokes), STROKE_ROW * (1 + len(alternatives)), "strokes")
    length, drive = (grid.ravel() for grid in np.meshgrid(bending_lengths, curvatures or strokes, indexing="ij"))
    acting, left_out = acting_on_load(effects)
    if release and strokes:
        raise UsageError("branch release: strokes are inverted on the loading branch only; give curvatures.")
    way: Way = "inverse" if strokes else "release" if release else "load"
    solution = _solve(joint, acting, length, drive, way)
    tip_x, tip_y = segment_tip(joint, solution.curvature, length)
    known = joint.tendon is not None
    columns: dict[str, Any] = {
        "outer": [joint.outer.name if joint.outer else None] * length.size,
        "middle": [joint.middle.name] * length.size,
        "curvature_per_m": solution.curvature,
        "bending_length_mm": length / MILLIMETRE,
        "stroke_mm": _known(solution.stroke / MILLIMETRE) if known else [None] * length.size,
        "tension_n": _known(solution.tension),
        "tendon_strain": _known(solution.tendon_strain) if known else [None] * length.size,
        "tip_x_mm": tip_x / MILLIMETRE,
        "tip_y_mm": tip_y / MILLIMETRE,
        "stroke_steps": _steps(solution, steps_per_mm),
        **_bands(solution, alternatives, length, drive, way),
    }
    if min(bending_lengths) < joint.pitch:
        left_out = (*left_out, f"a bending length is below one pitch, {joint.pitch / MILLIMETRE:g} mm: is it in mm?")
    bent = [value for value in curvatures if value > 0.0]
    if bent and max(bent) < _HARDLY_BENT:
        left_out = (*left_out, f"every curvature is below {_HARDLY_BENT:g} 1/m, a radius of metres: is it in 1/m?")
    ids = {effect.id for effect in acting}
    beyond = outside_at(
        acting,
        curvature=solution.curvature,
        stroke=solution.stroke if known else None,
        tension=solution.tension,
        bending_length=length,
    )
    notes = (*left_out, *beyond, *_notes(joint, solution), *_passed(joint, solution, length, checks, ids))
    return StrokeTable(columns, notes)


def _solve(joint: Joint, acting: Sequence[Effect], length: FloatArray, drive: FloatArray, way: Way) -> StrokeSolution:
    if way == "release":
        return released_stroke(joint, acting, length, drive)
    if acting:
        solution = corrected_stroke(joint, acting, length, drive, inverse=way == "inverse")
    elif way == "inverse":
        solution = curvature_from_stroke(joint, drive, length)
    elif joint.tendon is not None:
        return stroke(joint, drive, length)
    else:
        nothing = np.zeros_like(drive)
        return StrokeSolution(drive, nothing, tension(joint, drive, length), nothing, Verdict(converged=True))
    if not solution.verdict.converged:
        raise NotConverged(f"{solution.verdict.message}.")
    return solution


def _steps(solution: StrokeSolution, steps_per_mm: float | None) -> list[int | None]:
    """Return the motor's steps from zero for each stroke; no value where either is not known."""
    if steps_per_mm is None:
        return [None] * solution.stroke.size
    return [
        None if np.isnan(value) else round(value * steps_per_mm) for value in (solution.stroke / MILLIMETRE).tolist()
    ]


def _bands(
    solution: StrokeSolution,
    alternatives: Sequence[Alternative],
    length: FloatArray,
    drive: FloatArray,
    way: Way,
) -> dict[str, Sequence[float | None]]:
    """Return the ends of the 90 % bands of strokes, or of inverted ones of curvatures; no values without alternatives."""
    names = ("stroke_low_mm", "stroke_high_mm", "curvature_low_per_m", "curvature_high_per_m")
    columns: dict[str, Sequence[float | None]] = {name: [None] * length.size for name in names}
    if not alternatives:
        return columns
    middle, (low, high) = (
        (solution.curvature, names[2:]) if way == "inverse" else (solution.stroke / MILLIMETRE, names[:2])
    )
    variance = np.zeros(length.size)
    for one in alternatives:
        below, above = (
            _solve(joint, acting_on_load(effects)[0], length, drive, way) for joint, effects in (one.below, one.above)
        )
        change = above.curvature - below.curvature if way == "inverse" else (above.stroke - below.stroke) / MILLIMETRE
        variance += (change / 2.0) ** 2
    half = WIDTH_90 * np.sqrt(variance)
    columns[low], columns[high] = _known(np.maximum(middle - half, 0.0)), _known(middle + half)
    return columns


def _check(joint: Joint, lengths: Sequence[float], drives: Sequence[float]) -> None:
    if min(drives) < 0.0 or max(drives) > LARGEST_DRIVE:
        raise UsageError(f"curvature and stroke: allowed: numbers from 0 to {LARGEST_DRIVE:g}.")
    longest = min(tube.length for tube in (joint.outer, joint.middle) if tube is not None)
    for length in lengths:
        if not 0.0 < length <= longest * (1.0 + 1e-12):
            allowed = f"above 0 and at most the notched length, {longest / MILLIMETRE:g}"
            raise UsageError(f"bending length {length / MILLIMETRE:g} mm: allowed: {allowed}.")


def _known(values: FloatArray) -> Sequence[float | None]:
    """Return the values, None where no stroke holds the curvature."""
    if not np.isnan(values).any():
        known: Sequence[float | None] = values  # type: ignore[assignment]
        return known
    return [None if np.isnan(value) else float(value) for value in values]


def _notes(joint: Joint, solution: StrokeSolution) -> tuple[str, ...]:
    notes = []
    unheld = np.unique(solution.curvature[np.isnan(solution.tension)])
    if unheld.size:
        words = f"{unheld[0]:.4g}" if unheld.size == 1 else f"{unheld[0]:.4g} to {unheld[-1]:.4g}"
        notes.append(
            f"no pull holds some curvatures asked for ({words} 1/m): bent further at rest, or snapping across."
        )
    if joint.tendon is None:
        notes.append("there is no [tendon], so stroke and tendon strain have no value.")
    return tuple(notes)


def _passed(
    joint: Joint, solution: StrokeSolution, length: FloatArray, checks: Checks | None, acting: Collection[str]
) -> tuple[str, ...]:
    """Return a note for each known limit that a row passes, with the least bend that does."""
    bend = solution.curvature * length
    unknown = np.full_like(bend, np.nan)
    pulled = Pulled(solution.stroke, solution.tendon_strain, solution.tension)
    if joint.tendon is None:
        pulled = Pulled(unknown, unknown, solution.tension)
    bent, closes = bent_webs(joint, solution.curvature, length), "notch_closure" in acting
    passed = [one for webs, curvature in bent for one in web_limits(curvature, webs, checks, closes=closes)]
    passed += tendon_limits(pulled, checks)
    strain = np.max([webs.strain(curvature) for webs, curvature in bent], axis=0)
    if not softens(joint, acting):
        words = f"web strain {float(strain.max()):.3g} above {PLATEAU_STRAIN:g}: nitinol softens, which the model leaves out"
        passed.append((strain > PLATEAU_STRAIN, words))
    notes = []
    for mask, words in passed:
        if mask.any():
            row = int(np.argmin(np.where(mask, bend, np.inf)))
            at = f"from {solution.curvature[row]:.4g} 1/m over {length[row] / MILLIMETRE:g} mm"
            notes.append(f"past a limit {at}: {words}.")
    return tuple(notes)
