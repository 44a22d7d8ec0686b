"""A synthetic recording to try `coast diagnose` on: `python examples/diagnose/generate.py` writes its files anew.

Nothing here was measured. Pair OT4/MT1 of configs/tubes.toml is pulled and released four times; the joint follows the
paper's stroke model behind an actuator with play, which that model leaves out. Curvature noise is 0.25 per m and partly
carried from sample to sample. The deadband is a little off from the configured one, as on any bench. foreign.csv is the
same recording as another laboratory might have saved it: its own names, degrees, semicolons, decimal commas, a remark.

cable.csv is another device: a motor that turns a jaw by a cable, at three loads. The cable stretches with the torque of the
jaw, the jaw has play, and the jaw falls as the motor rises.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from coast_cli.mechanics.joint import curvature_from_stroke
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

FOLDER = Path(__file__).parent
CONFIG = FOLDER.parents[1] / "configs" / "tubes.toml"
RECORDING, FOREIGN, CABLE = FOLDER / "recording.csv", FOLDER / "foreign.csv", FOLDER / "cable.csv"

PLAY_MM = 0.18
DEADBAND_MM = 1.12
NOISE_PER_M, CARRIED = 0.25, 0.5
RATE_MM_PER_S = 0.1
# Run, largest stroke (mm), bending length X2 (mm).
RUNS = (("small-20", 2.6, 20.0), ("large-20", 3.8, 20.0), ("small-40", 3.0, 40.0), ("large-40", 4.6, 40.0))
SAMPLES_A_BRANCH = 45
# The cable: degrees of the jaw for one of the motor, play and stretch in degrees of the motor, torques of the jaw in N m.
JAW_RATIO, JAW_PLAY_DEG, STRETCH_DEG_PER_N_M, JAW_NOISE_DEG = -0.9, 2.6, 90.0, 0.15
TORQUES, SAMPLES_A_LOAD = (0.01, 0.04, 0.08, 0.02, 0.06), 120


def play(stroke: np.ndarray, width: float) -> np.ndarray:
    """Return what is left of a stroke behind play: it waits at each reversal until the gap is crossed."""
    left, state = np.empty_like(stroke), stroke[0]
    for index, wanted in enumerate(stroke):
        state = min(max(state, wanted), wanted + width)
        left[index] = state
    return left


def rows() -> list[str]:
    """Return the lines of the recording, the header first."""
    random = np.random.default_rng(20_23)
    joint = replace(build(load_config(CONFIG)).joint(), deadband=DEADBAND_MM * 1e-3)
    lines = ["run,time_s,outer,middle,bending_length_mm,stroke_mm,curvature_per_m"]
    for name, largest, length in RUNS:
        up = np.linspace(0.6, largest, SAMPLES_A_BRANCH)
        stroke = np.concatenate([up, up[-2::-1]])
        time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(stroke)))]) / RATE_MM_PER_S
        bent = curvature_from_stroke(joint, play(stroke, PLAY_MM) * 1e-3, length * 1e-3).curvature
        noise = random.normal(size=stroke.size)
        for index in range(1, noise.size):
            noise[index] = CARRIED * noise[index - 1] + np.sqrt(1.0 - CARRIED**2) * noise[index]
        seen = bent + NOISE_PER_M * noise
        lines += [
            f"{name},{t:.2f},OT4,MT1,{length:g},{x:.4f},{kappa:.3f}"
            for t, x, kappa in zip(time, stroke, seen, strict=True)
        ]
    return lines


def foreign(lines: list[str]) -> list[str]:
    """Return the same recording in another laboratory's table, without the tubes."""
    others = ["trial;t [s];X2 [mm];X1 [mm];bend [deg];remark"]
    for line in lines[1:]:
        run, time, _, _, length, stroke, curvature = line.split(",")
        bend = np.degrees(float(curvature) * float(length) * 1e-3)
        others.append(f"{run};{time};{length};{stroke};{bend:.2f};".replace(".", ","))
    return others


def cable() -> list[str]:
    """Return the lines of the cable's recording: the motor swings twice at each load."""
    random = np.random.default_rng(2018)
    lines = ["time_s,trial,motor_angle_deg,jaw_angle_deg,jaw_torque_n_m"]
    for number, torque in enumerate(TORQUES):
        time = np.linspace(0.0, 20.0, SAMPLES_A_LOAD)
        motor = 30.0 - 30.0 * np.cos(0.2 * np.pi * time + 0.7 * number)
        load = torque * (1.0 + 0.03 * np.sin(0.5 * time))
        pulled = motor - STRETCH_DEG_PER_N_M * load
        inside = play(pulled - 0.5 * JAW_PLAY_DEG, JAW_PLAY_DEG)
        jaw = JAW_RATIO * (inside - 80.0) + random.normal(scale=JAW_NOISE_DEG, size=time.size)
        lines += [
            f"{t:.3f},{100 * torque:g}%,{drive:.3f},{angle:.3f},{moment:.5f}"
            for t, drive, angle, moment in zip(time, motor, jaw, load, strict=True)
        ]
    return lines


if __name__ == "__main__":
    lines = rows()
    FOREIGN.write_text("\n".join(foreign(lines)) + "\n", encoding="utf-8")
    CABLE.write_text("\n".join(cable()) + "\n", encoding="utf-8")
    RECORDING.write_text("\n".join(lines) + "\n", encoding="utf-8")
