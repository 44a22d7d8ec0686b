"""What is fitted to what: the runs of a recording, the base model's own free parameters, and the residuals between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.likelihood import NoiseBank
from coast_cli.diagnosis.screen import screened
from coast_cli.effects.effect import Effect, History, Need, Scale
from coast_cli.effects.forward import Layout, Prediction, Tables, predict
from coast_cli.mechanics.joint import Joint, curvature_from_stroke
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.model import JointRun
from coast_cli.units import GIGAPASCAL, MEGAPASCAL, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.noise import NoiseEstimate
    from coast_cli.spec.config import Config

Booleans = NDArray[np.bool_]

# Standard deviations of the weak priors on base parameters, where the configuration gives no {min, max} of its own.
_PRIORS = {
    "youngs_modulus_gpa": 0.5,  # of its logarithm
    "notch_friction": 0.01,
    "deadband_mm": 1.0,
    "tendon_youngs_modulus_gpa": 0.1,  # of its logarithm
}
_LOGARITHMIC = ("youngs_modulus_gpa", "tendon_youngs_modulus_gpa")
CONFIG_KEYS = {
    "youngs_modulus_gpa": "joint.youngs_modulus_gpa",
    "notch_friction": "joint.notch_friction",
    "deadband_mm": "joint.deadband_mm",
    "tendon_youngs_modulus_gpa": "tendon.youngs_modulus_gpa",
    "pulley_friction": "joint.pulley_friction",
}
_TRIVIAL = 1e-12
_DIFFERENCES_MARGIN = 1.6
_SLOW_NOISE = 1.6  # times the floor: base fits of clean simulated recordings end within 2.1 of it
_FEWEST_RELEASED = 3
_SHORTEST_BRANCH = 5
_RATES_DIFFER = 1.5
_TRAVEL = 0.2  # of the range, for a branch to have a rate of its own


@dataclass(frozen=True, slots=True)
class BaseParameter:
    """One calibratable number of the base model: configured value, bounds, prior width; see ``_PRIORS`` for its scale."""

    name: str
    value: float
    low: float
    high: float
    prior: float

    @property
    def logarithmic(self) -> bool:
        """Whether the fit moves the logarithm."""
        return self.name in _LOGARITHMIC


@dataclass(frozen=True, slots=True)
class Recorded:
    """What the drive did in a run, with the turning points that its samples miss, and at which rows (n,) it was seen."""

    run: int
    history: History
    rows: NDArray[np.int64]


def recorded_history(run: JointRun, index: int, first_time: float) -> Recorded:
    """Return the history of a run; without a clock its samples are taken as one second apart."""
    from coast_cli.recordings.corners import missed_corners

    clock = np.arange(len(run), dtype=np.float64) if run.time is None else run.time - first_time
    corners = missed_corners(run.drive, clock, run.branches)
    drive = np.insert(run.drive, corners.before, corners.drive)
    history = History(
        np.insert(clock, corners.before, corners.time),
        None if run.stroke is None else drive,
        drive if run.stroke is None else None,
        np.insert(run.bending_length, corners.before, run.bending_length[corners.before]),
    )
    rows = np.arange(len(run)) + np.searchsorted(corners.before, np.arange(len(run)), side="right")
    return Recorded(index, history, rows)


@dataclass(frozen=True)
class Problem:
    """A recording of a joint, ready to be fitted.

    Attributes:
        runs: in the order they were recorded.
        joints: by pair name, with configured parameters.
        base: the free parameters of the base model.
        train: for each run which rows are fitted, (n,).
        usable: for each run and column which samples count at all (not dropped, not an outlier), (n, k).
        tension_noise: rough level of the tension witness, N; None where tension is the drive or was not recorded.
        noise: rough level of the response, SI.
    """

    runs: tuple[JointRun, ...]
    joints: Mapping[str, Joint]
    base: tuple[BaseParameter, ...]
    train: tuple[Booleans, ...]
    usable: tuple[Booleans, ...]
    tension_usable: tuple[Booleans, ...]
    noise: float
    tension_noise: float | None
    fixed_effects: tuple[Effect, ...] = field(default=())

    @cached_property
    def layouts(self) -> dict[str, Layout]:
        """What is observed of each pair, with a curvature that tables must reach."""
        largest = max(self._largest_curvature(run) for run in self.runs)
        return {run.pair: Layout(run.kind, run.response.shape[1], 1.6 * largest + 5.0) for run in self.runs}

    def _largest_curvature(self, run: JointRun) -> float:
        joint = self.joints[run.pair]
        seen = np.nanmax(np.abs(run.response), initial=0.0) if np.isfinite(run.response).any() else 0.0
        if run.kind == "bend":
            seen /= float(run.bending_length.min())
        elif run.kind == "notch":
            seen /= float(joint.middle.pitch.min())
        if run.stroke is None or joint.tendon is None:
            return float(seen)
        reached = curvature_from_stroke(joint, np.max(run.stroke), np.min(run.bending_length)).curvature
        return max(float(seen), min(float(reached), 3.0 * float(seen) + 20.0))

    @cached_property
    def histories(self) -> dict[str, list[Recorded]]:
        """Drive histories by pair, in the order of the runs."""
        by_pair: dict[str, list[Recorded]] = {}
        for index, run in enumerate(self.runs):
            by_pair.setdefault(run.pair, []).append(recorded_history(run, index, self.first_time))
        return by_pair

    @cached_property
    def first_time(self) -> float:
        """The earliest clock of the recording, s."""
        times = [float(run.time.min()) for run in self.runs if run.time is not None and run.time.size]
        return min(times, default=0.0)

    @cached_property
    def holds(self) -> dict[Need, bool]:
        """What effects need of a recording, and whether it is there."""
        tubes = [joint.middle for joint in self.joints.values()]
        return {
            "stroke": self.runs[0].stroke is not None,
            "time": all(run.time is not None for run in self.runs),
            "release": any(int(np.sum(run.direction < 0)) >= _FEWEST_RELEASED for run in self.runs),
            "pairs": len(self.joints) > 1 or any(np.ptp(tube.depth) > 0.0 for tube in tubes),
            "rates": _has_rates(self.runs),
            "outer": any(joint.outer is not None for joint in self.joints.values()),
        }

    @cached_property
    def _fitted_runs(self) -> tuple[JointRun, ...]:
        """Runs with rows that are fitted: nothing that a verdict rests on is taken from the others."""
        return tuple(run for run, rows in zip(self.runs, self.train, strict=True) if rows.any()) or self.runs

    @cached_property
    def noise_estimate(self) -> NoiseEstimate:
        """What the recording itself says of its noise, whatever the model."""
        from coast_cli.recordings.noise import recording_noise

        return recording_noise(self._fitted_runs)

    @property
    def highest_floor(self) -> float:
        """The highest noise level that the recording leaves possible, SI: slow noise counted in full, within reason."""
        estimate = self.noise_estimate
        generous = float(estimate.level * np.exp(min(estimate.log_level_std, 0.7)))
        return min(max(generous, self.floor), _SLOW_NOISE * self.floor)

    @cached_property
    def floor(self) -> float:
        """The noise level that the recording itself shows, SI, generous by its own uncertainty."""
        estimate = self.noise_estimate
        generous = float(estimate.level * np.exp(min(estimate.log_level_std, 0.7)))
        # Second differences of AR(1) noise have variance 6 - 8 rho + 2 rho^2; kinks of the signal can only raise both.
        rho = min(estimate.correlation, 0.97)
        from_differences = self.noise * np.sqrt(6.0 / (6.0 - 8.0 * rho + 2.0 * rho**2))
        if estimate.quantum > 0.5 * self.noise:
            return max(generous, 1e-15)
        return max(min(generous, float(_DIFFERENCES_MARGIN * from_differences)), 1e-15)

    def configured(self) -> FloatArray:
        """Return the base parameters as configured, in fit coordinates (p,)."""
        return np.array([np.log(p.value) if p.logarithmic else p.value for p in self.base])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of the base parameters in fit coordinates, each (p,)."""
        low = np.array([np.log(p.low) if p.logarithmic else p.low for p in self.base])
        high = np.array([np.log(p.high) if p.logarithmic else p.high for p in self.base])
        return low, high

    def values(self, coordinates: FloatArray) -> dict[str, float]:
        """Return the base parameters in user units from fit coordinates."""
        return {p.name: float(np.exp(c) if p.logarithmic else c) for p, c in zip(self.base, coordinates, strict=True)}

    def predict(self, coordinates: FloatArray, effects: Sequence[Effect]) -> list[Prediction]:
        """Return the prediction of every run in order, from base parameters in fit coordinates."""
        return self.predict_with(self.values(coordinates), effects)

    def predict_with(self, values: Mapping[str, float], effects: Sequence[Effect]) -> list[Prediction]:
        """Return the prediction of every run in order, from base parameters in user units; those not given stay."""
        found: dict[int, Prediction] = {}
        for pair, recorded in self.histories.items():
            joint = with_base(self.joints[pair], values)
            histories = [one.history for one in recorded]
            predicted = predict(joint, (*self.fixed_effects, *effects), histories, self.layouts[pair], self.tables)
            for one, whole in zip(recorded, predicted, strict=True):
                found[one.run] = Prediction(whole.response[one.rows], whole.tension[one.rows])
        return [found[index] for index in range(len(self.runs))]

    @cached_property
    def tables(self) -> Tables:
        """What predictions of this problem have tabulated."""
        return Tables()

    @cached_property
    def sequences(self) -> list[tuple[int, int, NDArray[np.int64]]]:
        """Response sequences that are fitted: (run, column, rows)."""
        return [
            (index, column, np.flatnonzero(self.usable[index][:, column] & self.train[index]))
            for index in range(len(self.runs))
            for column in range(self.runs[index].response.shape[1])
        ]

    @cached_property
    def tension_sequences(self) -> list[tuple[int, NDArray[np.int64]]]:
        """Tension sequences that are fitted as a second witness: (run, rows)."""
        if self.tension_noise is None:
            return []
        return [(i, np.flatnonzero(self.tension_usable[i] & self.train[i])) for i in range(len(self.runs))]

    @cached_property
    def bank(self) -> NoiseBank:
        """Noise colours of the fitted response."""
        return NoiseBank([rows for _, _, rows in self.sequences])

    @cached_property
    def tension_bank(self) -> NoiseBank:
        """Noise colours of the fitted tension."""
        return NoiseBank([rows for _, rows in self.tension_sequences])

    @cached_property
    def observed(self) -> FloatArray:
        """Fitted responses, one sequence after the other, SI."""
        return _joined([self.runs[i].response[rows, column] for i, column, rows in self.sequences])

    @cached_property
    def observed_tension(self) -> FloatArray:
        """Fitted tensions, N."""
        return _joined([_required(self.runs[i].tension)[rows] for i, rows in self.tension_sequences])

    def fitted(self, predictions: Sequence[Prediction]) -> tuple[FloatArray, FloatArray]:
        """Return the predictions of the fitted responses and tensions, in the order of ``observed``."""
        response = _joined([predictions[i].response[rows, column] for i, column, rows in self.sequences])
        tension = _joined([predictions[i].tension[rows] for i, rows in self.tension_sequences])
        return response, tension

    def scales(self) -> dict[Scale, float]:
        """Return the largest curvature, strain, tension and so on that the recording reaches at configured values."""
        from coast_cli.effects.stations import stations_for

        curvature, strain, closure, tension = 1e-9, 1e-9, 1e-9, 1e-9
        stiffest = max(joint.youngs_modulus for joint in self.joints.values())
        predictions = self.predict(self.configured(), ())
        for run, prediction in zip(self.runs, predictions, strict=True):
            if run not in self._fitted_runs:
                continue
            joint = self.joints[run.pair]
            stations = stations_for(joint, (), float(run.bending_length[0]), run.kind, run.response.shape[1])
            divisor = {
                "curvature": 1.0,
                "bend": float(run.bending_length.mean()),
                "notch": float(stations.pitch.mean()),
            }
            seen = float(np.nanmax(np.abs(run.response), initial=0.0)) / divisor[run.kind]
            curvature = max(curvature, seen)
            strain = max(strain, seen * float(stations.segment.strain_per_curvature.mean()))
            closure = max(closure, seen / float(stations.segment.closing_curvature.mean()))
            measured = run.tension if run.tension is not None else prediction.tension
            tension = max(tension, float(np.nanmax(measured, initial=0.0)))
        response = max(float(np.nanmax(np.abs(run.response), initial=0.0)) for run in self._fitted_runs)
        spans = [float(np.ptp(run.time)) for run in self.runs if run.time is not None and run.time.size]
        return {
            "": 1.0,
            "curvature": curvature,
            "strain": strain,
            "stress": strain * stiffest / MEGAPASCAL,
            "closure": closure,
            "tension": tension,
            "duration": max(spans, default=1.0),
            "response": response,
            "stroke": max(float(np.ptp(run.drive)) / MILLIMETRE for run in self.runs),
        }

    def only(self, train: Sequence[Booleans]) -> Problem:
        """Return the same problem fitted on other rows."""
        return replace(self, train=tuple(train))


def with_base(joint: Joint, values: Mapping[str, float]) -> Joint:
    """Return a joint with base parameters (user units, names as in ``Problem.values``) replaced."""
    changes: dict[str, float] = {}
    if "youngs_modulus_gpa" in values:
        changes["youngs_modulus"] = values["youngs_modulus_gpa"] * GIGAPASCAL
    if "notch_friction" in values:
        changes["notch_friction"] = values["notch_friction"]
    if "pulley_friction" in values:
        changes["pulley_friction"] = values["pulley_friction"]
    if "deadband_mm" in values:
        changes["deadband"] = values["deadband_mm"] * MILLIMETRE
    tendon = joint.tendon
    if tendon is not None and "tendon_youngs_modulus_gpa" in values:
        tendon = replace(tendon, youngs_modulus=values["tendon_youngs_modulus_gpa"] * GIGAPASCAL)
    return replace(joint, tendon=tendon, **changes)  # type: ignore[arg-type]


def build_problem(config: Config, runs: Sequence[JointRun], held_out: Sequence[Booleans] | None = None) -> Problem:
    """Return the problem of fitting a configuration to runs.

    Args:
        held_out: for each run which rows are not fitted, (n,); none by default.
    """
    from coast_cli.effects.catalogue import build_effects
    from coast_cli.spec.build import build_joint

    joints = {run.pair: build_joint(config, run.outer, run.middle) for run in runs}
    if config.tendon is None and any(run.stroke is not None for run in runs):
        raise config.refuse(("tendon",), "a stroke needs a tendon", allowed="a [tendon] table")
    held = held_out or [np.zeros(len(run), bool) for run in runs]
    fitted = [not rows.all() for rows in held]
    drives = [run.drive for run in runs]
    usable, noise = screened([run.response for run in runs], drives, fitted)
    witness = all(run.tension is not None and run.stroke is not None for run in runs)
    if witness:
        columns = [_required(run.tension)[:, np.newaxis] for run in runs]
        tension_usable, tension_noise = screened(columns, drives, fitted)
        tension_rows = tuple(use[:, 0] for use in tension_usable)
    else:
        tension_rows, tension_noise = tuple(np.zeros(len(run), bool) for run in runs), None
    return Problem(
        runs=tuple(runs),
        joints=joints,
        base=_free_parameters(config, runs, has_witness=witness),
        train=tuple(~rows for rows in held),
        usable=tuple(usable),
        tension_usable=tension_rows,
        noise=noise,
        tension_noise=tension_noise,
        fixed_effects=build_effects(config.corrections),
    )


def _free_parameters(config: Config, runs: Sequence[JointRun], *, has_witness: bool) -> tuple[BaseParameter, ...]:
    """Choose what the recording can tell: strokes and one length only fix products, which the modulus stands for."""
    stroke_driven = runs[0].stroke is not None
    lengths = np.concatenate([run.bending_length for run in runs])
    names = ["youngs_modulus_gpa"]
    if float(np.ptp(lengths)) > 0.05 * float(lengths.max()):
        names.append("notch_friction")
    if stroke_driven:
        names.append("deadband_mm")
    if has_witness and config.tendon is not None:
        names.append("tendon_youngs_modulus_gpa")
    found = []
    for name in names:
        value, low, high = config.bounds(CONFIG_KEYS[name])
        wide = _wide_bounds(name, value)
        low, high = max(low, wide[0]), min(high, wide[1])
        given = _given_bounds(config, name)
        prior = _PRIORS[name]
        if given is not None:
            low, high = given
            prior = (np.log(high / low) if name in _LOGARITHMIC else high - low) / 4.0
        found.append(BaseParameter(name, value, low, high, max(prior, _TRIVIAL)))
    return tuple(found)


def _wide_bounds(name: str, value: float) -> tuple[float, float]:
    if name in _LOGARITHMIC:
        return value / 8.0, value * 8.0
    return (1.0, 1.1) if name == "notch_friction" else (-3.0, value + 10.0)


def _given_bounds(config: Config, name: str) -> tuple[float, float] | None:
    from coast_cli.spec.values import Calibrated

    table, key = CONFIG_KEYS[name].split(".")
    number = getattr(getattr(config, table), key)
    return (number.min, number.max) if isinstance(number, Calibrated) else None


def _has_rates(runs: Sequence[JointRun]) -> bool:
    """Return whether the drive moved at rates that differ, or held: at one rate a late answer looks like play."""
    rates = []
    for run in runs:
        if run.time is None:
            return False
        for part in run.branches.parts:
            if part.stop - part.start < _SHORTEST_BRANCH:
                continue
            if part.direction == 0:
                return True
            span = float(run.time[part.stop - 1] - run.time[part.start])
            travel = abs(float(run.drive[part.stop - 1] - run.drive[part.start]))
            if span > 0.0 and travel > _TRAVEL * float(np.ptp(run.drive)):
                rates.append(travel / span)
    return bool(rates) and max(rates) > _RATES_DIFFER * min(rates)


def _joined(parts: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros(0)


def _required(values: FloatArray | None) -> FloatArray:
    if values is None:
        raise ValueError("a tension witness was expected")
    return values
