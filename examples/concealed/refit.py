"""The published base model refitted to a response.

What of an effect survives once calibration has had its way with it.

Rows of all runs are fitted together in the three numbers a loading record can fix: stiffness (with the pulley
friction it comes with), friction per notch, deadband.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from examples.concealed.design import Joint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rows:
    """Rows of a recording, run after run: the joint of each run, drive (m or N), nominal length (m)."""

    joints: tuple[Joint, ...]
    run: NDArray[np.int64]
    drive: Array
    length: Array
    kind: str

    def subset(self, keep: NDArray[np.bool_]) -> Rows:
        """Return some of the rows."""
        return replace(self, run=self.run[keep], drive=self.drive[keep], length=self.length[keep])


START = np.array([0.0, 0.0, 0.0])
SCALE = np.array([1.0, 0.01, 1e-3])


def trial_joint(joint: Joint, parameters: Array) -> Joint:
    """Return the joint with (ln stiffness ratio, eta step / 0.01, deadband step in mm) applied."""
    stiffness, eta, deadband = np.asarray(parameters) * SCALE
    return replace(
        joint,
        youngs_modulus=joint.youngs_modulus * np.exp(stiffness),
        notch_friction=joint.notch_friction + eta,
        deadband=joint.deadband + deadband,
    )


def base_tension(rows: Rows, parameters: Array) -> Array:
    """Return the actuator tension (N) of each row by the base model."""
    out = np.empty(rows.drive.size)
    for index, joint in enumerate(rows.joints):
        mine = rows.run == index
        trial = trial_joint(joint, parameters)
        length = rows.length[mine]
        out[mine] = trial.stroke(trial.curvature(rows.drive[mine], length), length)[1]
    return out


def base_response(rows: Rows, parameters: Array) -> Array:
    """Return base response of each row in the recording's unit, for (ln stiffness ratio, eta step / 0.01.

    Deadband step in mm).
    """
    out = np.empty(rows.drive.size)
    for index, joint in enumerate(rows.joints):
        mine = rows.run == index
        if not mine.any():
            continue
        trial = trial_joint(joint, parameters)
        if joint.tendon_radius == 0:
            out[mine] = np.maximum(rows.drive[mine], 0) * trial.arm / (trial.gain(rows.length[mine]) * trial.rigidity)
        else:
            out[mine] = trial.curvature(rows.drive[mine], rows.length[mine])
    if rows.kind == "bend":
        return np.degrees(out * rows.length)
    if rows.kind == "notch":
        return np.degrees(out * np.array([joint.middle.pitch for joint in rows.joints])[rows.run])
    return out


def free_parameters(rows: Rows) -> NDArray[np.int64]:
    """Which of the three numbers the recording can move independently."""
    if rows.joints[0].tendon_radius == 0:
        return np.array([0])
    return np.array([0, 1, 2]) if np.unique(np.round(rows.length, 6)).size > 1 else np.array([0, 2])


def refit(rows: Rows, response: Array) -> tuple[Array, Array]:
    """Return base parameters fitted to `response` [row, k] and the fitted response [row]."""
    from scipy.optimize import least_squares

    free = free_parameters(rows)
    target = np.nanmean(response, axis=1)
    good = np.isfinite(target)
    seen = rows.subset(good)

    def residual(x: Array) -> Array:
        p = START.copy()
        p[free] = x
        return base_response(seen, p) - target[good]

    fit = least_squares(
        residual,
        START[free],
        x_scale=0.1,
        max_nfev=40,
    )
    best = START.copy()
    best[free] = fit.x
    return best, base_response(rows, best)


def surviving(rows: Rows, response: Array) -> float:
    """RMS of what the refitted base model leaves of a noiseless response, in its unit."""
    return float(np.sqrt(np.mean((response - refit(rows, response)[1][:, None]) ** 2)))
