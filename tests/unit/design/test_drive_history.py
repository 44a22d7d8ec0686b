"""Strokes for a history of curvatures: the forward model of the diagnosis, given them, goes through that history."""

import numpy as np
import pytest

from coast_cli.design.drive_history import drive_along
from coast_cli.effects.catalogue import CATALOGUE
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.capstan_hysteresis import CapstanHysteresis
from coast_cli.mechanics.joint import stroke
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

HELD = {
    "leadscrew_pitch_error": {"sine_mm": 0.02, "cosine_mm": -0.03},
    "backlash": {"width_mm": 0.18},
    "bending_length_offset": {"offset_mm": 1.5},
    "tendon_superelasticity": {"knee_n": 1.0, "extra_compliance": 1.5, "knee_width": 0.05},
    "tendon_permanent_set": {"slack_mm_per_n": 0.2, "threshold_n": 0.3},
    "capstan_hysteresis": {"pulley_friction": 0.1, "notch_friction_exponent": 0.002},
    "distributed_notch_friction": {},
    "chord_section": {},
    "precurvature": {"curvature_per_m": 0.8},
    "tip_load": {},
    "gravity": {"share": 0.7},
    "tube_superelasticity": {},
    "tube_hysteresis": {"upper_plateau_mpa": 60.0, "lower_plateau_mpa": 20.0, "stiffness_lost": 0.9},
    "notch_closure": {},
    "coulomb_friction": {"holds_per_m": 2.0},
}
# Up, down, up again and still.
HISTORY = np.concatenate(
    [np.linspace(1.0, 25.0, 60), np.linspace(25.0, 8.0, 50), np.linspace(8.0, 20.0, 30), np.full(9, 20.0)]
)


@pytest.fixture(scope="module")
def joint():
    from pathlib import Path

    return build(load_config(Path(__file__).parents[3] / "configs" / "tubes.toml")).joint()


def effect_of(name):
    kind = CATALOGUE[name]
    chosen = {p.name: p.null + 0.1 * (min(p.high, 1.0) - p.null) for p in kind.parameters}
    return kind(**{**chosen, **HELD[name]})


def test_without_effects_it_is_the_stroke_of_the_joint(joint):
    length = np.linspace(0.002, 0.04, HISTORY.size)
    found, wanted = drive_along(joint, joint.tendon, (), HISTORY, length), stroke(joint, HISTORY, length)
    np.testing.assert_allclose(found.stroke, wanted.stroke, rtol=0, atol=5e-7)
    np.testing.assert_allclose(found.tension, wanted.tension, rtol=0, atol=3e-4)
    np.testing.assert_allclose(found.bending_length, length, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", HELD)
@pytest.mark.parametrize("sliding", [False, True])
def test_the_strokes_take_the_forward_model_through_the_history(joint, name, sliding):
    length = np.linspace(0.002, 0.04, HISTORY.size) if sliding else np.full(HISTORY.size, 0.03)
    effects = (effect_of(name),)
    found = drive_along(joint, joint.tendon, effects, HISTORY, length)
    history = History(None, found.stroke, None, found.bending_length)
    back = predict(joint, effects, [history], Layout("curvature", 1, 70.0))[0]
    np.testing.assert_allclose(back.response[:, 0], HISTORY, rtol=0, atol=0.06)  # tables of X2 and curvature differ
    np.testing.assert_allclose(found.curvature, HISTORY, rtol=0, atol=0.06)
    np.testing.assert_allclose(back.tension, found.tension, rtol=0, atol=5e-3)


def test_play_is_made_up_for_on_release_and_friction_by_a_wait(joint):
    length = np.full(HISTORY.size, 0.03)
    ideal = stroke(joint, HISTORY, length).stroke
    play = drive_along(joint, joint.tendon, (Backlash(0.18),), HISTORY, length).stroke
    np.testing.assert_allclose(play[:60], ideal[:60], rtol=0, atol=1e-7)
    np.testing.assert_allclose(play[60:110][1:], ideal[60:110][1:] - 0.18e-3, rtol=0, atol=1e-7)
    friction = drive_along(joint, joint.tendon, (CapstanHysteresis(0.1, 0.0),), HISTORY, length).stroke
    np.testing.assert_allclose(friction[:60], ideal[:60], rtol=0, atol=1e-7)
    assert (friction[61:110] < ideal[61:110] - 1e-4).all()


def test_the_drive_rests_where_the_curvature_does(joint):
    found = drive_along(
        joint, joint.tendon, (Backlash(0.18), CapstanHysteresis(0.1, 0.0)), HISTORY, np.full(HISTORY.size, 0.03)
    )
    assert np.ptp(found.stroke[-9:]) < 1e-9


def test_effects_act_in_their_own_order(joint):
    length, pair = np.full(HISTORY.size, 0.03), (Backlash(0.18), CapstanHysteresis(0.1, 0.0))
    one, other = (drive_along(joint, joint.tendon, effects, HISTORY, length) for effects in (pair, pair[::-1]))
    np.testing.assert_array_equal(one.stroke, other.stroke)


def test_a_curvature_below_the_shape_at_rest_is_not_held(joint):
    bent = CATALOGUE["precurvature"](curvature_per_m=6.0)
    found = drive_along(joint, joint.tendon, (bent,), HISTORY, np.full(HISTORY.size, 0.03))
    np.testing.assert_array_equal(np.isnan(found.stroke), HISTORY < 6.0)


def test_what_snaps_is_seen_in_the_prediction(joint):
    snap = CATALOGUE["snap_through"](curvature_per_m=14.0, drop=0.4)
    found = drive_along(joint, joint.tendon, (snap,), np.linspace(1.0, 30.0, 200), np.full(200, 0.03))
    off = np.abs(found.curvature - np.linspace(1.0, 30.0, 200))
    assert off.max() > 1.0
    assert np.median(off) < 1e-6
