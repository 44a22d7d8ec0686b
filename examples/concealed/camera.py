"""What the camera makes of the notches' bends: a circle through points or a tip angle, late, distorted, noisy."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, object]]


def circle_curvature(theta: Array, weight: float, length: Array) -> Array:
    """Curvature (1/m) of the circle fitted to the segment's points, for notch bends `theta` [time, notch] (rad).

    A free least-squares circle weighs the curvature along a nearly circular arc with 30 s^2 (1 - s)^2, the influence
    function of a parabola's second derivative; for a uniform bend it is the curvature itself.
    """
    notches = theta.shape[1]
    s = (np.arange(notches) + 0.5) / notches
    share = s**2 * (1 - s) ** 2
    return theta @ (share / share.sum()) * notches * weight / length


def observe(
    theta: Array,
    weight: float,
    length: Array,
    time: Array,
    simulated: float,
    kind: str,
    effects: Effects,
) -> Array:
    """Return the response [time, k] in 1/m (curvature) or degrees (bend, notch), late or distorted by an effect."""
    if kind == "curvature":
        seen = circle_curvature(theta, weight, length)[:, None]
        if "wire_pull_coupling" in effects:
            # The camera takes the segment for as long as it was before the wire pulled.
            seen = seen * (length / simulated)[:, None]
    elif kind == "bend":
        # Bend is curvature times length; a segment that the wire pulls longer bends more.
        seen = np.degrees(theta.sum(axis=1) * weight * length / simulated)[:, None]
    else:
        seen = np.degrees(theta)
    if lag := effects.get("sensor_lag"):
        seen = _late(seen, time, str(lag["law"]), float(lag["time_constant_s"]))  # type: ignore[arg-type]
    if ringing := effects.get("ringing"):
        seen = _ring(seen, time, float(ringing["period_s"]), float(ringing["damping"]))  # type: ignore[arg-type]
    if lens := effects.get("lens_rolling"):
        full = float(np.abs(seen).max())
        seen = seen + lens["amplitude"] * np.sin(2 * np.pi * lens["turns"] * seen / full + lens["phase_rad"])
    if flat := effects.get("lens_compression"):
        seen = seen * (1 - flat["loss"] * (np.abs(seen) / flat["full"]) ** (flat["power"] - 1))
    if scale := effects.get("camera_scale"):
        seen = seen * scale["scale"] * (1 + scale["perspective"] * seen / scale["full"])
    if offset := effects.get("camera_offset"):
        full = max(float(np.abs(seen).max()), 1e-9)
        seen = seen + offset["offset"] * (1 + offset["tilt"] * seen / full)
    if walk := effects.get("camera_walk"):
        path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(theta.sum(axis=1))))]) * weight
        seen = seen + walk["walk"] * (path / (walk["full"] * simulated))[:, None]
    if bump := effects.get("camera_bump"):
        seen = seen + bump["step"] * (time - time[0] >= bump["at_share"] * (time[-1] - time[0]))[:, None]
    return seen


def _late(seen: Array, time: Array, law: str, tau: float) -> Array:
    """Return the response late by a queue of frames that grows and shrinks, a shutter, or two filters in a row."""
    if law == "queue":
        late = tau * (1 + 0.3 * np.sin(2 * np.pi * time / (23 * tau)))
        return np.column_stack([np.interp(time - late, time, column) for column in seen.T])
    if law == "exposure":
        # An open shutter of two time constants: the mean of what went by.
        back = np.linspace(0, 2 * tau, 17)
        return np.column_stack([np.interp(time[:, None] - back, time, column).mean(axis=1) for column in seen.T])
    stages = 2
    for _ in range(stages):
        out = seen.copy()
        for k in range(1, time.size):
            # First-order filter, exact for an input that is linear between the times.
            dt, rate = time[k] - time[k - 1], tau / stages
            decay = np.exp(-dt / rate)
            ramp = (seen[k] - seen[k - 1]) / dt
            out[k] = seen[k] - ramp * rate + (out[k - 1] - seen[k - 1] + ramp * rate) * decay
        seen = out
    return seen


def _ring(seen: Array, time: Array, period: float, damping: float) -> Array:
    from scipy.signal import lsim

    fine = np.linspace(time[0], time[-1], 8 * time.size)
    omega = 2 * np.pi / period
    columns = []
    for column in seen.T:
        drive = np.interp(fine, time, column) - column[0]
        out = lsim(([omega**2], [1, 2 * damping * omega, omega**2]), drive, fine - fine[0])[1]
        columns.append(np.interp(time, fine, out) + column[0])
    return np.column_stack(columns)


NOISE_KINDS = ("white", "ar", "drift", "quantised", "slow")


def draw_noise(rng: np.random.Generator, *, slow: bool = False) -> dict[str, object]:
    """Return a kind of camera noise, its colour, and how often a frame is an outlier or lost.

    With `slow` a sixth of the recordings have noise whose memory is a fifth of a branch.
    """
    kind = str(rng.choice(NOISE_KINDS, p=[0.34, 0.25, 0.12, 0.12, 0.17] if slow else [0.4, 0.3, 0.15, 0.15, 0.0]))
    return {
        "kind": kind,
        "slow_share": round(rng.uniform(0.5, 1.0), 3) if kind == "slow" else 0.0,
        "correlation": round(rng.uniform(0.3, 0.95), 3) if kind == "ar" else 0.0,
        "quantum_sigmas": round(rng.uniform(1.0, 3.2), 2) if kind == "quantised" else 0.0,
        "outlier_share": round(rng.uniform(0.003, 0.02), 4) if rng.random() < 0.2 else 0.0,
        "dropped_share": round(rng.uniform(0.005, 0.05), 4) if rng.random() < 0.2 else 0.0,
    }


def noisy(truth: Array, sigma: float, noise: Mapping[str, object], rng: np.random.Generator, branch: int) -> Array:
    """`truth` [row, k] with noise of standard deviation `sigma`; a lost frame is NaN.

    `branch` is the number of rows between two reversals, which slow noise is slow against.
    """
    rows, columns = truth.shape
    kind = noise["kind"]
    unit = rng.standard_normal((rows, columns))
    if kind == "ar":
        rho = float(noise["correlation"])  # type: ignore[arg-type]
        from scipy.signal import lfilter

        unit[1:] *= np.sqrt(1 - rho**2)
        unit = lfilter([1.0], [1.0, -rho], unit, axis=0)
    elif kind == "drift":
        # A random walk held by reflection at one sigma, on top of white noise of eight tenths.
        walk = np.cumsum(rng.standard_normal((rows, columns)) * 0.08, axis=0) + rng.uniform(-1, 1, columns)
        unit = 0.8 * unit + np.abs((walk + 1) % 4 - 2) - 1
    elif kind == "slow":
        unit = _slow(unit, float(noise["slow_share"]), max(0.2 * branch, 2.0), rng)  # type: ignore[arg-type]
    out = truth + sigma * unit
    if kind == "quantised":
        quantum = sigma * float(noise["quantum_sigmas"])  # type: ignore[arg-type]
        fine = np.sqrt(max(1 - float(noise["quantum_sigmas"]) ** 2 / 12, 0.1))  # type: ignore[arg-type]
        out = np.round((truth + sigma * fine * unit) / quantum) * quantum
    wild = rng.random(rows) < float(noise["outlier_share"])  # type: ignore[arg-type]
    out[wild] += sigma * (
        rng.choice([-1.0, 1.0], (int(wild.sum()), columns)) * rng.uniform(6, 25, (int(wild.sum()), columns))
    )
    out[rng.random(rows) < float(noise["dropped_share"])] = np.nan  # type: ignore[arg-type]
    return out


def _slow(unit: Array, share: float, memory: float, rng: np.random.Generator) -> Array:
    """Return white noise of which `share` (of the power) is replaced by noise with a memory of so many rows."""
    from scipy.signal import lfilter

    rho = float(np.exp(-1 / memory))
    walk = rng.standard_normal(unit.shape)
    walk[1:] *= np.sqrt(1 - rho**2)
    return np.sqrt(1 - share) * unit + np.sqrt(share) * lfilter([1.0], [1.0, -rho], walk, axis=0)
