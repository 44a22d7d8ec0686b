"""Closed forms of the catalogue, one state each at most: what an ordinary library would fit.

For the other answers only.

A form changes the drive before the base model, or the base curvature after it. Everything is normalised by the
recording's own size so that parameters are of order one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from examples.concealed.refit import START, Rows, base_response, free_parameters

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Data:
    """Rows with what the forms need: times (s), response mean [row], run starts, drive range, fitted rows."""

    rows: Rows
    time: Array
    target: Array
    train: NDArray[np.bool_]

    @property
    def top(self) -> float:
        """Largest response."""
        return float(np.nanmax(np.abs(self.target)))

    @property
    def low(self) -> float:
        """Smallest drive."""
        return float(self.rows.drive.min())

    @property
    def span(self) -> float:
        """Range of the drive."""
        return float(np.ptp(self.rows.drive))

    def runs(self) -> list[NDArray[np.intp]]:
        """Return the row numbers of each run."""
        return [np.flatnonzero(self.rows.run == run) for run in np.unique(self.rows.run)]

    def elapsed(self) -> Array:
        """Return each row's share of its run's duration."""
        out = np.zeros(self.time.size)
        for rows in self.runs():
            out[rows] = (self.time[rows] - self.time[rows[0]]) / max(
                float(self.time[rows[-1]] - self.time[rows[0]]), 1e-9
            )
        return out


def follow(data: Data, values: Array, below: Array, above: Array) -> Array:
    """Return a state that stays inside [below, above] and moves only when pushed, run by run."""
    out = np.empty_like(values)
    for rows in data.runs():
        state = values[rows[0]]
        for i in rows:
            state = min(max(state, below[i]), above[i])
            out[i] = state
    return out


def filtered(data: Data, values: Array, tau: float) -> Array:
    """First-order lag with time constant `tau` as a share of each run's duration."""
    out, elapsed = values.copy(), data.elapsed()
    for rows in data.runs():
        for before, i in pairwise(rows):
            out[i] = values[i] + (out[before] - values[i]) * np.exp(-(elapsed[i] - elapsed[before]) / max(tau, 1e-4))
    return out


def _peak(data: Data, values: Array) -> Array:
    out = np.empty_like(values)
    for rows in data.runs():
        out[rows] = np.maximum.accumulate(values[rows])
    return out


def _snap(data: Data, kappa: Array, p: Array) -> Array:
    out, up, down = kappa.copy(), p[0], p[0] * 0.65
    for rows in data.runs():
        on = False
        for i in rows:
            on = kappa[i] > up * data.top if not on else kappa[i] > down * data.top
            out[i] += p[1] * data.top * on
    return out


def _speed(data: Data) -> Array:
    """Speed of the drive with its sign, over the mean speed."""
    out = np.zeros(data.time.size)
    for rows in data.runs():
        out[rows] = np.gradient(
            data.rows.drive[rows], np.maximum.accumulate(data.time[rows] + 1e-9 * np.arange(rows.size))
        )
    return out / max(float(np.abs(out).mean()), 1e-12)


def _plateaus(data: Data, kappa: Array, p: Array) -> Array:
    """Extra bend between an upper plateau on load and a lower one on release."""
    knee, lower = p[1] * data.top, float(np.clip(p[2], 0.1, 1.0))
    past = np.maximum(kappa - knee, 0)
    return kappa + abs(p[0]) * follow(data, past, past, np.maximum(kappa - lower * knee, 0))


def _moment_power(data: Data, power: int) -> Array:
    """Shape of a bend at rest that grows with a power of the length, in the recording's unit."""
    return (data.rows.length / 0.04) ** (power + (data.rows.kind == "bend"))


def _relative_gain(data: Data) -> Array:
    """Actuator tension for one curvature, over its mean: what tells a limit on tension from one on curvature."""
    gains = np.array([float(joint.gain(1.0)) for joint in data.rows.joints])[data.rows.run] ** data.rows.length
    return gains / gains.mean()


Map = Callable[[Data, Array, Array], Array]
Starts = tuple[tuple[float, ...], ...]
DRIVE: dict[str, tuple[Map, Starts]] = {
    "backlash": (lambda d, x, p: follow(d, x, x, x + abs(p[0]) * d.span), ((0.05,),)),
    "leadscrew_pitch_error": (
        lambda d, x, p: x + d.span * (p[0] * np.sin(2e3 * np.pi * x / p[2]) + p[1] * np.cos(2e3 * np.pi * x / p[2])),
        ((0.01, 0.0, 0.635), (0.0, 0.01, 0.5), (0.01, 0.0, 1.0)),
    ),
    "tendon_creep": (
        lambda d, x, p: x - p[0] * ((x - d.low) - (x - d.low - filtered(d, x - d.low, abs(p[1])))),
        ((0.05, 0.1), (0.05, 0.03)),
    ),
    "tendon_permanent_set": (
        lambda d, x, p: x - p[0] * np.maximum(_peak(d, x) - d.low - p[1] * d.span, 0),
        ((0.05, 0.2),),
    ),
}
RESPONSE: dict[str, tuple[Map, Starts]] = {
    "capstan_hysteresis": (lambda d, k, p: follow(d, k, k, k * np.exp(2 * abs(p[0]))), ((0.05,),)),
    "coulomb_friction": (lambda d, k, p: follow(d, k, k - abs(p[0]) * d.top, k + abs(p[0]) * d.top), ((0.03,),)),
    "tube_superelasticity": (lambda d, k, p: k + abs(p[0]) * np.maximum(k - p[1] * d.top, 0), ((0.2, 0.6), (0.2, 0.4))),
    "tendon_superelasticity": (
        lambda d, k, p: k - abs(p[0]) * np.maximum(k - p[1] * d.top / _relative_gain(d), 0),
        ((0.2, 0.6), (0.2, 0.4)),
    ),
    "notch_closure": (lambda d, k, p: k - abs(p[0]) * np.maximum(k - p[1] * d.top, 0), ((0.2, 0.7), (0.2, 0.5))),
    "snap_through": (_snap, ((0.5, 0.1), (0.65, 0.1))),
    "precurvature": (lambda d, k, p: k + p[0] * d.top * _moment_power(d, 0), ((0.03,),)),
    "camera_offset": (lambda d, k, p: k + p[0] * d.top, ((0.03,),)),
    "tip_load": (lambda d, k, p: k + p[0] * d.top * _moment_power(d, 1), ((0.03,),)),
    "gravity": (lambda d, k, p: k + p[0] * d.top * _moment_power(d, 2), ((0.03,),)),
    "bending_length_offset": (lambda d, k, p: k * (1 + p[0] * 0.01 / d.rows.length), ((0.03,),)),
    "distributed_notch_friction": (lambda d, k, p: k / (1 + np.abs(p[0] * k) / d.top), ((0.1,),)),
    "thermal_drift": (lambda d, k, p: k * (1 + p[0] * d.elapsed()) + p[1] * d.top * d.elapsed(), ((0.03, 0.0),)),
    "sensor_lag": (lambda d, k, p: filtered(d, k, abs(p[0])), ((0.01,), (0.03,))),
    "viscous_friction": (lambda d, k, p: k - abs(p[0]) * d.top * _speed(d) / _relative_gain(d), ((0.03,), (0.1,))),
    "tube_hysteresis": (_plateaus, ((0.2, 0.6, 0.7), (0.2, 0.4, 0.6))),
    "transmission_compliance": (lambda d, k, p: k / (1 + abs(p[0]) * 0.01 / d.rows.length), ((0.1,),)),
}
FORMS = (*DRIVE, *RESPONSE)


@dataclass(frozen=True)
class Fit:
    """A fitted form: its name, the fitted response of every row, residual sum on the fitted rows.

    Number of parameters.
    """

    name: str
    fitted: Array
    rss: float
    parameters: int


def fit_form(name: str | None, data: Data, spread: float | None = None) -> Fit:
    """Return base parameters and one form (or none) fitted by robust least squares to the training rows."""
    from dataclasses import replace

    from scipy.optimize import least_squares

    free = free_parameters(data.rows)
    good = data.train & np.isfinite(data.target)
    spread = spread or max(1.4826 * float(np.median(np.abs(np.diff(data.target[good])))) / np.sqrt(2), 1e-3)

    def model(x: Array) -> Array:
        base = START.copy()
        base[free] = x[: free.size]
        drive, form = data.rows.drive, x[free.size :]
        if name in DRIVE:
            drive = DRIVE[name][0](data, drive, form)
        out = base_response(replace(data.rows, drive=drive), base)
        return RESPONSE[name][0](data, out, form) if name in RESPONSE else out

    starts: Starts = ((),) if name is None else (DRIVE.get(name) or RESPONSE[name])[1]
    best, cost = None, np.inf
    for start in starts:
        fit = least_squares(
            lambda x: (model(x) - data.target)[good] / spread,
            np.concatenate([START[free], start]),
            loss="soft_l1",
            f_scale=3.0,
            x_scale=np.concatenate([np.full(free.size, 0.1), np.full(len(start), 0.1)]),
            max_nfev=25,
        )
        if fit.cost < cost:
            best, cost = fit.x, fit.cost
    fitted = model(best)
    rss = float(np.sum(np.minimum(((fitted - data.target)[good] / spread) ** 2, 36.0)))
    return Fit(name or "none", fitted, rss, len(best))


# Forms that can stand in for another one when the protocol is poor; those that a tension column settles come second.
CLOSE: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "capstan_hysteresis": (("tendon_permanent_set", "sensor_lag"), ("coulomb_friction", "backlash")),
    "coulomb_friction": (("tendon_permanent_set", "sensor_lag"), ("capstan_hysteresis", "backlash")),
    "backlash": (("tendon_permanent_set", "sensor_lag"), ("capstan_hysteresis", "coulomb_friction")),
    "tendon_superelasticity": ((), ("notch_closure",)),
    "notch_closure": ((), ("tendon_superelasticity",)),
    "tendon_creep": (
        ("thermal_drift", "sensor_lag", "tendon_permanent_set", "tendon_superelasticity"),
        ("coulomb_friction",),
    ),
    "tendon_permanent_set": (
        ("thermal_drift", "tendon_creep", "tendon_superelasticity"),
        ("capstan_hysteresis", "coulomb_friction", "backlash"),
    ),
    "snap_through": (("tube_superelasticity", "coulomb_friction"), ()),
    "precurvature": (("camera_offset", "tip_load", "bending_length_offset"), ()),
    "camera_offset": (("precurvature", "tip_load", "bending_length_offset"), ()),
    "tip_load": (("precurvature", "gravity", "camera_offset"), ()),
    "gravity": (("tip_load", "precurvature", "camera_offset"), ()),
    "bending_length_offset": (("camera_offset", "precurvature", "tip_load"), ()),
    "thermal_drift": (("tendon_creep", "tendon_permanent_set", "tendon_superelasticity"), ()),
    "sensor_lag": (("viscous_friction", "coulomb_friction", "capstan_hysteresis", "backlash", "tendon_creep"), ()),
    "viscous_friction": (("sensor_lag", "coulomb_friction", "capstan_hysteresis", "backlash", "tendon_creep"), ()),
    "tube_hysteresis": (("coulomb_friction", "capstan_hysteresis", "backlash", "tube_superelasticity"), ()),
    "transmission_compliance": (("bending_length_offset",), ("tendon_superelasticity",)),
}
EVIDENCE = 30.0


def rivals(name: str, data: Data, sigma: float, correlation: float, *, tension: bool) -> list[str]:
    """Forms that fit a noiseless response about as well as the named effect's own form does.

    As well means: with this noise, coloured as it is, the difference in squared error stays below `EVIDENCE`.
    """
    if name not in CLOSE or name not in FORMS:
        return []
    always, settled = CLOSE[name]
    candidates = always if tension else (*always, *settled)
    if data.rows.kind == "notch":
        candidates = tuple(other for other in settled if other not in ("backlash", "tendon_superelasticity"))
    if not candidates:
        return []
    independent = int(data.train.sum()) * (1 - correlation) / (1 + correlation)
    own = fit_form(name, data, sigma).rss
    return [
        other
        for other in candidates
        if (fit_form(other, data, sigma).rss - own) * independent / data.train.sum() < EVIDENCE
    ]


__all__ = ["FORMS", "Data", "Fit", "fit_form", "rivals"]
