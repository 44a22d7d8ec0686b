"""The errors of one model on recordings it was not fitted to, run by run and pooled: P's Tables III, IV and V."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.errors import UNITS, tip_of, to_unit
from coast_cli.diagnosis.shapes.build import build_shape_problem
from coast_cli.recordings.given import require_read
from coast_cli.recordings.noise import NoiseEstimate, recording_noise, run_noises
from coast_cli.recordings.shape_noise import shape_noise
from coast_cli.recordings.summary import known_noise
from coast_cli.rows import Drawn, Rows
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.model import JointRun, Recordings, ShapeRun
    from coast_cli.spec.config import Config

    Floats = NDArray[np.float64]

POOLED, MEAN = "all", "mean"


@dataclass(frozen=True, eq=False)
class JointErrors:
    """A joint run against its model.

    Attributes:
        run: the recording.
        predicted: response of the model, [n, k], SI.
        difference: predicted less recorded response, [n, k], NaN where a frame was dropped.
        tip: distance between the tips that both stand for, m, of the samples with a whole response.
    """

    run: JointRun
    predicted: Floats
    difference: Floats
    tip: Floats

    @property
    def curvature(self) -> Floats:
        """Difference in the curvature of the whole segment, 1/m, of the samples with a whole response."""
        whole = self.run.valid
        total: Floats = self.difference[whole].sum(axis=1)
        return total if self.run.kind == "curvature" else total / self.run.bending_length[whole]

    @property
    def has_segment(self) -> bool:
        """Whether the run is of a segment, which has a curvature and a tip."""
        return bool(self.run.middle)


@dataclass(frozen=True, eq=False)
class ShapeErrors:
    """A recorded shape against the model's.

    Attributes:
        run: the recording.
        x, y: places of the model at the arc lengths of the recorded points, [n] m.
        distance: between model and recording, [n] m.
    """

    run: ShapeRun
    x: Floats
    y: Floats
    distance: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Rows, Drawn):
    """Every run of a call against one model, in the order of the files; ``known_noise`` is the camera's, SI."""

    joint: tuple[JointErrors, ...]
    shape: tuple[ShapeErrors, ...]
    known_noise: float | None = None

    @property
    def models(self) -> tuple[tuple[str, Comparison], ...]:
        """The one model with its name, as of several."""
        return (("model", self),)

    def rows(self) -> list[dict[str, str | float | int | None]]:
        """Return a row for each run, of several the mean of their errors, and last one for all of them pooled."""
        levels = run_noises([one.run for one in self.joint], self.known_noise)
        rows = [_row(one.run.name, [one], (), level) for one, level in zip(self.joint, levels, strict=True)]
        rows += [_row(one.run.name, (), [one], _shape_noise([one])) for one in self.shape]
        pooled = _row(POOLED, self.joint, self.shape, self._noise())
        return [*rows, _mean(rows, pooled), pooled] if len(rows) > 1 else [*rows, pooled]

    def _table(self) -> list[dict[str, str | float | int | None]]:
        return self.rows()

    def _noise(self) -> NoiseEstimate | None:
        if len(_units(self.joint, self.shape)) != 1:
            return None
        if not self.joint:
            return _shape_noise(self.shape)
        return recording_noise((one.run for one in self.joint), self.known_noise)


@dataclass(frozen=True, eq=False, repr=False)
class ModelComparison(Rows):
    """The same recordings against several models, by name; one alone answers as ``Comparison`` does."""

    models: tuple[tuple[str, Comparison], ...]

    def rows(self) -> list[dict[str, str | float | int | None]]:
        """Return every model's rows, with the model in the first column where there are several."""
        if len(self.models) == 1:
            return self.models[0][1].rows()
        by_model = [[{"model": name, **row} for row in one.rows()] for name, one in self.models]
        return [row for rows in zip(*by_model, strict=True) for row in rows]

    def _table(self) -> list[dict[str, str | float | int | None]]:
        return self.rows()


def compare_models(
    models: Sequence[tuple[str, Config]], recordings: Recordings, noise: float | None = None
) -> ModelComparison:
    """Return the errors of several configurations, each with its name; see ``compare``."""
    return ModelComparison(tuple((name, compare(config, recordings, noise)) for name, config in models))


def compare(config: Config, recordings: Recordings, noise: float | None = None) -> Comparison:
    """Return the errors of a configuration, with the corrections it carries, on recordings.

    Args:
        noise: of the camera where it is known, in the unit of the response.

    Raises:
        BadInput: a run's tubes or drive do not go with the configuration. UsageError: ``noise`` is no noise.

    Example:
        >>> config = coast.load_config(coast.REFERENCE)
        >>> table = {"stroke_mm": [1.5, 2.5, 3.5], "curvature_per_m": [1.0, 10.0, 20.0], "bending_length_mm": 30.0}
        >>> found = coast.compare(config, coast.read_recordings(table, config))
        >>> [round(value, 1) for value in found.joint[0].predicted[:, 0].tolist()]
        [3.8, 16.4, 28.9]
    """
    require_read(config, recordings)
    known = known_noise(recordings, noise)
    joint = tuple(_joint_errors(config, recordings.joint.runs)) if recordings.joint else ()
    shape = tuple(_shape_errors(config, recordings.shape.runs)) if recordings.shape else ()
    return Comparison(joint, shape, known)


def _joint_errors(config: Config, runs: Sequence[JointRun]) -> list[JointErrors]:
    """Predict runs of one kind together, as what a run leaves in the tendon is carried to the next."""
    kinds: dict[tuple[str, int, bool], list[int]] = {}
    for index, run in enumerate(runs):
        kinds.setdefault((run.kind, run.response.shape[1], run.stroke is None), []).append(index)
    found: dict[int, JointErrors] = {}
    for members in kinds.values():
        problem = build_joint_problem(config, [runs[index] for index in members])
        responses = [prediction.response for prediction in problem.predict(problem.configured(), ())]
        pitches = {pair: float(np.mean(joint.middle.pitch)) for pair, joint in problem.joints.items()}
        del problem  # which keeps as much as the runs themselves
        for index, response in zip(members, responses, strict=True):
            run, whole = runs[index], runs[index].valid
            if run.pair not in pitches:
                found[index] = JointErrors(run, response, response - run.response, np.zeros(0))
                continue
            pitch = pitches[run.pair]
            x, y = tip_of(run, response[whole], run.bending_length[whole], pitch)
            seen_x, seen_y = tip_of(run, run.response[whole], run.bending_length[whole], pitch)
            tip = np.hypot(np.subtract(x, seen_x, out=x), np.subtract(y, seen_y, out=y), out=x)  # of ten million rows
            del y, seen_x, seen_y
            found[index] = JointErrors(run, response, response - run.response, tip)
    return [found[index] for index in range(len(runs))]


def _shape_errors(config: Config, runs: Sequence[ShapeRun]) -> list[ShapeErrors]:
    problem = build_shape_problem(config, runs)
    state = problem.state(problem.configured(), ())
    lines = problem.forward.lines([(index, state) for index in range(len(runs))])
    return [
        ShapeErrors(run, line.x[0], line.y[0], np.hypot(line.x[0] - run.x, line.y[0] - run.y))
        for run, line in zip(runs, lines, strict=True)
    ]


def _shape_noise(shapes: Sequence[ShapeErrors]) -> NoiseEstimate:
    """Return the noise of points across the line, m."""
    return shape_noise([one.run for one in shapes])


def _units(joint: Sequence[JointErrors], shape: Sequence[ShapeErrors]) -> set[str]:
    return {UNITS[one.run.kind] for one in joint} | ({"shape_mm"} if shape else set())


def _row(
    name: str, joint: Sequence[JointErrors], shape: Sequence[ShapeErrors], noise: NoiseEstimate | None
) -> dict[str, str | float | int | None]:
    units = _units(joint, shape)
    unit = next(iter(units)) if len(units) == 1 else None
    by_kind = {kind: [one for one in joint if one.run.kind == kind] for kind in UNITS}
    count = sum(int(np.isfinite(one.difference).sum()) for one in joint) + sum(len(one.distance) for one in shape)
    levels: list[float | None] = [None, None, None]
    if noise is not None:
        found = (noise.level, *noise.interval)
        levels = [to_unit(joint[0].run.kind, level) if joint else level / MILLIMETRE for level in found]
    return {
        "run": name,
        "n": count,
        "rmse_curvature_per_m": _rms([one.curvature for one in joint if one.has_segment]),
        "rmse_bend_deg": _rms([one.difference for one in by_kind["bend"]], DEGREE),
        "rmse_notch_deg": _rms([one.difference for one in by_kind["notch"]], DEGREE),
        "rmse_position_mm": _rms([one.difference for one in by_kind["position"]], MILLIMETRE),
        "rmse_force_n": _rms([one.difference for one in by_kind["force"]]),
        "rmse_shape_mm": _rms([one.distance for one in shape], MILLIMETRE),
        "rmse_tip_mm": _rms([*(one.tip for one in joint), *(one.distance[-1:] for one in shape)], MILLIMETRE),
        "noise": levels[0],
        "noise_low": levels[1],
        "noise_high": levels[2],
        "noise_unit": unit,
    }


def _mean(
    rows: Sequence[Mapping[str, str | float | int | None]], pooled: Mapping[str, str | float | int | None]
) -> dict[str, str | float | int | None]:
    """Return the mean of each error over the runs that have it: a long run counts no more than a short one."""
    found: dict[str, str | float | int | None] = {**pooled, "run": MEAN}
    found |= dict.fromkeys(("noise", "noise_low", "noise_high", "noise_unit"))
    for name in (name for name in pooled if name.startswith("rmse_")):
        values = [value for value in (row[name] for row in rows) if isinstance(value, float)]
        found[name] = sum(values) / len(values) if values else None
    return found


def _rms(parts: Sequence[Floats], unit: float = 1.0) -> float | None:
    """Return the root mean square of all finite values, in a unit; None where there are none."""
    values = np.concatenate([part[np.isfinite(part)].ravel() for part in parts]) if parts else np.zeros(0)
    return float(np.sqrt(np.mean(values**2))) / unit if values.size else None
