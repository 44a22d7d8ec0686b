"""From a configuration and runs to a problem: which base parameters are free, within which bounds, which samples count."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.outliers import screened
from coast_cli.diagnosis.joint.problem import CONFIG_KEYS, JointProblem, required
from coast_cli.diagnosis.space import BaseParameter, Booleans
from coast_cli.diagnosis.thresholds import (
    DEADBAND_PRIOR,
    FROZEN_SHARE,
    MODULUS_PRIOR,
    NOTCH_FRICTION_PRIOR,
    TENDON_MODULUS_PRIOR,
)
from coast_cli.errors import BadInput
from coast_cli.recordings.evidence import evidence_of
from coast_cli.spec.transmission import TransmissionFields
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.effects.effect import Effect
    from coast_cli.mechanics.joint import Joint
    from coast_cli.mechanics.transmission import Transmission
    from coast_cli.recordings.model import JointRun
    from coast_cli.spec.config import Config

_PRIORS = {
    "youngs_modulus_gpa": MODULUS_PRIOR,
    "notch_friction": NOTCH_FRICTION_PRIOR,
    "deadband_mm": DEADBAND_PRIOR,
    "tendon_youngs_modulus_gpa": TENDON_MODULUS_PRIOR,
}
_LOGARITHMIC = ("youngs_modulus_gpa", "tendon_youngs_modulus_gpa")
FROM_DATA_SHEETS = ("tendon_youngs_modulus_gpa",)
_TRIVIAL = 1e-12
_FLAT = 1e-6  # of its level, that a response must at least move for its line to have a zero
_WIDE = 3.0  # of what a recording spans, for numbers of which nothing is known beforehand


def build_joint_problem(
    config: Config,
    runs: Sequence[JointRun],
    held_out: Sequence[Booleans] | None = None,
    *,
    without: Sequence[str] = (),
    noise: float | None = None,
    trusting: bool = False,
) -> JointProblem:
    """Return the problem of fitting a configuration to runs.

    Args:
        held_out: for each run which rows are not fitted, (n,); none by default.
        without: ids of effects that are neither named nor rivals. noise: of the response, SI, where it is known.
        trusting: whether numbers of data sheets are held as configured.
    """
    from coast_cli.recordings.faults import faults_of, repeating_rows

    held = held_out or [np.zeros(len(run), bool) for run in runs]
    built = _device(config, runs, held) if isinstance(config.joint, TransmissionFields) else _joints(config, runs)
    fitted = [not rows.all() for rows in held]
    drives = [run.drive for run in runs]
    usable, found_noise = screened([run.response for run in runs], drives, fitted)
    faults = tuple(faults_of(run) for run in runs)
    stale = [one.frozen | one.duplicated for one in faults]
    # A device that stands still in its play repeats its rows too.
    if built.device is None and sum(int(rows.sum()) for rows in stale) >= FROZEN_SHARE * sum(len(run) for run in runs):
        # Where frames do repeat, rounding hides some of them.
        usable = [use & ~repeating_rows(run)[:, np.newaxis] for use, run in zip(usable, runs, strict=True)]
    witness = built.device is None and all(run.tension is not None and run.stroke is not None for run in runs)
    if witness:
        columns = [required(run.tension)[:, np.newaxis] for run in runs]
        tension_usable, tension_noise = screened(columns, drives, fitted)
        tension_rows = tuple(use[:, 0] for use in tension_usable)
    else:
        tension_rows, tension_noise = tuple(np.zeros(len(run), bool) for run in runs), None
    return JointProblem(
        runs=tuple(runs),
        joints=built.joints,
        base=built.base or _free_parameters(config, runs, has_witness=witness and not trusting),
        train=tuple(~rows for rows in held),
        usable=tuple(usable),
        tension_usable=tension_rows,
        noise=found_noise if noise is None else noise,
        tension_noise=tension_noise,
        fixed_effects=built.effects,
        faults=faults,
        concealed=frozenset(without),
        given_noise=noise,
        device=built.device,
    )


@dataclass(frozen=True)
class _Built:
    """What a configuration is, with the corrections that it carries; ``base``: its free parameters where they are known."""

    effects: tuple[Effect, ...]
    joints: Mapping[str, Joint] = field(default_factory=dict)
    device: Transmission | None = None
    base: tuple[BaseParameter, ...] = ()


def _joints(config: Config, runs: Sequence[JointRun]) -> _Built:
    from coast_cli.effects.catalogue import build_effects
    from coast_cli.spec.build import build_joint

    joints = {run.pair: build_joint(config, run.outer, run.middle) for run in runs}
    if config.tendon is None and any(run.stroke is not None for run in runs):
        raise config.refuse(("tendon",), "a stroke needs a tendon", allowed="a [tendon] table")
    return _Built(build_effects(config.corrections), joints)


def _device(config: Config, runs: Sequence[JointRun], held_out: Sequence[Booleans]) -> _Built:
    from coast_cli.effects.devices import build_device_effects
    from coast_cli.spec.transmission import build_transmission, takes_response

    fields, first = config.joint, runs[0]
    if not isinstance(fields, TransmissionFields):
        raise TypeError(type(fields))
    if not takes_response(first.kind):
        allowed = "bend_deg, position_mm or force_n"
        raise BadInput(
            "no response of a transmission",
            file=first.source,
            line=int(first.line[0]),
            found=first.kind,
            allowed=allowed,
        )
    by_stroke = first.stroke is not None
    device = build_transmission(fields, first.kind, by_stroke=by_stroke)
    unit = MILLIMETRE if by_stroke else 1.0
    span = max(max(float(np.ptp(run.drive)) for run in runs) / unit, _TRIVIAL)
    bent = max(float(np.nanmax(run.response) - np.nanmin(run.response)) for run in runs) / (device.ratio_unit * unit)
    loads = [load for run in runs if (load := run.carried) is not None]
    carried = float(np.ptp(np.concatenate(loads))) if len(loads) == len(runs) else 0.0
    widths = {"ratio": bent / span, "zero_mm": span}
    if first.kind == "force" and carried > 0.0:
        widths["load_ratio"] = bent * device.ratio_unit * unit / carried
    line = _line(device, runs, held_out, with_load="load_ratio" in widths)
    base = [_of_device(config, name, max(width, _TRIVIAL), line.get(name)) for name, width in widths.items()]
    return _Built(build_device_effects(config.corrections), {}, device, tuple(base))


def _line(
    device: Transmission, runs: Sequence[JointRun], held_out: Sequence[Booleans], *, with_load: bool
) -> dict[str, float]:
    """Return the line through the rows that are fitted, as a configuration names it: a ratio may have either sign."""
    use = [run.valid & ~rows for run, rows in zip(runs, held_out, strict=True)]
    drive, response, load = (
        np.concatenate([values[rows] for values, rows in zip(several, use, strict=True)])
        for several in (
            [run.drive / device.drive_unit for run in runs],
            [run.response[:, 0] / (device.ratio_unit * device.drive_unit) for run in runs],
            [run.carried if with_load and run.carried is not None else np.zeros(len(run)) for run in runs],
        )
    )
    columns = np.stack([drive, np.ones_like(drive), load], axis=1)
    slope, level, by_load = np.linalg.lstsq(columns, response, rcond=None)[0].tolist() if drive.size > 3 else (0.0,) * 3
    if abs(slope) * float(np.ptp(drive, axis=0) if drive.size else 0.0) < _FLAT * float(np.abs(level)):
        return {}
    return {"ratio": slope, "zero_mm": -level / slope, "load_ratio": by_load}


def _of_device(config: Config, name: str, width: float, start: float | None) -> BaseParameter:
    """Return a free number of a transmission: what was recorded says how large it may be, unless bounds are given."""
    value, low, high = config.bounds(CONFIG_KEYS[name])
    given = _given_bounds(config, name)
    prior = _WIDE * (width + abs(value)) if given is None else (high - low) / 4.0
    begun = None if start is None else float(np.clip(start, low, high))
    return BaseParameter(name, value, low, high, max(prior, _TRIVIAL), start=begun)


def _free_parameters(config: Config, runs: Sequence[JointRun], *, has_witness: bool) -> tuple[BaseParameter, ...]:
    """Choose what the recording can tell: strokes and one length only fix products, which the modulus stands for."""
    stroke_driven = runs[0].stroke is not None
    names = ["youngs_modulus_gpa"]
    if evidence_of(runs).has_lengths:
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
        prior = float(_PRIORS[name])
        if given is not None:
            low, high = given
            prior = (np.log(high / low) if name in _LOGARITHMIC else high - low) / 4.0
        found.append(BaseParameter(name, value, low, high, max(prior, _TRIVIAL), name in _LOGARITHMIC))
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
