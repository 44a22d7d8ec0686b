"""Stroke tables: every curvature (or stroke) with every bending length of one joint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from coast_cli.errors import NotConverged, UsageError
from coast_cli.mechanics.joint import Joint, StrokeSolution, curvature_from_stroke, stroke, tension, tip
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.verdict import Verdict
from coast_cli.units import MILLIMETRE

LARGEST_DRIVE = 1e5  # 1/m or m: a circle smaller than any tube, a tendon longer than any


def stroke_table(
    joint: Joint, bending_lengths: Sequence[float], *, curvatures: Sequence[float] = (), strokes: Sequence[float] = ()
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the columns of a stroke table and notes on where the model is stretched.

    Args:
        joint: one pair, or one tube. Without a tendon, stroke and strain have no value.
        bending_lengths: X2, m.
        curvatures: 1/m; or
        strokes: X1, m, each inverted to the curvature it reaches.

    Raises:
        UsageError: a value the joint cannot take.
        NotConverged: the inverse found no curvature.
    """
    _check(joint, bending_lengths, curvatures or strokes)
    length, drive = (grid.ravel() for grid in np.meshgrid(bending_lengths, curvatures or strokes, indexing="ij"))
    solution = _solve(joint, length, drive, inverse=bool(strokes))
    if not solution.verdict.converged:
        raise NotConverged(f"{solution.verdict.message}.")
    tip_x, tip_y = tip(solution.curvature, length)
    known = joint.tendon is not None
    columns: dict[str, Any] = {
        "outer": [joint.outer.name if joint.outer else None] * length.size,
        "middle": [joint.middle.name] * length.size,
        "curvature_per_m": solution.curvature,
        "bending_length_mm": length / MILLIMETRE,
        "stroke_mm": solution.stroke / MILLIMETRE if known else [None] * length.size,
        "tension_n": solution.tension,
        "tendon_strain": solution.tendon_strain if known else [None] * length.size,
        "tip_x_mm": tip_x / MILLIMETRE,
        "tip_y_mm": tip_y / MILLIMETRE,
    }
    return columns, _notes(joint, solution.curvature)


def _solve(joint: Joint, length: FloatArray, drive: FloatArray, *, inverse: bool) -> StrokeSolution:
    if inverse:
        return curvature_from_stroke(joint, drive, length)
    if joint.tendon is not None:
        return stroke(joint, drive, length)
    nothing = np.zeros_like(drive)
    return StrokeSolution(drive, nothing, tension(joint, drive, length), nothing, Verdict(converged=True))


def _check(joint: Joint, lengths: Sequence[float], drives: Sequence[float]) -> None:
    if min(drives) < 0.0 or max(drives) > LARGEST_DRIVE:
        raise UsageError(f"curvature and stroke: allowed: numbers from 0 to {LARGEST_DRIVE:g}.")
    longest = min(tube.length for tube in (joint.outer, joint.middle) if tube is not None)
    for length in lengths:
        if not 0.0 < length <= longest * (1.0 + 1e-12):
            allowed = f"above 0 and at most the notched length, {longest / MILLIMETRE:g}"
            raise UsageError(f"bending length {length / MILLIMETRE:g} mm: allowed: {allowed}.")


def _notes(joint: Joint, curvature: FloatArray) -> tuple[str, ...]:
    notes = []
    if joint.tendon is None:
        notes.append("there is no [tendon], so stroke and tendon strain have no value.")
    closing = joint.closure_curvature
    if float(curvature.max()) > closing:
        notes.append(f"above {closing:.4g} 1/m the faces of a notch touch, which the model leaves out.")
    return tuple(notes)
