"""Recorded shapes against the model's centreline at equal arc length (P's Table III)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import NotConverged
from coast_cli.mechanics.beam import BeamSolution, solve_beam
from coast_cli.mechanics.pair import combined_bend
from coast_cli.recordings.noise import Series

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.mechanics.tube import NotchedTube
    from coast_cli.recordings.model import ShapeRun
    from coast_cli.spec.build import Design
    from coast_cli.spec.config import Config

    Floats = NDArray[np.float64]

SMOOTH_DEGREE = 8
POINTS_A_COEFFICIENT = 3


@dataclass(frozen=True, eq=False)
class ShapeErrors:
    """A recorded shape against the model's.

    Attributes:
        run: the recording.
        arc: arc length of the recorded points from the clamp, [n] m.
        x, y: places of the model at those arc lengths, [n] m.
        distance: between model and recording, [n] m.
    """

    run: ShapeRun
    arc: Floats
    x: Floats
    y: Floats
    distance: Floats

    @property
    def series(self) -> list[Series]:
        """Both coordinates as series that noise is estimated from."""
        return [Series(self.run.x), Series(self.run.y)]


def shape_errors(config: Config, runs: Sequence[ShapeRun]) -> list[ShapeErrors]:
    """Return the errors of the configured tubes' shapes under gravity.

    Raises:
        BadInput: a tube is unknown. NotConverged: a shape was not found; the message says what to change.
    """
    from coast_cli.spec.build import build

    design = build(config)
    cache: dict[tuple[str, str | None], tuple[Floats, Floats, Floats]] = {}
    found = []
    for run in runs:
        key = (run.pair, run.natural)
        if key not in cache:
            cache[key] = _centreline(design, run)
        s, model_x, model_y = cache[key]
        arc = arc_length(run.x, run.y)
        x, y = np.interp(arc, s, model_x), np.interp(arc, s, model_y)
        found.append(ShapeErrors(run, arc, x, y, np.hypot(x - run.x, y - run.y)))
    return found


def arc_length(x: Floats, y: Floats) -> Floats:
    """Return the arc length from the clamp, at the origin and along +x, to each point, [n] m.

    Noise lengthens the chord from point to point; where points are many it is measured along a polynomial through them.
    """
    chord = max(float(x[0]), 0.0) + np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    if len(x) < POINTS_A_COEFFICIENT * SMOOTH_DEGREE:
        return chord
    slopes = [np.polynomial.Chebyshev.fit(chord, values, SMOOTH_DEGREE).deriv() for values in (x, y)]
    fine = np.linspace(chord[0], chord[-1], 8 * len(x))
    speed = np.hypot(slopes[0](fine), slopes[1](fine))
    along = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))))
    length: Floats = chord[0] + np.interp(chord, fine, along)
    return length


def _centreline(design: Design, run: ShapeRun) -> tuple[Floats, Floats, Floats]:
    """Return arc length, x and y (m) of the model's centreline."""
    turn = -1.0 if _turned_over(design, run) else 1.0
    tubes = [_turned(design.tube(name), turn) for name in (run.outer, run.middle) if name]
    solved = [_solved(tube, design.gravity) for tube in tubes]
    if len(tubes) == 1:
        return solved[0].s, solved[0].x, solved[0].y
    length, _, bend = combined_bend((tubes[0], tubes[1]), (solved[0], solved[1]))
    angle = np.concatenate(([0.0], np.cumsum(bend)))
    along = length * np.sinc(bend / (2.0 * np.pi))
    middle = angle[:-1] + 0.5 * bend
    places = (length, along * np.cos(middle), along * np.sin(middle))
    s, x, y = (np.concatenate(([0.0], np.cumsum(part))) for part in places)
    return s, x, y


def _turned_over(design: Design, run: ShapeRun) -> bool:
    """Whether the tube, or the pair's outer tube, was clamped the other way up than the configuration has it."""
    if run.natural is None:
        return False
    leading = design.tube(run.outer or run.middle or "").natural_curvature
    usual = "up" if leading > 0.0 or (leading == 0.0 and run.outer is not None) else "down"
    return run.natural != usual


def _turned(tube: NotchedTube, turn: float) -> NotchedTube:
    return replace(tube, natural_curvature=turn * tube.natural_curvature)


def _solved(tube: NotchedTube, gravity: float) -> BeamSolution:
    solution = solve_beam(tube, gravity)
    if not solution.verdict.converged:
        raise NotConverged(f"{tube.name}: {solution.verdict.message}.")
    return solution
