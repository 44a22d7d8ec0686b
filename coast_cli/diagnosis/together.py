"""Joint and shapes of the same tubes in one call: what the shapes find in the tubes is carried over to the joint.

The shapes are diagnosed first. What they find in the tubes themselves (notch depths, the end effect, the section) is put
into the joint's configuration, and the joint is diagnosed with it. How much of it the strokes want by themselves, with
the base refitted, is a second, separate measurement of the same numbers; the two are compared and combined by their
variances. Where the strokes contradict the shapes, nothing is carried over, and that is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.diagnosis.answer import Carried, Diagnosis, Level, Shared, Value
from coast_cli.diagnosis.asked import Asked
from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.errors import errors_of
from coast_cli.diagnosis.joint.holdout import hold_out
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.model_file import model_text
from coast_cli.diagnosis.shapes import diagnose_shapes
from coast_cli.diagnosis.thresholds import AGREE_SIGMA, CARRIES_TO_JOINT
from coast_cli.effects.catalogue import CATALOGUE
from coast_cli.effects.effect import Effect
from coast_cli.effects.stages import OnTubes
from coast_cli.spec.load import load_config_text

if TYPE_CHECKING:
    from coast_cli.recordings.model import Recordings
    from coast_cli.spec.config import Config

_TAUGHT = ("physics", "parameters")  # verdicts of shapes that name something for certain


def diagnose_together(config: Config, recordings: Recordings, asked: Asked) -> Diagnosis:
    """Return the diagnosis of the joint, with that of the shapes and what both share in ``carried``.

    Raises:
        BadInput: as of a joint and of shapes alone.
    """
    if recordings.joint is None or recordings.shape is None:
        raise ValueError("both kinds of recordings are expected")
    runs = recordings.joint.runs
    of_joint = asked.of_runs([run.name for run in runs])
    of_shapes = asked.of_runs([run.name for run in recordings.shape.runs])
    own = of_joint.hold_out
    shapes = diagnose_shapes(config, recordings.shape.runs, **of_shapes.options)
    without = _Levels(config, recordings, own)
    found = [effect for effect in shapes.effects if _in_the_tubes(effect.id)]
    if not found or shapes.verdict not in _TAUGHT:
        joint = diagnose_joint(config, runs, **of_joint.options)
        return replace(joint, carried=Carried(shapes, _modulus(shapes, without)))
    taught_config = taught(config, shapes, recordings)
    taught_levels = _Levels(taught_config, recordings, own)
    share = _share_wanted(
        without, _Levels(taught(config, shapes, recordings, share=0.5), recordings, own), taught_levels
    )
    agree = share is None or abs(share.value - 1.0) < AGREE_SIGMA * share.std
    used = agree and taught_levels.held(1) < CARRIES_TO_JOINT * without.held(1)
    joint = diagnose_joint(taught_config if used else config, runs, **of_joint.options)
    rows = [
        _shared(f"{effect.id}.{name}", value, share)
        for effect in found
        for name, value in effect.parameters.items()
        if value.std > 0.0
    ]
    shared = (*rows, *_modulus(shapes, taught_levels if used else without))
    carried = Carried(shapes, shared, without.levels, taught_levels.levels, taught_config if used else None)
    return replace(joint, carried=carried)


def taught(config: Config, shapes: Diagnosis, recordings: Recordings, *, share: float = 1.0) -> Config:
    """Return the configuration corrected by the shapes, with a share of what they found in the tubes.

    Effects of bench and camera that joints have too (a tip load, a camera's scale) belong to another bench.
    """
    effects = [
        effect for effect in shapes.model_effects if "joint" not in effect.recordings or _in_the_tubes(effect.id)
    ]
    scaled = [_scaled(effect, share) if _in_the_tubes(effect.id) else effect for effect in effects]
    tubes = {key: _between(config, key, number, share) for key, number in shapes.model_tubes.items()}
    corrected = replace(shapes, model_effects=tuple(scaled), model_tubes=tubes)
    name = f"{config.source or '<text>'} corrected by its shapes"
    return load_config_text(model_text(config, corrected, recordings, name), name)


def _in_the_tubes(identifier: str) -> bool:
    return issubclass(CATALOGUE.get(identifier, Effect), OnTubes)


def _scaled(effect: Any, share: float) -> Any:  # noqa: ANN401
    return effect.with_fitted(share * effect.fitted_values())


def _between(config: Config, key: str, number: float | list[float], share: float) -> float | list[float]:
    """Return a tube's number between the configured and the corrected one."""
    from coast_cli.spec.build import build
    from coast_cli.units import MILLIMETRE

    _, _, name, quantity = key.split(".")
    tube = build(config).tube(name)
    before = np.asarray(tube.depth if quantity == "depth_mm" else tube.end_length) / MILLIMETRE
    values = before + share * (np.asarray(number) - before)
    return float(values.flat[0]) if isinstance(number, float) and np.ptp(values) == 0.0 else values.tolist()


class _Levels:
    """The joint's base model under a configuration: as configured and refitted, on fitted and held-out rows."""

    def __init__(self, config: Config, recordings: Recordings, named: Sequence[str]) -> None:
        runs = recordings.joint.runs if recordings.joint is not None else ()
        kept_back = hold_out(runs, named)
        self.problem: JointProblem = build_joint_problem(config, runs, kept_back.rows)
        self.fit: Fit = fit(self.problem)
        found = []
        for coordinates in (self.problem.configured(), self.fit.coordinates):
            train = errors_of(self.problem, coordinates, (), self.problem.train)
            out = (
                errors_of(self.problem, coordinates, (), kept_back.rows)
                if any(r.any() for r in kept_back.rows)
                else None
            )
            found.append(Level(train.response, None if out is None else out.response))
        self.levels: tuple[Level, Level] = (found[0], found[1])

    def held(self, place: int) -> float:
        """Return the error that counts: held out, or fitted where nothing was."""
        level = self.levels[place]
        return level.train if level.held_out is None else level.held_out


def _share_wanted(none: _Levels, half: _Levels, whole: _Levels) -> Value | None:
    """Return how much of what the shapes found the strokes want, the base refitted at each; None where they cannot tell.

    With the base refitted, the residual is to first order linear in the share: least squares between 0, 1/2 and 1.
    """
    best = min((none, half, whole), key=lambda one: one.fit.rmse)
    bank, evidence = best.problem.bank, best.fit.evidence
    white = [bank.whiten(one.fit.residual, evidence.colour) / max(evidence.level, 1e-15) for one in (none, half, whole)]
    slope = white[2] - white[0]
    size = float(slope @ slope)
    if size < 1.0:
        return None
    middle = (white[0] + white[1] + white[2]) / 3.0
    value = 0.5 - float(slope @ middle) / size
    doubt = max(float(np.mean(white[[none, half, whole].index(best)] ** 2)), 1.0)
    return Value(value, float(np.sqrt(doubt / size)), at_bound=False)


def _shared(name: str, shapes: Value, share: Value | None) -> Shared:
    if share is None:
        return Shared(name, shapes, None, None, agree=None)
    return _combined(name, shapes, Value(share.value * shapes.value, share.std * abs(shapes.value), at_bound=False))


def _combined(name: str, one: Value, other: Value) -> Shared:
    weights = np.array([one.std, other.std]) ** -2.0
    value = float(weights @ [one.value, other.value] / weights.sum())
    apart = abs(one.value - other.value) / float(np.hypot(one.std, other.std))
    both = Value(value, float(weights.sum() ** -0.5), at_bound=False)
    return Shared(name, one, other, both, agree=bool(apart < AGREE_SIGMA))


def _modulus(shapes: Diagnosis, joint: _Levels) -> tuple[Shared, ...]:
    """Return the modulus as a share of the configured one, by shapes and strokes; each kind keeps a number of its own."""
    moduli = [key for key in shapes.parameters if key.endswith(".youngs_modulus_gpa")]
    place = [parameter.name for parameter in joint.problem.base].index("youngs_modulus_gpa")
    if len(moduli) != 1:
        return ()
    seen, before = shapes.parameters[moduli[0]], shapes.configured[moduli[0]]
    std = float(np.sqrt(max(joint.fit.covariance[place, place], 0.0)))
    ratio = float(np.exp(joint.fit.coordinates[place])) / joint.problem.base[place].value
    if not (seen.std > 0.0 and std > 0.0):
        return ()
    one, other = (
        Value(seen.value / before, seen.std / before, at_bound=False),
        Value(ratio, ratio * std, at_bound=False),
    )
    return (_combined("youngs_modulus_over_configured", one, other),)
