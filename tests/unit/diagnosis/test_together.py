"""Joint and shapes of the same tubes in one call, each by a forward model of its own that is not the one fitted."""

from __future__ import annotations

import json
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest

import tests.independent_joint as joints
from coast_cli.diagnosis.recorded import diagnose
from coast_cli.output.diagnosis import DiagnosisAnswer
from coast_cli.output.diagnosis_json import document
from coast_cli.output.diagnosis_page import render
from coast_cli.output.diagnosis_report import report_page
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config_text
from examples.concealed.design import Joint, Robot, Tube
from examples.concealed.shape_scene import Scene, ShapeRun, photograph

MM = 1e-3
DEEPER = 12e-6  # the outer tube of the joint, against its drawing
NOISE_MM, NOISE_PER_M = 0.03, 0.15
OUTER = {"OT1": 0.314, "OT4": 0.400}
MIDDLE = {"MT1": 0.243, "MT3": 0.287}
NATURAL = {"OT1": 3.0, "OT4": 1.1, "MT1": 2.0, "MT3": 6.0}
CONFIG = """
version = 1
[materials.nitinol]
youngs_modulus_gpa = 45.0
density_kg_per_m3 = 6450.0
[outer]
material = "nitinol"
outer_diameter_mm = 0.5
inner_diameter_mm = 0.4
notch = {{ cut_mm = 0.3, uncut_mm = 0.3, count = 188 }}
{outer}
[middle]
material = "nitinol"
outer_diameter_mm = 0.36
inner_diameter_mm = 0.28
notch = {{ cut_mm = 0.3, uncut_mm = 0.3, count = 125 }}
{middle}
[tendon]
radius_mm = 0.038
youngs_modulus_gpa = 53.965
length_mm = 388.68
[joint]
youngs_modulus_gpa = 42.6
pulley_friction = 0.2965
wrap_angle_rad = 3.141592653589793
notch_friction = 1.0063
deadband_mm = 1.2
pair = "OT4/MT1"
"""


def _config():
    def samples(role, tubes):
        keys = "natural_curvature_per_m"
        return "\n".join(
            f'[[{role}.samples]]\nname = "{n}"\ndepth_mm = {d}\n{keys} = {NATURAL[n]}' for n, d in tubes.items()
        )

    return load_config_text(
        CONFIG.format(outer=samples("outer", OUTER), middle=samples("middle", MIDDLE)), "tubes.toml"
    )


def _robot(deeper: float) -> Robot:
    def tube(name, depth, od, bore, count):
        actual = depth * MM + (deeper if name == "OT4" else 0.0)
        return Tube(name, od * MM, bore * MM, actual, 0.3 * MM, 0.3 * MM, count, NATURAL[name])

    outers = tuple(tube(n, d, 0.5, 0.4, 188) for n, d in OUTER.items())
    middles = tuple(tube(n, d, 0.36, 0.28, 125) for n, d in MIDDLE.items())
    drive = Joint(outers[1], middles[0], 42.6e9, 0.2965, np.pi, 1.0063, 1.2e-3, 0.038e-3, 53.965e9, 0.38868)
    return Robot(outers, middles, drive, (0.2e-3, 0.1e-3))


def _shapes(path, deeper, seed=3):
    """Photographs of OT4, MT1 and MT3, each both ways up, by the concealed generator's own beam."""
    random = np.random.default_rng(seed)
    robot, points = _robot(deeper), np.linspace(0.0, 1.0, 120)
    runs = [ShapeRun(o, m, up, points) for o, m in ((1, None), (None, 0), (None, 1)) for up in (True, False)]
    scene = Scene(robot, tuple(runs), 45e9, NATURAL, {})
    lines = ["run,tube,natural,x_mm,y_mm"]
    for number, run in enumerate(runs):
        name = "OT4" if run.outer is not None else f"MT{1 if run.middle == 0 else 3}"
        for row, (x, y) in enumerate(photograph(scene, run)):
            a, b = random.normal(0.0, NOISE_MM, 2) if row else (0.0, 0.0)
            lines.append(f"shape{number},{name},{'up' if run.up else 'down'},{x + a:.5f},{y + b:.5f}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _strokes(path, deeper, pairs):
    """Sweeps of a joint that is stepped through its history notch by notch, its outer tube cut deeper."""
    with pytest.MonkeyPatch.context() as patch:
        tube = joints.OUTER["OT4"]
        patch.setitem(joints.OUTER, "OT4", replace(tube, depth=tube.depth + deeper))
        path.write_text(_stroke_text(pairs), encoding="utf-8")


def _stroke_text(pairs, seed=5) -> str:
    random = np.random.default_rng(seed)
    lines = ["run,time_s,outer,middle,bending_length_mm,stroke_mm,curvature_per_m"]
    for outer, middle in pairs:
        for length in (20.0, 35.0):
            time, stroke = joints.sweep(3.4e-3, 0.1e-3, 0.05e-3)
            curvature, _, _ = joints.simulate(joints.Truth(), outer, middle, length * MM, time, stroke)
            seen = curvature + random.normal(0.0, NOISE_PER_M, time.size)
            for t, x, k in zip(time, stroke, seen, strict=True):
                lines.append(f"{outer}{middle}{length:g},{t:.3f},{outer},{middle},{length:g},{1e3 * x:.5f},{k:.5f}")
    return "\n".join(lines) + "\n"


def _diagnosed(tmp_path, *, in_shapes=DEEPER, in_strokes=DEEPER, pairs=(("OT4", "MT1"), ("OT1", "MT1"))):
    _shapes(tmp_path / "shape.csv", in_shapes)
    _strokes(tmp_path / "joint.csv", in_strokes, pairs)
    config = _config()
    read = read_recordings([tmp_path / "joint.csv", tmp_path / "shape.csv"], config)
    found = diagnose(config, read, hold_out=["OT4MT135"])
    return config, read, found


@pytest.fixture(scope="module")
def deeper(tmp_path_factory):
    return _diagnosed(tmp_path_factory.mktemp("both"))


def test_the_shapes_name_the_tube_that_is_cut_too_deep(deeper):
    shapes = deeper[2].carried.shapes
    assert shapes.effects[0].id == "notch_depth_error"
    assert shapes.effects[0].parameters["depth_um"].value == pytest.approx(12.0, abs=1.0)
    assert shapes.effects[0].parameters["tube"].value == 2.0


def test_what_the_shapes_found_explains_the_strokes(deeper):
    """Nothing is fitted to the strokes here: the joint as configured, with and without the depth the shapes have."""
    carried = deeper[2].carried
    assert carried.config is not None
    assert carried.config.outer.samples[1].depth_mm == pytest.approx(0.412, abs=0.001)
    assert carried.with_it[0].held_out < 0.2 * carried.without[0].held_out
    assert carried.with_it[0].held_out < 1.5 * NOISE_PER_M
    assert carried.with_it[1].held_out < carried.without[1].held_out
    assert deeper[2].verdict in ("agrees", "parameters")


def test_both_measure_the_depth_and_agree(deeper):
    shared = {one.name: one for one in deeper[2].carried.shared}
    depth = shared["notch_depth_error.depth_um"]
    assert depth.agree is True
    assert depth.joint.value == pytest.approx(12.0, abs=max(3.0 * depth.joint.std, 1.5))
    assert depth.together.std < min(depth.joint.std, depth.shapes.std)
    assert shared["youngs_modulus_over_configured"].agree is True


def test_page_and_json_show_both(deeper):
    _, read, found = deeper
    answer = DiagnosisAnswer(found, found.carried.config, read, {}, read.notes)
    page = StringIO()
    render(answer, page)
    assert "The shapes of the same call" in page.getvalue()
    assert page.getvalue().count("1. Is there a mismatch?") == 2
    assert max(map(len, page.getvalue().splitlines())) <= 80
    written = json.loads(json.dumps(document(answer), allow_nan=False))
    assert written["shapes"]["effects"][0]["id"] == "notch_depth_error"
    assert written["carried_over"]["used"] is True
    assert {one["name"] for one in written["shared"]} >= {"notch_depth_error.depth_um"}


def test_the_report_shows_both(deeper):
    pytest.importorskip("matplotlib", reason="not here: matplotlib, which draws the report")
    _, read, found = deeper
    page = report_page(DiagnosisAnswer(found, found.carried.config, read, {}, read.notes))
    assert "Shared with the shapes" in page
    assert "notch_depth_error.depth_um" in page


def test_the_saved_model_has_the_depth_and_serves_both(deeper):
    from coast_cli.diagnosis.compare import compare
    from coast_cli.diagnosis.model_file import model_text

    config, read, found = deeper
    saved = load_config_text(model_text(found.carried.config, found, read), "model.toml")
    before, after = (compare(one, read).rows()[-1] for one in (config, saved))
    assert after["rmse_curvature_per_m"] < 0.3 * before["rmse_curvature_per_m"]
    assert after["rmse_shape_mm"] < 0.3 * before["rmse_shape_mm"]


def test_one_pair_cannot_tell_a_depth_from_its_modulus(tmp_path):
    found = _diagnosed(tmp_path, pairs=(("OT4", "MT1"),))[2]
    depth = next(one for one in found.carried.shared if one.name == "notch_depth_error.depth_um")
    assert depth.joint is None or depth.joint.std > 0.3 * depth.shapes.value
    assert found.carried.with_it[0].held_out < 0.2 * found.carried.without[0].held_out


def test_strokes_that_contradict_the_shapes_are_said_to(tmp_path):
    found = _diagnosed(tmp_path, in_strokes=0.0)[2]
    depth = next(one for one in found.carried.shared if one.name == "notch_depth_error.depth_um")
    assert depth.agree is False
    assert found.carried.config is None
    assert found.effects == ()


def test_clean_shapes_carry_nothing_over(tmp_path):
    found = _diagnosed(tmp_path, in_shapes=0.0, in_strokes=0.0, pairs=(("OT4", "MT1"),))[2]
    assert found.carried.shapes.effects == ()
    assert found.carried.config is None
    assert found.carried.without is None
