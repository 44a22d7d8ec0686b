"""A calibration as it is told: values, refits of single runs and branches, and errors on runs fitted and held out.

A part of the recordings that wants other values than the whole does is the sign that something is left out of the
model; the distance is that of a part from the whole it belongs to (Hausman, Econometrica 46, 1978).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.calibratable import Calibratable, calibratable, ranged_elsewhere
from coast_cli.diagnosis.joint.calibrate import CalibrationFit, Posed, fit_parameters, pose, refit
from coast_cli.diagnosis.joint.errors import UNITS, to_unit
from coast_cli.diagnosis.spread import Spread
from coast_cli.errors import BadInput, nearest
from coast_cli.recordings.given import require_read
from coast_cli.rows import Rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.diagnosis.joint.calibrate import Estimate
    from coast_cli.recordings.model import JointRun, Recordings
    from coast_cli.spec.config import Config

    Booleans = NDArray[np.bool_]
    Row = dict[str, str | float | bool | None]

EACH = "each"
WHOLE = "all"
CONFLICT = 3.5
FEWEST_ROWS = 6
LARGEST_WEIGHT = 1e6
BRANCHES = (("load", 1), ("release", -1))


@dataclass(frozen=True, eq=False)
class CalibratedPart:
    """A refit of one run or of one branch of all runs, and how far each value lies from the whole fit's, in sigmas."""

    name: str
    fitted: CalibrationFit
    distance: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class CalibrationErrors:
    """Root mean square errors by unit, as configured and as calibrated."""

    configured: Mapping[str, float]
    calibrated: Mapping[str, float]


@dataclass(frozen=True)
class Quality:
    """How well the runs of one unit are fitted: n samples, p fitted parameters, what is left over and the noise, RMS.

    Attributes:
        noise_high: the noise is below this with a probability of 95 %. known: whether the noise could be told at all.
    """

    unit: str
    samples: int
    parameters: int
    left_over: float
    noise: float
    noise_high: float
    known: bool

    @property
    def reduced_chi_square(self) -> float:
        """1 where what is left over is the noise."""
        free = max(self.samples - self.parameters, 1)
        return self.samples / free * (self.left_over / self.noise) ** 2

    @property
    def aic(self) -> float:
        """Akaike's criterion for errors of one level; of two models of the same samples the lower is the better."""
        return self.samples * float(np.log(self.left_over**2)) + 2.0 * self.parameters

    def __str__(self) -> str:
        """Say whether the fit is good."""
        said = f"{self.left_over:.3g} {self.unit} left over, AIC {self.aic:.4g}"
        if not self.known:
            return f"whether the fit is good cannot be told, as the noise of these runs cannot: {said}."
        said += f", noise {self.noise:.3g}, reduced chi-square {self.reduced_chi_square:.3g}"
        if self.left_over <= self.noise_high:
            return f"the fit is good: {said}."
        return f"the fit is not good: {said}; something is left out of the model, `coast diagnose` says what."


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Rows):
    """What a calibration found; values are in the units of their parameters' names.

    Attributes:
        parameters: that were asked for.
        whole: the fit of all runs that are not held out.
        parts: refits of single runs and branches.
        train: errors on the runs fitted. held_out: on those held out, None where there are none.
        held_out_runs: their names.
        in_turn: whether each run was held out in turn; ``whole`` is then fitted to all.
        unmoved: dotted keys of numbers that have a range, and that these recordings say nothing of.
    """

    parameters: tuple[Calibratable, ...]
    whole: CalibrationFit
    parts: tuple[CalibratedPart, ...]
    train: CalibrationErrors
    held_out: CalibrationErrors | None
    held_out_runs: tuple[str, ...]
    in_turn: bool
    unmoved: tuple[str, ...] = ()

    @property
    def spread(self) -> Spread:
        """How sure the fitted numbers of the whole are."""
        estimates = self.whole.estimates
        keys = tuple(estimate.parameter.key for estimate in estimates)
        return Spread(keys, np.array([estimate.std for estimate in estimates]), self.whole.correlation)

    def rows(self) -> list[Row]:
        """Return a row a parameter for the whole, then for each part; the same names in each."""
        rows = [self._row(WHOLE, self.whole, parameter, None) for parameter in self.parameters]
        for part in self.parts:
            names = {estimate.parameter.name for estimate in part.fitted.estimates}
            rows += [self._row(part.name, part.fitted, p, part.distance) for p in self.parameters if p.name in names]
        return rows

    def _table(self) -> list[Row]:
        return self.rows()

    def _row(
        self, subset: str, fitted: CalibrationFit, parameter: Calibratable, distance: Mapping[str, float] | None
    ) -> Row:
        found = {estimate.parameter.name: (index, estimate) for index, estimate in enumerate(fitted.estimates)}
        index, estimate = found.get(parameter.name, (-1, None))
        correlation: dict[str, float | None] = {}
        for other in self.parameters:
            place, _ = found.get(other.name, (-1, None))
            known = index >= 0 and place >= 0 and subset == WHOLE
            correlation[f"correlation_{other.name}"] = float(fitted.correlation[index, place]) if known else None
        return {
            "parameter": parameter.name,
            "subset": subset,
            "status": _status(estimate),
            "value": estimate.value if estimate else parameter.value,
            "std": _finite(estimate.std) if estimate else None,
            "low_90": estimate.low if estimate else None,
            "high_90": estimate.high if estimate else None,
            "configured": parameter.value,
            "conflict_sigma": distance.get(parameter.name) if distance else None,
            **correlation,
        }

    @property
    def quality(self) -> tuple[Quality, ...]:
        """How well the fitted runs are fitted, one for each unit of response."""
        from coast_cli.recordings.noise import recording_noise

        runs = [run for problem in self.whole.posed.problems for run in problem.runs]
        found = []
        for kind in dict.fromkeys(run.kind for run in runs):
            same = [run for run in runs if run.kind == kind]
            noise = recording_noise(same)
            count = sum(int(np.isfinite(run.response).sum()) for run in same)
            level, high = (to_unit(kind, value) for value in (noise.level, noise.interval[1]))
            left = self.train.calibrated[UNITS[kind]]
            found.append(Quality(UNITS[kind], count, len(self.whole.estimates), left, level, high, noise.determined))
        return tuple(found)

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on what could not be told, what ended on a bound, what conflicts, and how well it fits."""
        notes = [
            f"{p.name} is fitted between {p.low:g} and {p.high:g}: bounds assumed, as {p.key} has no min and max."
            for p in self.parameters
            if not p.given
        ]
        notes += [
            f"{key} has a range and is not fitted: a stroke or tension does not depend on it." for key in self.unmoved
        ]
        notes += [f"{name} is fixed at the given {value:g}." for name, value in self.whole.posed.fixed.items()]
        notes += [f"{p.name} is held at its configured {p.value:g}: {reason}." for p, reason in self.whole.held]
        for estimate in self.whole.estimates:
            if estimate.at_bound:
                name, value = estimate.parameter.name, estimate.value
                notes.append(f"{name} ended on its bound {value:.6g}: it wants to go further.")
        for part in self.parts:
            for name, distance in part.distance.items():
                if abs(distance) > CONFLICT:
                    notes.append(
                        f"{part.name} wants {name} {distance:+.1f} sigma from the whole: something that differs there is "
                        "left out of the model; `coast diagnose` says what."
                    )
        notes.append(f"error on the runs fitted: {_told(self.train)}.")
        notes += map(str, self.quality)
        if self.held_out is not None:
            how = "each run in turn, predicted from the others" if self.in_turn else ", ".join(self.held_out_runs)
            notes.append(f"error on runs held out ({how}): {_told(self.held_out)}.")
        if not self.whole.converged:
            notes.append("the fit did not settle: its values are where it stopped.")
        return tuple(notes)


def calibrate(
    config: Config,
    recordings: Recordings,
    fit: Sequence[str] = (),
    hold_out: Sequence[str] = (),
    *,
    fixed: Mapping[str, float] | None = None,
    weights: Mapping[str, float] | None = None,
) -> Calibration:
    """Fit parameters of the base model to joint recordings; values are in the units of the parameters' names.

    Args:
        config: the model. recordings: from ``read_recordings``.
        fit: names of the parameters; by default those the configuration gives bounds, else the usual three.
        hold_out: names of runs that are not fitted, or ``each``: every run in turn.
        fixed: values at which parameters are held, by name, e.g. ``{"pulley_friction": 0.2}``.
        weights: of the squares of single runs, by name: a run of weight 4 counts as one of half the noise.

    Raises:
        BadInput: no joint recording, no such parameter or run, a value out of range, or nothing left to fit.

    Example:
        >>> config = coast.load_config(coast.REFERENCE)
        >>> kappa = np.linspace(1.0, 30.0, 30)
        >>> pulled = coast.stroke(coast.build(config).joint(), kappa, 0.03).stroke
        >>> table = {"stroke_mm": 1e3 * pulled, "curvature_per_m": kappa, "bending_length_mm": 30.0}
        >>> found = coast.calibrate(config, coast.read_recordings(table, config), ["deadband_mm"])
        >>> round(found.whole.values["deadband_mm"], 4)
        1.2
    """
    require_read(config, recordings)
    if recordings.joint is None:
        raise BadInput("no joint recording to calibrate with", allowed="runs with a drive and a response")
    runs = recordings.joint.runs
    parameters = calibratable(config, fit, fixed)
    fixed, weights = dict(fixed or {}), _weights(runs, weights or {})
    in_turn = tuple(hold_out) == (EACH,) and EACH not in recordings.run_names
    kept_back = () if in_turn else _known(runs, hold_out)
    train = [run for run in runs if run.name not in kept_back]
    if not train or (in_turn and len(runs) < 2):
        raise BadInput("every run is held out, so none is left to fit", allowed="some of the runs")

    def posed(some: Sequence[JointRun]) -> Posed:
        return pose(config, some, parameters, fixed, weights)

    whole = fit_parameters(posed(train))
    held_out = None
    if in_turn:
        held_out = _errors_in_turn(runs, posed)
    elif kept_back:
        held_out = _errors(posed([run for run in runs if run.name in kept_back]), whole.values)
    return Calibration(
        parameters=parameters,
        whole=whole,
        parts=tuple(_parts(whole, train)),
        train=_errors(whole.posed, whole.values),
        held_out=held_out,
        held_out_runs=tuple(run.name for run in runs) if in_turn else kept_back,
        in_turn=in_turn,
        unmoved=ranged_elsewhere(config),
    )


def _weights(runs: Sequence[JointRun], given: Mapping[str, float]) -> dict[str, float]:
    """Return the weights of runs that are there.

    Raises:
        BadInput: no such run, or no such weight.
    """
    known = [run.name for run in runs]
    for name, weight in given.items():
        if name not in known:
            hint = nearest(name, known) or None
            raise BadInput("there is no such run to weigh", found=name, allowed=", ".join(known), hint=hint)
        if not 0.0 < weight <= LARGEST_WEIGHT:
            allowed = f"above 0 and at most {LARGEST_WEIGHT:g}; a run to leave out is held out"
            raise BadInput(f"the weight of run {name!r} is none", found=weight, allowed=allowed)
    return dict(given)


def _known(runs: Sequence[JointRun], names: Sequence[str]) -> tuple[str, ...]:
    known = [run.name for run in runs]
    for name in names:
        if name not in known:
            raise BadInput(
                "there is no such run to hold out",
                found=name,
                allowed=f"{', '.join(known)}, or {EACH}",
                hint=nearest(name, known) or None,
            )
    return tuple(dict.fromkeys(names))


def _parts(whole: CalibrationFit, runs: Sequence[JointRun]) -> list[CalibratedPart]:
    """Refit single runs and branches, where there is more than one."""
    subsets: dict[str, dict[str, Booleans]] = {}
    if len(runs) > 1:
        subsets |= {f"run {run.name}": {run.name: np.ones(len(run), bool)} for run in runs}
    by_branch = {name: {run.name: run.direction == way for run in runs} for name, way in BRANCHES}
    if all(sum(int(rows.sum()) for rows in branch.values()) >= FEWEST_ROWS for branch in by_branch.values()):
        subsets |= by_branch
    parts = []
    for name, rows in subsets.items():
        fitted = refit(whole, rows)
        if fitted is not None and fitted.estimates:
            parts.append(CalibratedPart(name, fitted, _distances(whole, fitted)))
    return parts


def _distances(whole: CalibrationFit, part: CalibrationFit) -> dict[str, float]:
    """Return how far the part's values lie from the whole's, in sigmas of their difference."""
    of_whole = {estimate.parameter.name: estimate for estimate in whole.estimates}
    found = {}
    for estimate in part.estimates:
        name = estimate.parameter.name
        variance = max(estimate.std**2 - of_whole[name].std ** 2, 0.25 * estimate.std**2)
        if np.isfinite(variance) and variance > 0.0:
            found[name] = float((estimate.value - of_whole[name].value) / np.sqrt(variance))
    return found


def _errors(posed: Posed, values: Mapping[str, float]) -> CalibrationErrors:
    return CalibrationErrors(_pooled([(posed, {})]), _pooled([(posed, values)]))


def _errors_in_turn(runs: Sequence[JointRun], posed: Callable[[Sequence[JointRun]], Posed]) -> CalibrationErrors:
    """Predict each run from a fit to all others, and pool the errors."""
    kept = []
    for run in runs:
        others = fit_parameters(posed([other for other in runs if other is not run]))
        kept.append((posed([run]), others.values))
    return CalibrationErrors(_pooled([(one, {}) for one, _ in kept]), _pooled(kept))


def _pooled(models: Sequence[tuple[Posed, Mapping[str, float]]]) -> dict[str, float]:
    """Return the root mean square error over every recorded sample, by the unit of the response."""
    squares: dict[str, list[tuple[float, int]]] = {}
    for posed, values in models:
        for problem in posed.problems:
            for run, prediction in zip(problem.runs, problem.predict_with(values, ()), strict=True):
                error = prediction.response - run.response
                error = error[np.isfinite(error)]
                squares.setdefault(run.kind, []).append((float(error @ error), error.size))
    return {
        UNITS[kind]: to_unit(kind, float(np.sqrt(sum(s for s, _ in parts) / max(sum(n for _, n in parts), 1))))
        for kind, parts in squares.items()
    }


def _status(estimate: Estimate | None) -> str:
    if estimate is None:
        return "held"
    return "on its bound" if estimate.at_bound else "fitted, profiled" if estimate.profiled else "fitted"


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _told(errors: CalibrationErrors) -> str:
    parts = [
        f"{errors.configured[unit]:.4g} as configured, {value:.4g} calibrated ({unit})"
        for unit, value in errors.calibrated.items()
    ]
    return "; ".join(parts)
