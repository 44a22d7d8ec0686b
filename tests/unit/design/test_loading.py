"""Strokes of a corrected model: nothing changes without effects, the diagnosis' own forward model agrees, and back."""

import json
import re

import numpy as np
import pytest

from coast_cli.design.loading import acting_on_load, corrected_stroke, loading_branch
from coast_cli.design.stroke import stroke_table
from coast_cli.effects.catalogue import CATALOGUE, build_effects, effects_of
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.mechanics.joint import stroke
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

LENGTH = 0.03
ACTING = {
    "leadscrew_pitch_error": {"sine_mm": 0.02, "cosine_mm": -0.03},
    "bending_length_offset": {"offset_mm": 1.5},
    "tendon_superelasticity": {"knee_n": 1.0, "extra_compliance": 1.5, "knee_width": 0.05},
    "tendon_permanent_set": {"slack_mm_per_n": 0.2, "threshold_n": 0.3},
    "distributed_notch_friction": {},
    "chord_section": {},
    "precurvature": {"curvature_per_m": 3.0},
    "tip_load": {},
    "gravity": {"share": 0.7},
    "tube_superelasticity": {},
    "tube_hysteresis": {"upper_plateau_mpa": 100.0},
    "notch_closure": {},
    "snap_through": {"curvature_per_m": 20.0, "drop": 0.3},
    "coulomb_friction": {"holds_per_m": 2.0},
}


@pytest.fixture(scope="module")
def joint():
    from pathlib import Path

    return build(load_config(Path(__file__).parents[3] / "configs" / "tubes.toml")).joint()


def some_of(name):
    kind = CATALOGUE[name]
    chosen = {p.name: p.null + 0.1 * (min(p.high, 1.0) - p.null) for p in kind.parameters}
    return (kind(**{**chosen, **ACTING[name]}),)


@pytest.mark.parametrize("name", effects_of("joint"))
def test_an_effect_at_null_changes_nothing(joint, name):
    kappa, length = np.linspace(0.0, 60.0, 41), np.full(41, LENGTH)
    without, null = (
        stroke(joint, kappa, length),
        corrected_stroke(joint, (CATALOGUE[name].null(),), length, kappa, inverse=False),
    )
    np.testing.assert_allclose(null.stroke, without.stroke, rtol=0, atol=1e-10)
    np.testing.assert_allclose(null.tension, without.tension, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(null.tendon_strain, without.tendon_strain, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ACTING)
def test_the_inverse_returns_to_the_curvature(joint, name):
    kappa, length = np.linspace(0.1, 55.0, 97), np.full(97, LENGTH)
    there = corrected_stroke(joint, some_of(name), length, kappa, inverse=False)
    held = np.isfinite(there.stroke)
    back = corrected_stroke(joint, some_of(name), length[held], there.stroke[held], inverse=True)
    assert held.sum() > 50
    np.testing.assert_allclose(back.curvature, kappa[held], rtol=0, atol=1e-9)
    np.testing.assert_allclose(back.tension, there.tension[held], rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ACTING)
def test_it_is_the_forward_model_of_the_diagnosis_on_a_first_pull(joint, name):
    strokes = np.concatenate([[0.0], np.linspace(1.3e-3, 4.0e-3, 60)])
    table = corrected_stroke(joint, some_of(name), np.full(61, LENGTH), strokes, inverse=True)
    history = History(None, strokes, None, np.full(61, LENGTH))
    predicted = predict(joint, some_of(name), [history], Layout("curvature", 1, 60.0))[0]
    np.testing.assert_allclose(table.curvature, predicted.response[:, 0], rtol=0, atol=5e-3)
    np.testing.assert_allclose(table.tension, predicted.tension, rtol=0, atol=1e-3)


def test_what_was_asked_for_does_not_depend_on_what_else_was_asked_for(joint):
    effects = build_effects({"tendon_superelasticity": {"knee_n": 1.0, "extra_compliance": 1.5}})
    alone = corrected_stroke(joint, effects, np.array([LENGTH]), np.array([12.3]), inverse=False)
    among = corrected_stroke(joint, effects, np.full(2, LENGTH), np.array([12.3, 300.0]), inverse=False)
    assert alone.stroke[0] == among.stroke[0]


def test_what_no_pull_holds_has_no_value(joint):
    resting = stroke_table(
        joint, [LENGTH], curvatures=[1.0, 5.0], effects=build_effects({"precurvature": {"curvature_per_m": 3.0}})
    )
    assert resting.columns["stroke_mm"][0] is None
    assert resting.columns["stroke_mm"][1] > 1.2
    assert "1 1/m" in resting.notes[0]
    snapping = loading_branch(joint, some_of("snap_through"), LENGTH, curvature=40.0)
    assert not snapping.held.all()
    assert np.isnan(snapping.at_curvature(np.array([22.0]))[0]).all()


def test_what_the_camera_or_time_does_is_left_out_and_said():
    acting, notes = acting_on_load(
        build_effects(
            {"camera_scale": {"scale": 1.02}, "tendon_creep": {"fraction": 0.1}, "backlash": {"width_mm": 0.1}}
        )
    )
    assert [effect.id for effect in acting] == ["backlash"]
    assert "camera_scale" in notes[0]
    assert "tendon_creep" in notes[1]


def rows_of(ran):
    return json.loads(ran.out)["rows"]


def test_coast_stroke_and_check_use_the_corrections(coast, reference_text, tmp_path):
    plain, corrected = tmp_path / "plain.toml", tmp_path / "corrected.toml"
    plain.write_text(reference_text, encoding="utf-8")
    table = "[corrections.tendon_superelasticity]\nknee_n = 0.5\nextra_compliance = 3.0\n\n[joint]"
    corrected.write_text(reference_text.replace("[joint]", table, 1), encoding="utf-8")
    words = ("--kappa", "10,40", "--x2", "40", "--format", "json")
    before, after = (rows_of(coast("stroke", path, *words)) for path in (plain, corrected))
    assert after[1]["stroke_mm"] > before[1]["stroke_mm"] + 0.5
    checked = {row["check"]: row for row in rows_of(coast("check", corrected, "--format", "json"))}
    assert checked["max_stroke_mm"]["value"] == pytest.approx(after[1]["stroke_mm"], rel=1e-12)
    inverted = rows_of(coast("stroke", corrected, "--stroke", after[1]["stroke_mm"], "--x2", "40", "--format", "json"))
    assert inverted[0]["curvature_per_m"] == pytest.approx(40.0, abs=1e-9)


def test_corrections_of_shapes_do_not_change_a_stroke_and_that_is_said(coast, reference, reference_text, tmp_path):
    path = tmp_path / "corrected.toml"
    path.write_text(reference_text + "\n[corrections.base_tilt]\nangle_deg = 1.0\n", encoding="utf-8")
    words = ("--kappa", "10", "--x2", "40", "--format", "json")
    shaped, plain = coast("stroke", path, *words), coast("stroke", reference, *words)
    assert rows_of(shaped) == rows_of(plain)
    assert "base_tilt are of shapes" in shaped.err


def test_a_stroke_that_nothing_takes_up_is_refused(coast, reference_text, tmp_path):
    path = tmp_path / "corrected.toml"
    path.write_text(reference_text + "\n[corrections.gravity]\nshare = 0.5\n", encoding="utf-8")
    ran = coast("stroke", path, "--stroke", "90000000", "--x2", "40")
    assert ran.code in (2, 4)
    assert re.fullmatch(r"coast: .*\n", ran.err)


@pytest.mark.parametrize("inverse", [False, True])
def test_a_corrected_joint_at_rest_has_no_tension_but_zero(joint, inverse):
    """On one processor rounding left 6e-19 N there, on another none."""
    effects = (CATALOGUE["backlash"](width_mm=0.17),)
    at = np.array([0.0])
    found = corrected_stroke(joint, effects, np.array([LENGTH]), at, inverse=inverse)
    assert (found.tension[0], found.tendon_strain[0], found.curvature[0]) == (0.0, 0.0, 0.0)
