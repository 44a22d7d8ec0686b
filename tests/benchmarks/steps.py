"""Processor time of one step of a joint in a control loop: ``python tests/benchmarks/steps.py``."""

from pathlib import Path
from time import process_time

import numpy as np

from coast_cli.design.joint_state import JointState
from coast_cli.effects.catalogue import build_effects
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

STEPS = 20_000
CORRECTIONS = {
    "none": {},
    "backlash, capstan": {"backlash": {"width_mm": 0.1}, "capstan_hysteresis": {"pulley_friction": 0.2}},
    "capstan, rounded": {"capstan_hysteresis": {"pulley_friction": 0.2, "spread": 0.5}},
    "friction, uneven": {"coulomb_friction": {"holds_per_m": 6.0, "spread": 0.4}},
    "friction along": {"distributed_notch_friction": {"coefficient": 0.4}},
}


def main() -> None:
    """Print a line for each set of corrections."""
    joint = build(load_config(Path(__file__).parents[2] / "configs" / "tubes.toml")).joint()
    phase = np.linspace(0.0, 60.0, STEPS)
    strokes, lengths = (2.4e-3 - 2.4e-3 * np.cos(phase)).tolist(), (0.03 + 0.01 * np.sin(0.3 * phase)).tolist()
    for name, corrections in CORRECTIONS.items():
        state = JointState(joint, build_effects(corrections), bending_lengths=(0.02, 0.04))
        begun = process_time()
        for stroke, length in zip(strokes, lengths, strict=True):
            state.step(1e-3, stroke, length)
        print(f"{name}: {1e6 * (process_time() - begun) / STEPS:.1f} microseconds a step")


if __name__ == "__main__":
    main()
