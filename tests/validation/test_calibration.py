"""Round trips: simulate, write, read, calibrate; and a real wrist, its trials held out in turn.

``pytest tests/validation/test_calibration.py -s`` prints the coverage of the 90 % intervals.
"""

from pathlib import Path

import numpy as np
import pytest

from coast_cli.diagnosis.joint.calibration import calibrate
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config, load_config_text

CASES = 200
WRIST = Path(__file__).parents[3] / "shared" / "recordings" / "notched_wrist"


def random_case(seed, folder):
    """Write a recording of a joint with random parameters, runs, sampling and noise; return (file, truth)."""
    rng = np.random.default_rng([2, seed])
    config = load_config(REFERENCE)
    truth = {
        "youngs_modulus_gpa": rng.uniform(35.0, 60.0),
        "notch_friction": rng.uniform(1.003, 1.012),
        "deadband_mm": rng.uniform(0.5, 2.0),
    }
    text = REFERENCE.read_text(encoding="utf-8")
    for key, value in truth.items():
        old = next(line for line in text.splitlines() if line.startswith(key) and line in text.split("[joint]")[1])
        text = text.replace(old, f"{key} = {value!r}")
    outer, middle = f"OT{rng.integers(1, 5)}", f"MT{rng.integers(1, 4)}"
    joint = build_joint(load_config_text(text), outer, middle)
    lengths = rng.permutation(np.round(np.linspace(18.0, 42.0, rng.integers(2, 6)), 4))
    count = int(rng.integers(60, 250))
    memory = rng.choice([0.0, 0.0, rng.uniform(0.0, 0.7)])
    level = rng.uniform(0.05, 0.6)
    rows = []
    for number, length in enumerate(lengths):
        ramp = np.linspace(truth["deadband_mm"] + 0.05, rng.uniform(3.0, 5.0), count)
        stroke = np.round(np.sort(ramp + rng.normal(0.0, 0.02, count).clip(-0.03, 0.03)), 5)
        history = History(None, stroke * 1e-3, None, np.full(count, length * 1e-3))
        response = predict(joint, (), [history], Layout("curvature", 1, 120.0))[0].response[:, 0]
        noise = rng.normal(size=count)
        for index in range(1, count):
            noise[index] = memory * noise[index - 1] + np.sqrt(1.0 - memory**2) * noise[index]
        response = response + level * noise
        rows += [
            f"r{number},{outer},{middle},{length:.4f},{s:.5f},{k:.6f}\n" for s, k in zip(stroke, response, strict=True)
        ]
    path = folder / f"case_{seed}.csv"
    path.write_text("run,outer,middle,bending_length_mm,stroke_mm,curvature_per_m\n" + "".join(rows), encoding="utf-8")
    return config, path, truth


def test_intervals_of_random_round_trips_cover(tmp_path):
    inside = {"youngs_modulus_gpa": 0, "notch_friction": 0, "deadband_mm": 0}
    bias = {name: [] for name in inside}
    for seed in range(CASES):
        config, path, truth = random_case(seed, tmp_path)
        calibration = calibrate(config, read_recordings([path], config))
        assert calibration.whole.converged
        assert len(calibration.whole.estimates) == 3
        for estimate in calibration.whole.estimates:
            name = estimate.parameter.name
            inside[name] += estimate.low <= truth[name] <= estimate.high
            bias[name].append(estimate.value / truth[name] - 1.0)
    share = sum(inside.values()) / (3 * CASES)
    for name, number in inside.items():
        print(
            f"{name:20s} in its 90 % interval in {number} of {CASES}; median error {100 * np.median(bias[name]):+.3f} %"
        )
    print(f"{'all three':20s} in {100 * share:.1f} % of {3 * CASES}")
    assert 0.88 <= share <= 0.92
    assert all(abs(np.median(values)) < 0.005 for values in bias.values())


@pytest.mark.skipif(not WRIST.exists(), reason="not here: ../shared/recordings/notched_wrist")
def test_a_real_wrist_is_a_straight_line_within_about_four_degrees_held_out_by_trial():
    config = load_config(WRIST / "tubes.toml")
    squares = count = 0.0
    for wrist in ("A", "C"):
        recordings = read_recordings([WRIST / f"wrist_{wrist}.csv"], config)
        calibration = calibrate(config, recordings, ["youngs_modulus_gpa"], ["each"])
        error = calibration.held_out.calibrated["notch_deg"]
        angles = sum(int(np.isfinite(run.response).sum()) for run in recordings.joint.runs)
        print(f"wrist {wrist}: {error:.2f} degrees over {angles} notch angles, each trial predicted from the others")
        squares, count = squares + angles * error**2, count + angles
    pooled = np.sqrt(squares / count)
    print(f"both: {pooled:.2f} degrees")
    assert 3.5 < pooled < 5.0
