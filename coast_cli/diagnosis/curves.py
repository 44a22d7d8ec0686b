"""What the refitted base model and the corrected model predict, run by run: for plots and reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.diagnosis.shapes.forward import Line
    from coast_cli.diagnosis.shapes.photograph import Photograph
    from coast_cli.recordings.model import JointRun, Recordings, ShapeRun
    from coast_cli.spec.config import Config

    Floats = NDArray[np.float64]

_DEGREE = 8  # of a polynomial in arc length: noise of points allows no more bends than that
_UNSURE = 0.06  # of the tube, at either end, where its second derivative means nothing


@dataclass(frozen=True, eq=False)
class Curve:
    """A run with what both models expect of it, [n, k] in the run's SI unit."""

    run: JointRun
    base: Floats
    corrected: Floats


@dataclass(frozen=True, eq=False)
class ShapeCurve:
    """A photographed shape with both models' lines at its points: x and y in m, [2, n]; ``at``: arc length, m, [n].

    Attributes:
        curvature: of the recording, the refitted base and the corrected model, 1/m, [3, n]; NaN at the ends.
        natural: curvature of the corrected model without any load, 1/m, in the frame of the picture; None of a pair.
    """

    run: ShapeRun
    at: Floats
    base: Floats
    corrected: Floats
    curvature: Floats
    natural: float | None


def curves(config: Config, recordings: Recordings, diagnosis: Diagnosis) -> list[Curve] | list[ShapeCurve]:
    """Return the curves of all runs that were diagnosed, in order; none where nothing was fitted.

    The base is refitted here, on the runs that were not held out.
    """
    if diagnosis.comparison is None:
        return []
    held = set(diagnosis.comparison.held_out_runs)
    if recordings.joint is not None:
        return _joint_curves(config, recordings.joint.runs, diagnosis, held)
    return [] if recordings.shape is None else _shape_curves(config, recordings, diagnosis, held)


def _joint_curves(config: Config, runs: Sequence[JointRun], diagnosis: Diagnosis, held: set[str]) -> list[Curve]:
    from coast_cli.diagnosis.fit import fit
    from coast_cli.diagnosis.joint.build import build_joint_problem

    problem = build_joint_problem(config, runs, [np.full(len(run), run.name in held) for run in runs])
    base = problem.predict(fit(problem).coordinates, ())
    wanted = [(p, diagnosis.model_parameters.get(p.name, p.value)) for p in problem.base]
    coordinates = np.array([np.log(value) if p.logarithmic else value for p, value in wanted])
    corrected = problem.predict(coordinates, diagnosis.model_effects)
    return [
        Curve(run, before.response, after.response) for run, before, after in zip(runs, base, corrected, strict=True)
    ]


def _shape_curves(config: Config, recordings: Recordings, diagnosis: Diagnosis, held: set[str]) -> list[ShapeCurve]:
    """Return the lines of the refitted base and of the model that ``--save-model`` writes."""
    from coast_cli.diagnosis.fit import fit
    from coast_cli.diagnosis.model_file import model_text
    from coast_cli.diagnosis.shapes.problem import build_shape_problem
    from coast_cli.spec.load import load_config_text

    runs = [] if recordings.shape is None else recordings.shape.runs
    problem = build_shape_problem(config, runs).only([np.full(len(run), run.name not in held) for run in runs])
    base = problem.state(fit(replace(problem, noise=diagnosis.noise * MILLIMETRE)).coordinates, ())
    corrected = build_shape_problem(load_config_text(model_text(config, diagnosis, recordings), "corrected"), runs)
    jobs = range(len(runs))
    before = problem.forward.lines([(index, base) for index in jobs])
    after = corrected.forward.lines([(index, corrected.state(corrected.configured(), ())) for index in jobs])
    return [
        ShapeCurve(
            run=shape.run,
            at=shape.at,
            base=np.stack((old.x[0], old.y[0])),
            corrected=np.stack((new.x[0], new.y[0])),
            curvature=_curvatures(shape, old, new),
            natural=None if shape.is_pair else shape.upward * corrected.natural[shape.tubes[0][0]],
        )
        for shape, old, new in zip(problem.photographs, before, after, strict=True)
    ]


def _curvatures(shape: Photograph, base: Line, corrected: Line) -> Floats:
    """Return curvatures along the tube: of the models by their angle, of the recording by that and the slope it misses."""
    from coast_cli.diagnosis.shapes.forward import misfit

    fitted = np.polynomial.Chebyshev.fit
    degree = min(_DEGREE, max(len(shape.run) // 6, 2))
    angles = [np.unwrap(np.arctan2(line.along_y[0], line.along_x[0])) for line in (base, corrected)]
    smooth = [fitted(shape.at, angle, degree).deriv()(shape.at) for angle in angles]
    missed = fitted(shape.at, misfit(shape, base)[0][0], degree).deriv(2)(shape.at)
    found = np.stack((smooth[0] + missed, *smooth))
    found[:, np.abs(shape.at / shape.length - 0.5) > 0.5 - _UNSURE] = np.nan
    return found
