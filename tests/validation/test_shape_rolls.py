"""Assembled pairs that are rolled against each other, by the concealed generator's beam: named, and the angle found."""

from __future__ import annotations

import numpy as np
import pytest

from coast_cli.diagnosis.shapes import diagnose_shapes
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config_text
from examples.concealed.design import Joint, Robot, Tube, config_text
from examples.concealed.shape_scene import Scene, ShapeRun, photograph

MM = 1e-3
NOISE_MM = 0.012
POINTS = 120
MODULUS = 45e9


def _robot(random: np.random.Generator) -> Robot:
    """A soft outer tube, and a middle one whose natural curvature is what a roll turns."""

    def tube(name, od, bore, share, natural):
        return Tube(name, od * MM, bore * MM, round(od * share, 3) * MM, 0.3 * MM, 0.3 * MM, 150, natural)

    outer = tube("OT1", 0.5, 0.4, random.uniform(0.68, 0.76), round(random.uniform(1.0, 4.0), 1))
    middle = tube("MT1", 0.36, 0.28, random.uniform(0.66, 0.74), round(random.uniform(8.0, 12.0), 1))
    drive = Joint(outer, middle, MODULUS, 0.2965, np.pi, 1.0063, 1.2e-3, 0.038e-3, 53.965e9, 0.38868)
    return Robot((outer,), (middle,), drive, (0.2e-3, 0.1e-3))


def _diagnosis(path, roll_deg: float, seed: int):
    random = np.random.default_rng([seed, 8])
    robot, points = _robot(random), np.linspace(0.0, 1.0, POINTS)
    alone = {("s1", True): (0, None), ("s2", False): (0, None), ("s3", True): (None, 0), ("s4", False): (None, 0)}
    pairs = {(f"p{number}", up): (0, 0) for number, up in enumerate((True, False, True))}
    runs = {label: ShapeRun(*which, label[1], points) for label, which in (alone | pairs).items()}
    natural = {tube.name: tube.natural_curvature for tube in (*robot.outers, *robot.middles)}
    scene = Scene(robot, tuple(runs.values()), MODULUS, natural, {"roll_misalignment": {"roll_deg": roll_deg}})
    files = {"alone.csv": ["run,tube,natural,x_mm,y_mm"], "pairs.csv": ["run,outer,middle,natural,x_mm,y_mm"]}
    for (name, up), run in runs.items():
        who = "OT1,MT1" if name.startswith("p") else "OT1" if run.middle is None else "MT1"
        noise = NOISE_MM * random.standard_normal((POINTS, 2)) * (points > 0.0)[:, None]
        rows = photograph(scene, run) + noise
        lines = files["pairs.csv" if "," in who else "alone.csv"]
        lines += [f"{name},{who},{'up' if up else 'down'},{x:.5f},{y:.5f}" for x, y in rows]
    for name, lines in files.items():
        (path / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    config = load_config_text(config_text(robot), "tubes.toml")
    return diagnose_shapes(config, read_recordings([path / name for name in files], config).shape.runs)


@pytest.mark.parametrize(
    ("roll_deg", "seed"), [(5.0, 1), (6.5, 2), (8.0, 3), (10.0, 4), (12.0, 5), (20.0, 6), (30.0, 7)]
)
def test_a_roll_is_named_and_its_angle_found_within_two_degrees(tmp_path, roll_deg, seed):
    found = _diagnosis(tmp_path, roll_deg, seed)
    assert [effect.id for effect in found.effects] == ["roll_misalignment"]
    assert found.effects[0].parameters["angle_deg"].value == pytest.approx(roll_deg, abs=2.0)


def test_a_pair_that_is_not_rolled_is_left_alone(tmp_path):
    assert _diagnosis(tmp_path, 0.0, 8).effects == ()
