"""What has no name on a photographed tube: described by a law, saved, loaded, and dropped where unseen points do not show it."""

from __future__ import annotations

import numpy as np
import pytest

from coast_cli.diagnosis.compare import compare
from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.model_file import model_text
from coast_cli.diagnosis.shapes import diagnose_shapes
from coast_cli.diagnosis.shapes.build import build_shape_problem
from coast_cli.diagnosis.shapes.law_words import describe_shape
from coast_cli.diagnosis.shapes.laws import ask_for_laws
from coast_cli.effects.corrections import unnamed_law
from coast_cli.effects.unnamed import DamagedLaw
from coast_cli.effects.unnamed_shape import ShapeLaw
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config_text
from tests.photographed_tube import Bench, config_text, csv_text

TUBES = {"A": (0.314, 4.0), "B": (0.300, 6.0)}
NOISE = 12e-6


def _recorded(tmp_path, *, seed=1, tubes="AB", **changes):
    path = tmp_path / "shapes.csv"
    benches = [
        (name, Bench(depth=TUBES[name][0] * 1e-3, natural=TUBES[name][1], **changes), up)
        for name in tubes
        for up in (True, False)
    ]
    path.write_text(csv_text(benches, NOISE, seed=seed), encoding="utf-8")
    config = load_config_text(config_text(TUBES), "tubes.toml")
    return config, read_recordings([path], config)


@pytest.mark.parametrize(("seed", "wave"), [(1, 4.0), (2, -7.0)])
def test_a_wavy_natural_curvature_is_a_law_of_the_tube(tmp_path, seed, wave):
    config, recordings = _recorded(tmp_path, seed=seed, wave=wave)
    found = diagnose_shapes(config, recordings.shape.runs)
    assert found.verdict == "unnamed"
    assert found.effects == ()
    law = found.unnamed
    assert law.stages[0] == "tube"
    assert law.variables[0] == "arc_length"
    assert law.memory is False
    assert law.rate is False
    assert "natural curvature" in law.words
    assert law.nearest
    assert found.comparison.with_effects.held_out < 0.3 * found.comparison.refitted.held_out
    corrected = load_config_text(model_text(config, found, recordings), "model.toml")
    assert corrected.corrections["unnamed_1"]["recording"] == "shapes"
    before, after = (compare(one, recordings).rows()[-1]["rmse_shape_mm"] for one in (config, corrected))
    assert after < 0.3 * before


def test_noise_alone_asks_for_no_law(tmp_path):
    config, recordings = _recorded(tmp_path, seed=4)
    problem = build_shape_problem(config, recordings.shape.runs)
    assert ask_for_laws(problem, fit(problem, until="fine")).p_value > 0.01


LAW = ShapeLaw("force", 0.07, (0.01, -0.002), 2.0)


def test_a_law_is_written_and_read():
    assert unnamed_law("unnamed_1", LAW.table()) == LAW
    assert LAW.with_values(np.array([0.5, 0.25])).weights == (0.5, 0.25)
    wave = ShapeLaw("curvature", 0.07, (1.0, 0.5), period=0.02)
    assert unnamed_law("unnamed_1", wave.table()) == wave
    assert wave.with_values(np.array([1.0, 0.5, 0.03])).period == 0.03


@pytest.mark.parametrize(
    ("key", "value", "word"),
    [
        ("adds", "heat", "allowed"),
        ("stage", "camera", "that of force"),
        ("weights", [], "1 to 64"),
        ("high", 0.0, "above 0"),
        ("period", "long", "a number"),
        ("odd", 1.0, "no key"),
    ],
)
def test_a_damaged_law_is_refused(key, value, word):
    with pytest.raises(DamagedLaw, match=word):
        unnamed_law("unnamed_1", {**LAW.table(), key: value})


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (ShapeLaw("curvature", 0.07, (1.0,), 1.0), "a natural curvature of its own on A and grows along the tube"),
        (ShapeLaw("curvature", 0.07, (1.0, 0.0), 0.0, 0.02), "on every tube alike, a wave along the tube of 20 mm"),
        (ShapeLaw("height", 0.07, (0.0, 0.0, 1e-3)), "across the picture"),
        (ShapeLaw("force", 0.07, (0.01,)), "keeps its side"),
        (ShapeLaw("compliance", 0.07, (0.0, 0.3)), "falls and rises"),
    ],
)
def test_a_law_is_told_in_a_sentence(law, words):
    told = describe_shape([law], {1: "A", 2: "B"}, [("tip_load", 2.0)])
    assert words in told.words
    assert "tip load (leaves 2 noise widths)" in told.words
    assert told.equation
