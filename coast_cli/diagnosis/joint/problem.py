"""What is fitted to what: the runs of a recording, the base model's own free parameters, and the residuals between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.fit import Fit, fit, rms
from coast_cli.diagnosis.joint.candidates import joint_candidates, joint_space
from coast_cli.diagnosis.joint.histories import Recorded, recorded_history
from coast_cli.diagnosis.joint.scales import scales_of
from coast_cli.diagnosis.noise_model import NoiseBank
from coast_cli.diagnosis.problem import Channel, Contender, Effort, Variant
from coast_cli.diagnosis.space import BaseParameter, Booleans, ParameterSpace, Point, bounds_of, configured_coordinates
from coast_cli.diagnosis.thresholds import (
    DIFFERENCES_MARGIN,
    FEWEST_RUNS_TO_DIFFER,
    FLOOR_DOUBT,
    LEAST_TAKEN_OF_DEVICES,
    MOST_BEHIND_OF_DEVICES,
    ONE_SAMPLE_SHARE,
    SLOW_NOISE,
    SLOWEST_NOISE_OF_DEVICES,
    SMALLEST,
    SMOOTH_MISFIT,
    SMOOTH_MISFIT_SHAPES,
)
from coast_cli.effects.catalogue import in_order
from coast_cli.effects.devices import predict_device
from coast_cli.effects.effect import Effect, Need, RecordingKind, Scale
from coast_cli.effects.forward import Layout, Prediction, Tables, predict
from coast_cli.effects.plateau import has_own_curve
from coast_cli.mechanics.joint import Joint, curvature_from_stroke
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.transmission import Transmission
from coast_cli.recordings.evidence import Evidence as Held
from coast_cli.recordings.evidence import evidence_of
from coast_cli.recordings.model import JointRun
from coast_cli.units import GIGAPASCAL, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.faults import Faults
    from coast_cli.recordings.noise import NoiseEstimate
    from coast_cli.recordings.swing import Swing


CONFIG_KEYS = {
    "youngs_modulus_gpa": "joint.youngs_modulus_gpa",
    "notch_friction": "joint.notch_friction",
    "deadband_mm": "joint.deadband_mm",
    "tendon_youngs_modulus_gpa": "tendon.youngs_modulus_gpa",
    "pulley_friction": "joint.pulley_friction",
    "wrap_angle_rad": "joint.wrap_angle_rad",
    "tendon_length_mm": "tendon.length_mm",
    "ratio": "joint.ratio",
    "zero_mm": "joint.zero_mm",
    "load_ratio": "joint.load_ratio",
}
EFFORT = Effort(fitted=(9, 5), finished=(5, 4), starts=2, steps=5, second=0.6)
DEVICE_EFFORT = replace(EFFORT, most_behind=float(MOST_BEHIND_OF_DEVICES))


@dataclass(frozen=True)
class JointProblem:
    """A recording of a joint, ready to be fitted.

    Attributes:
        runs: in the order they were recorded.
        joints: by pair name, with configured parameters; none where the device has no tubes.
        base: the free parameters of the base model.
        train: for each run which rows are fitted, (n,).
        usable: for each run and column which samples count at all (not dropped, not an outlier), (n, k).
        tension_noise: rough level of the tension witness, N; None where tension is the drive or was not recorded.
        noise: rough level of the response, SI.
        fixed_effects: corrections that the configuration already carries.
        concealed: ids of effects that are neither named nor rivals.
        given_noise: level of the response's noise where the user knows it, SI.
        faults: what is wrong with the rows themselves, run by run.
        device: a transmission without tubes, as configured; None of a notched joint.
    """

    runs: tuple[JointRun, ...]
    joints: Mapping[str, Joint]
    base: tuple[BaseParameter, ...]
    train: tuple[Booleans, ...]
    usable: tuple[Booleans, ...]
    tension_usable: tuple[Booleans, ...]
    noise: float
    tension_noise: float | None
    fixed_effects: tuple[Effect, ...] = ()
    concealed: frozenset[str] = frozenset()
    given_noise: float | None = None
    faults: tuple[Faults, ...] = ()
    device: Transmission | None = None

    @property
    def recording(self) -> RecordingKind:
        """Which side of an effect shows."""
        return "joint"

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
            recorded = recorded_history(run, index, self.first_time, has_tubes=self.device is None)
            by_pair.setdefault(run.pair, []).append(recorded)
        return by_pair

    @cached_property
    def first_time(self) -> float:
        """The earliest clock of the recording, s."""
        times = [float(run.time.min()) for run in self.runs if run.time is not None and run.time.size]
        return min(times, default=0.0)

    @cached_property
    def held(self) -> Held:
        """What the runs can decide, as every command says it."""
        return evidence_of(self.runs)

    @cached_property
    def holds(self) -> dict[Need, bool]:
        """What effects need of a recording, and whether it is there."""
        tubes = [joint.middle for joint in self.joints.values()]
        return {
            "stroke": self.runs[0].stroke is not None,
            "time": self.held.has_clock,
            "release": self.held.has_release,
            "pairs": len(self.joints) > 1 or any(np.ptp(tube.depth) > 0.0 for tube in tubes),
            "rates": self.held.has_rates,
            "outer": any(joint.outer is not None for joint in self.joints.values()),
            "linear_tubes": not any(has_own_curve(joint) for joint in self.joints.values()),
            "runs": sum(bool(rows.any()) for rows in self.train) >= int(FEWEST_RUNS_TO_DIFFER),
            "witness": self.tension_noise is not None,
            "period": self.swing is not None,
            "flat_end": any(one.clipped.any() or one.flat_end for one in self.faults),
            "frozen": self.frozen_fraction > 0.0,
            "load": self._has_load,
            "far_end": self.tension_noise is not None or (self.device is not None and self._has_load),
            "force": self.runs[0].kind == "force",
        }

    @cached_property
    def _has_load(self) -> bool:
        return all(one.history.load is not None for several in self.histories.values() for one in several)

    @property
    def frozen_fraction(self) -> float:
        """The fraction of rows that repeat the frame before them; a device without tubes stands still in its play too."""
        if self.device is not None:
            return 0.0
        return sum(int(one.frozen.sum()) for one in self.faults) / max(sum(len(run) for run in self.runs), 1)

    @property
    def swing(self) -> Swing | None:
        """What swings with a period of its own in most of the runs, or None."""
        found = [one.swing for one in self.faults if one.swing is not None]
        return found[0] if 2 * len(found) >= len(self.runs) else None

    @cached_property
    def fitted_runs(self) -> tuple[JointRun, ...]:
        """Runs with rows that are fitted: nothing that a verdict rests on is taken from the others."""
        return tuple(run for run, rows in zip(self.runs, self.train, strict=True) if rows.any()) or self.runs

    @cached_property
    def noise_estimate(self) -> NoiseEstimate:
        """What the recording itself says of its noise, whatever the model."""
        from coast_cli.recordings.noise import recording_noise

        return recording_noise(self.fitted_runs, self.given_noise)

    @property
    def highest_floor(self) -> float:
        """The highest noise level that the recording leaves possible, SI: slow noise counted in full, within reason."""
        estimate = self.noise_estimate
        generous = float(estimate.level * np.exp(min(estimate.log_level_std, FLOOR_DOUBT)))
        return min(max(generous, self.floor), SLOW_NOISE * self.floor)

    @cached_property
    def floor(self) -> float:
        """The noise level that the recording itself shows, SI, generous by its own uncertainty."""
        estimate = self.noise_estimate
        generous = float(estimate.level * np.exp(min(estimate.log_level_std, FLOOR_DOUBT)))
        # Second differences of AR(1) noise have variance 6 - 8 rho + 2 rho^2; kinks of the signal can only raise both.
        rho = min(estimate.correlation, 0.97)
        from_differences = self.noise * np.sqrt(6.0 / (6.0 - 8.0 * rho + 2.0 * rho**2))
        if estimate.quantum > 0.5 * self.noise:
            return max(generous, 1e-15)
        return max(min(generous, float(DIFFERENCES_MARGIN * from_differences)), 1e-15)

    def configured(self) -> FloatArray:
        """Return the base parameters as configured, in fit coordinates (p,)."""
        return configured_coordinates(self.base)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of the base parameters in fit coordinates, each (p,)."""
        return bounds_of(self.base)

    def values(self, coordinates: FloatArray) -> dict[str, float]:
        """Return the base parameters in user units from fit coordinates."""
        return {p.name: p.outer(c) for p, c in zip(self.base, coordinates, strict=True)}

    def predict(self, coordinates: FloatArray, effects: Sequence[Effect]) -> list[Prediction]:
        """Return the prediction of every run in order, from base parameters in fit coordinates."""
        return self.predict_with(self.values(coordinates), effects)

    def predict_with(self, values: Mapping[str, float], effects: Sequence[Effect]) -> list[Prediction]:
        """Return the prediction of every run in order, from base parameters in user units; those not given stay."""
        if self.device is not None:
            return self._predict_device(self.device.with_values(values), effects)
        found: dict[int, Prediction] = {}
        for pair, recorded in self.histories.items():
            joint = with_base(self.joints[pair], values)
            histories = [one.history for one in recorded]
            predicted = predict(joint, (*self.fixed_effects, *effects), histories, self.layouts[pair], self.tables)
            for one, whole in zip(recorded, predicted, strict=True):
                found[one.run] = Prediction(whole.response[one.rows], whole.tension[one.rows])
        return [found[index] for index in range(len(self.runs))]

    def _predict_device(self, device: Transmission, effects: Sequence[Effect]) -> list[Prediction]:
        recorded = [one for several in self.histories.values() for one in several]
        whole = predict_device(device, (*self.fixed_effects, *effects), [one.history for one in recorded])
        found = {
            one.run: Prediction(response[one.rows], np.zeros(one.rows.size))
            for one, response in zip(recorded, whole, strict=True)
        }
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
        slowest = 1.0 if self.device is None else float(SLOWEST_NOISE_OF_DEVICES)
        return NoiseBank([rows for _, _, rows in self.sequences], slowest=slowest)

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
        return _joined([required(self.runs[i].tension)[rows] for i, rows in self.tension_sequences])

    def fitted(self, predictions: Sequence[Prediction]) -> tuple[FloatArray, FloatArray]:
        """Return the predictions of the fitted responses and tensions, in the order of ``observed``."""
        response = _joined([predictions[i].response[rows, column] for i, column, rows in self.sequences])
        tension = _joined([predictions[i].tension[rows] for i, rows in self.tension_sequences])
        return response, tension

    def scales(self) -> dict[Scale, float]:
        """Return the largest curvature, strain, tension and so on that the recording reaches at configured values."""
        return scales_of(self)

    @cached_property
    def refitted(self) -> Fit:
        """The base model, fitted to the rows that are fitted."""
        return fit(self)

    @cached_property
    def reached(self) -> dict[Scale, float]:
        """The scales, found once."""
        return self.scales()

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """The response and, where it was recorded beside a stroke, the tension."""
        size = self.observed.size
        response = Channel(slice(0, size), self.bank, self.noise)
        if self.tension_noise is None:
            return (response,)
        tension = Channel(slice(size, size + self.observed_tension.size), self.tension_bank, self.tension_noise)
        return response, tension

    @property
    def effort(self) -> Effort:
        """How wide to search."""
        return EFFORT if self.device is None else DEVICE_EFFORT

    @property
    def noise_floor(self) -> float:
        """The noise level that the recording itself shows, SI, down to which sets of effects may grow."""
        return min(self.floor, max(self.noise_estimate.level, 1e-15))

    @property
    def misfit(self) -> float:
        """Factor on variances for the smooth misfit of every record: more samples do not average it out."""
        return 1.0 + SMOOTH_MISFIT**2 * self.observed.size / SMOOTH_MISFIT_SHAPES

    def space(self, effects: Sequence[Any]) -> ParameterSpace:
        """Return what a fit of these effects moves."""
        return joint_space(self, tuple(effects))

    def residuals(self, points: Sequence[Point]) -> list[FloatArray]:
        """Return recorded less predicted responses and then tensions at each point."""
        seen = np.concatenate([self.observed, self.observed_tension])
        return [seen - np.concatenate(self.fitted(self.predict(*point))) for point in points]

    def candidates(self, parent: Sequence[Any]) -> list[Contender]:
        """Return what may be added to a set."""
        return joint_candidates(self, {effect.id for effect in parent})

    def ordered(self, effects: Sequence[Any]) -> tuple[Any, ...]:
        """Return effects in the order in which they act."""
        return in_order(effects)

    def variant(self, effect: Any) -> Variant:  # noqa: ANN401
        """Return an effect's id, and the run that was chosen for it."""
        return effect.id, float(getattr(effect, "run", 0.0))

    def two_sided(self, effect: Any) -> bool:  # noqa: ANN401
        """Return whether every size may take either sign."""
        return all(p.low < p.null for p in effect.parameters if p.role == "size")

    def scaled(self, effect: Any, amount: float) -> Any:  # noqa: ANN401
        """Move the sizes of an effect by a linear estimate, inside their ranges."""
        factor = float(np.copysign(np.clip(abs(amount), 0.1, 4.0), amount))
        values = []
        for p, value in zip(effect.parameters, effect.values(), strict=True):
            margin = 1e-6 * (p.high - p.low)
            moved = float(np.clip(p.null + (value - p.null) * factor, p.low + margin, p.high - margin))
            values.append(moved if p.role == "size" else value)
        return effect.with_values(np.array(values))

    def prior_penalty_nats(self, effects: Sequence[Any]) -> float:
        """Return by how much a set starts behind."""
        return float(sum(effect.unlikely for effect in effects))

    def most_effects(self) -> int:
        """Return how many effects can be supported: one curve can be drawn by any three knees, many notches cannot."""
        if self.runs[0].kind == "notch":
            return 5
        return 2 if self.tension_noise is None else 3

    def is_needed(self, larger: Fit, smaller: Fit, base: Fit) -> bool:
        """Return whether a larger set changes enough, and more than one sample: an outlier is no effect.

        What the line of a device leaves is no noise: an effect must take a part of it, not only make it smoother.
        """
        if self.device is not None and larger.rmse > (1.0 - LEAST_TAKEN_OF_DEVICES) * smaller.rmse:
            return False
        change, gain = 0.0, []
        for before, after, evidence in zip(smaller.residuals, larger.residuals, larger.evidences, strict=True):
            level = max(evidence.level, 1e-15)
            change = max(change, rms(after - before) / level)
            gain.append((before**2 - after**2) / level**2)
        gains = np.concatenate(gain)
        total = float(np.sum(gains))
        return change >= SMALLEST and (total <= 0.0 or float(gains.max()) < ONE_SAMPLE_SHARE * total)

    def only(self, train: Sequence[Booleans]) -> JointProblem:
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
    if "wrap_angle_rad" in values:
        changes["wrap_angle"] = values["wrap_angle_rad"]
    if "deadband_mm" in values:
        changes["deadband"] = values["deadband_mm"] * MILLIMETRE
    tendon = joint.tendon
    if tendon is not None and "tendon_youngs_modulus_gpa" in values:
        tendon = replace(tendon, youngs_modulus=values["tendon_youngs_modulus_gpa"] * GIGAPASCAL)
    if tendon is not None and "tendon_length_mm" in values:
        tendon = replace(tendon, length=values["tendon_length_mm"] * MILLIMETRE)
    return replace(joint, tendon=tendon, **changes)  # type: ignore[arg-type]


def _joined(parts: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros(0)


def required(values: FloatArray | None) -> FloatArray:
    """Return a tension that must be there."""
    if values is None:
        raise ValueError("a tension witness was expected")
    return values
