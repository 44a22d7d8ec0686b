"""The lines of photographed tubes under the refitted base and the corrected model, and their curvatures."""

from __future__ import annotations

import numpy as np

from coast_cli.diagnosis.curves import ShapeCurve
from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.shapes.forward import Line, missed_by
from coast_cli.diagnosis.shapes.photograph import Photograph
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.mechanics.section import FloatArray

_DEGREE = 8  # of a polynomial in arc length: noise of points allows no more bends than that
_UNSURE = 0.06  # of the tube, at either end, where its second derivative means nothing


def shape_curves(problem: ShapeProblem, base: Fit, corrected: Fit) -> tuple[ShapeCurve, ...]:
    """Return every photograph with the lines of both models."""
    states = [problem.state(base.coordinates, ()), problem.state(corrected.coordinates, corrected.effects)]
    jobs = range(len(problem.photographs))
    before, after = (problem.forward.lines([(index, state) for index in jobs]) for state in states)
    return tuple(
        ShapeCurve(
            run=shape.run,
            at=shape.at,
            base=np.stack((old.x[0], old.y[0])),
            corrected=np.stack((new.x[0], new.y[0])),
            curvature=_curvatures(shape, old, new),
            natural=None if shape.is_pair else shape.upward * states[1].natural[shape.tubes[0][0]],
        )
        for shape, old, new in zip(problem.photographs, before, after, strict=True)
    )


def _curvatures(shape: Photograph, base: Line, corrected: Line) -> FloatArray:
    """Return curvatures along the tube: of the models by their angle, of the recording by that and the slope it misses."""
    fitted = np.polynomial.Chebyshev.fit
    degree = min(_DEGREE, max(len(shape.run) // 6, 2))
    angles = [np.unwrap(np.arctan2(line.along_y[0], line.along_x[0])) for line in (base, corrected)]
    smooth = [fitted(shape.at, angle, degree).deriv()(shape.at) for angle in angles]
    missed = fitted(shape.at, missed_by(shape, base)[0][0], degree).deriv(2)(shape.at)
    found = np.stack((smooth[0] + missed, *smooth))
    found[:, np.abs(shape.at / shape.length - 0.5) > 0.5 - _UNSURE] = np.nan
    return found
