"""Strokes of the way back: the forward model, driven up and back by them, gives the curvatures that were asked for."""

import numpy as np
import pytest

from coast_cli.design.bands import alternatives
from coast_cli.design.stroke import stroke_table
from coast_cli.effects.catalogue import build_effects
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.errors import UsageError
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config_text

CURVATURES, LENGTHS = (40.0, 5.0, 10.0, 20.0, 30.0), (0.02, 0.04)
MEMORIES = {
    "play": {"backlash": {"width_mm": 0.2}},
    "capstan": {"capstan_hysteresis": {"pulley_friction": 0.1, "spread": 0.0}},
    "play without a name": {
        "unnamed_1": {
            "stage": "drive",
            "variable": "stroke",
            "memory": "friction",
            "setting": 0.0,
            "low": 0.0,
            "high": 5e-3,
            "weights": [0.1],
        }
    },
    "friction": {"coulomb_friction": {"holds_per_m": 2.0, "spread": 0.0}},
}


@pytest.fixture(scope="module")
def joint():
    from pathlib import Path

    text = (Path(__file__).parents[3] / "configs" / "tubes.toml").read_text(encoding="utf-8")
    return build(load_config_text(text)).joint()


@pytest.mark.parametrize("name", MEMORIES)
def test_driven_up_and_back_the_model_is_where_it_was_asked_to_be(joint, name):
    effects = build_effects(MEMORIES[name])
    columns = stroke_table(joint, LENGTHS, curvatures=CURVATURES, effects=effects, release=True).columns
    load = stroke_table(joint, LENGTHS, curvatures=CURVATURES, effects=effects).columns
    for length in LENGTHS:
        here = np.isclose(columns["bending_length_mm"], length * 1e3)
        order = np.argsort(-np.array(columns["curvature_per_m"])[here])
        strokes = np.array(columns["stroke_mm"], dtype=float)[here][order] * 1e-3
        up = np.linspace(0.0, strokes[0], 50)
        history = History(None, np.concatenate((up, strokes)), None, np.full(50 + strokes.size, length))
        found = predict(joint, effects, [history], Layout("curvature", 1, 120.0))[0].response[50:, 0]
        np.testing.assert_allclose(found, np.sort(CURVATURES)[::-1], atol=0.1)
        before = np.array(load["stroke_mm"], dtype=float)[here][order] * 1e-3
        assert strokes[0] == pytest.approx(before[0], abs=2e-5)
        assert np.all(strokes[1:] < before[1:] - 2e-5)


def test_a_model_without_memory_has_no_release_branch(joint):
    with pytest.raises(UsageError, match="branch release: there is no such branch"):
        stroke_table(joint, LENGTHS, curvatures=CURVATURES, release=True)
    effects = build_effects({"precurvature": {"curvature_per_m": 2.0}})
    with pytest.raises(UsageError, match="there is no such branch"):
        stroke_table(joint, LENGTHS, curvatures=CURVATURES, effects=effects, release=True)


def test_strokes_are_inverted_on_load_only(joint):
    with pytest.raises(UsageError, match="give curvatures"):
        stroke_table(joint, LENGTHS, strokes=(2e-3,), effects=build_effects(MEMORIES["play"]), release=True)


def test_the_way_back_has_its_band(reference_text):
    text = f"{reference_text}\n[corrections.backlash]\nwidth_mm = 0.2\n"
    fitted = '[fitted]\nkeys = ["corrections.backlash.width_mm"]\nstd = [0.02]\ncorrelation = [[1.0]]\n'
    design = build(load_config_text(text + fitted))
    others = alternatives(design)
    found = stroke_table(
        design.joint(), (0.03,), curvatures=(20.0, 40.0), effects=design.effects, alternatives=others, release=True
    )
    half = (found.columns["stroke_high_mm"][0] - found.columns["stroke_low_mm"][0]) / 2.0
    assert half == pytest.approx(1.645 * 0.02, rel=0.02)
