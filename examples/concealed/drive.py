"""Where the tendon's proximal end really is: what screw, belt, stage and motor make of the commanded stroke."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from examples.concealed.faults import breathing
from examples.concealed.friction import Array, rolling_play

Effects = Mapping[str, Mapping[str, object]]


def actuator_position(position: Array, time: Array, effects: Effects, run: int = -1) -> Array:
    """Return the position (m) of the tendon's end at every simulated `time` (s), for the commanded `position` (m).

    `run` is the number of the run, for faults of one run.
    """
    commanded = position
    begin, span = float(time[0]), max(float(np.ptp(position)), 1e-9)
    if screw := effects.get("leadscrew_pitch_error"):
        phase = 2 * np.pi * commanded / (screw["period_mm"] * 1e-3) + screw["phase_rad"]
        wave = np.sin(phase + screw["lean"] * np.sin(phase)) * (
            1 + screw["wear"] * (commanded - commanded.min()) / span
        )
        position = position + screw["amplitude_um"] * 1e-6 * wave
    if wrinkle := effects.get("wrinkled_sheath"):
        turns = (np.maximum(commanded, 0) / (wrinkle["span_mm"] * 1e-3)) ** wrinkle["exponent"] * wrinkle["turns"]
        position = position + wrinkle["amplitude_um"] * 1e-6 * np.sin(2 * np.pi * turns)
    if slip := effects.get("drive_speed_slip"):
        speed = np.gradient(commanded, time) * 1e3
        position = position - slip["slip_um"] * 1e-6 * speed / (slip["knee_mm_per_s"] + np.abs(speed))
    if loss := effects.get("drive_path_loss"):
        path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(commanded)))]) / span
        position = position - loss["loss_um_per_mm"] * 1e-3 * span * path ** loss["exponent"]
    if walk := effects.get("drive_zero_walk"):
        position = position + walk["walk_um"] * 1e-6 * ((time - begin) / (time[-1] - begin)) ** walk["exponent"]
    if lost := effects.get("backlash"):
        position = rolling_play(position, lost["width_mm"] * 1e-3, lost["rolling"])
    if (zero := effects.get("run_differs_zero")) and zero["run"] == run:
        position = position + zero["zero_mm"] * 1e-3
    if (steps := effects.get("lost_steps")) and steps["run"] == run:
        for share, part in zip(steps["at_shares"], steps["parts"], strict=True):
            position = position - steps["lost_mm"] * 1e-3 * part * (time >= begin + share * (time[-1] - begin))
    if (swing := effects.get("periodic_disturbance")) and swing["acts_on"] == "drive":
        position = position + swing["amplitude"] * span * breathing(time, swing)
    return position
