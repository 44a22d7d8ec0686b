"""The shape of tubes under gravity as columns of points, at the ends of their pieces or evenly spaced."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.memory import BEAM_POINT, require_memory
from coast_cli.errors import NotConverged
from coast_cli.mechanics.beam import BeamSolution, solve_segments
from coast_cli.mechanics.bending_law import StripLaws
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.units import DEGREE, MILLIMETRE

_MOST_SECANTS, _SETTLED = 120, 1e-9
Shape = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]  # s, x, y (m), angle (rad), curvature (1/m)


def shape_columns(
    tubes: Sequence[NotchedTube], gravity: float, *, method: Literal["arc", "projected"], points: int | None = None
) -> dict[str, Any]:
    """Return the columns of the shapes of several tubes, one after the other.

    Args:
        tubes: clamped along +x. gravity: along -y, m/s^2.
        method: "arc" for any angle, "projected" for the paper's own, which ends at 90 degrees.
        points: evenly spaced in arc length; None for the ends of each constant piece.

    The curvature is that just before a point (at the clamp, just after): it jumps where a notch begins and ends.

    Superelastic tubes soften past their plateau, each cut by the secant at its own moment; "projected" leaves that out.

    Raises:
        UsageError: more points than there is memory for.
        NotConverged: a shape was not found; the message says what to change.
    """
    require_memory(len(tubes) * (points or 0), BEAM_POINT, "points")
    shapes = [_shape(tube, gravity, method, points) for tube in tubes]
    return {
        "tube": [tube.name for tube, (s, *_) in zip(tubes, shapes, strict=True) for _ in s],
        "arc_length_mm": np.concatenate([s for s, *_ in shapes]) / MILLIMETRE,
        "x_mm": np.concatenate([x for _, x, *_ in shapes]) / MILLIMETRE,
        "y_mm": np.concatenate([y for _, _, y, *_ in shapes]) / MILLIMETRE,
        "angle_deg": np.concatenate([angle for *_, angle, _ in shapes]) / DEGREE,
        "curvature_per_m": np.concatenate([curvature for *_, curvature in shapes]),
    }


def _shape(tube: NotchedTube, gravity: float, method: str, points: int | None) -> Shape:
    """Return s, x, y (m), angle (rad) and curvature (1/m) at the asked points."""
    pieces = tube.segments
    ends = np.concatenate(([0.0], np.cumsum(pieces.length)))
    asked = ends if points is None else np.linspace(0.0, ends[-1], points)
    if method == "projected":
        from coast_cli.mechanics.beam.projected import solve_beam_projected

        return _interpolated(_converged(solve_beam_projected(tube, gravity), tube), asked)
    # The asked points become ends of pieces, so that nothing is interpolated.
    nodes = np.unique(np.concatenate((ends, asked)))
    piece = np.minimum(np.searchsorted(ends, 0.5 * (nodes[1:] + nodes[:-1])), ends.size - 1) - 1
    rigidity, solution = _solved(tube, gravity, np.diff(nodes), piece)
    at = np.searchsorted(nodes, asked)
    before = np.maximum(at - 1, 0)
    curvature = tube.natural_curvature + solution.moment[at] / rigidity[before]
    return asked, solution.x[at], solution.y[at], solution.angle[at], curvature


def _solved(
    tube: NotchedTube, gravity: float, length: FloatArray, piece: NDArray[np.intp]
) -> tuple[FloatArray, BeamSolution]:
    """Return rigidity (N m^2) and solution where the pieces of a tube are divided; a superelastic one by its secants."""
    linear, weight = tube.segments.rigidity[piece], tube.segments.weight[piece]

    def solve(rigidity: FloatArray) -> BeamSolution:
        found = solve_segments(length, rigidity, weight, tube.natural_curvature, gravity=(0.0, -gravity))
        return _converged(found.beam(0), tube)

    rigidity, solution = linear, solve(linear)
    if tube.superelastic is None:
        return rigidity, solution
    laws, cut = StripLaws.of(tube.row, tube.superelastic), piece % 2 == 1
    side = -1.0 if tube.natural_curvature < 0.0 else 1.0  # a tube is bent towards its notches by nature
    for _ in range(_MOST_SECANTS):
        moment = 0.5 * (solution.moment[1:] + solution.moment[:-1])[cut]
        softer = linear.copy()
        softer[cut] *= laws.softness(side * moment, piece[cut] // 2)
        change = float(np.max(np.abs(softer / rigidity - 1.0)))
        if change == 0.0:
            return rigidity, solution
        softer = np.sqrt(softer * rigidity)  # half the way: on a flat plateau whole steps swing to and fro
        rigidity, solution = softer, solve(softer)
        if change <= _SETTLED:
            return rigidity, solution
    raise NotConverged(f"{tube.name}: past its stress plateau the shape does not settle: give less gravity.")


def _interpolated(solution: BeamSolution, asked: FloatArray) -> Shape:
    x, y, angle = (np.interp(asked, solution.s, values) for values in (solution.x, solution.y, solution.angle))
    piece = np.clip(np.searchsorted(solution.s, asked) - 1, 0, solution.curvature.size - 1)
    return asked, x, y, angle, solution.curvature[piece]


def _converged(solution: BeamSolution, tube: NotchedTube) -> BeamSolution:
    if not solution.verdict.converged:
        raise NotConverged(f"{tube.name}: {solution.verdict.message}.")
    return solution
