"""Inverse design: what is asked for comes back from the ranking, and what cannot be had is said with the nearest."""

import csv
import io
import json

import numpy as np
import pytest

from coast_cli.design.inverse import inverse_design
from coast_cli.design.rank import rank
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config, load_config_text

PAIR = ("OT4", "MT1")
DEPTHS = ("outer.depth_mm", "middle.depth_mm")
RANGES = """
[explore.outer]
cut_mm = { min = 0.2, max = 0.5 }
uncut_mm = { min = 0.2, max = 0.5 }
[explore.middle]
cut_mm = { min = 0.2, max = 0.5 }
"""


@pytest.fixture
def design(reference):
    return build(load_config(reference))


def values(found):
    return {row["name"]: row["value"] for row in found.rows}


@pytest.mark.parametrize(
    ("targets", "vary"),
    [
        ("rigidity_ratio_series=2.5", "outer.depth_mm"),
        ("rigidity_ratio_series=2.5 total_rigidity_series_n_m2=4.2e-6", "outer.depth_mm,middle.depth_mm"),
        ("rigidity_ratio_mean=2.9 total_precurvature_rad=0.2", "outer.depth_mm,outer.cut_mm,middle.cut_mm"),
        ("total_rigidity_mean_n_m2=4.8e-5", "outer.uncut_mm"),
        ("signed_precurvature_rad=-0.1", "outer.depth_mm,middle.depth_mm"),
    ],
)
def test_solved_then_ranked_is_the_target(coast, tmp_path, reference_text, targets, vary):
    config, saved = tmp_path / "space.toml", tmp_path / "designed.toml"
    config.write_text(reference_text + RANGES)
    words = [word for target in targets.split() for word in ("--target", target)]
    ran = coast("design", config, *words, "--vary", vary, "--save", saved, "-f", "json")
    assert ran.code == 0, ran.out + ran.err
    ranked = {
        (row["outer"], row["middle"]): row
        for row in csv.DictReader(io.StringIO(coast("rank-pairs", saved, "-f", "csv").out))
    }["OT4-designed", "MT1-designed"]
    for target in targets.split():
        name, wanted = target.split("=")
        assert float(ranked[name]) == pytest.approx(float(wanted), rel=1e-8)


def test_a_stroke_is_what_the_stroke_table_says(coast, tmp_path, reference):
    saved = tmp_path / "designed.toml"
    assert coast("design", reference, "--target", "stroke_mm=4.5", "--save", saved).code == 0
    ran = coast("stroke", saved, "--kappa", "40", "--x2", "40", "-f", "json")
    assert json.loads(ran.out)["rows"][0]["stroke_mm"] == pytest.approx(4.5, rel=1e-8)


def test_depths_that_made_the_targets_are_found_again(reference_text):
    """The figures of another pair of the bench, asked of the design that starts from OT4/MT1."""
    config = load_config_text(reference_text)
    columns = rank(config).columns
    row = list(zip(columns["outer"], columns["middle"], strict=True)).index(("OT2", "MT2"))
    names = ("rigidity_ratio_series", "total_rigidity_series_n_m2")
    found = inverse_design(build(config), PAIR, {name: float(columns[name][row]) for name in names}, DEPTHS)
    assert found.reached
    assert values(found)["outer.depth_mm"] == pytest.approx(0.350, abs=1e-9)
    assert values(found)["middle.depth_mm"] == pytest.approx(0.265, abs=1e-9)


def test_what_is_determined_says_how_well(design):
    """Against two designs whose target differs by a hundredth of a per cent."""
    low, high = (
        inverse_design(design, PAIR, {"rigidity_ratio_series": 2.5 * factor}, DEPTHS[:1]) for factor in (1.0, 1.0001)
    )
    moved = values(high)["outer.depth_mm"] - values(low)["outer.depth_mm"]
    row = low.rows[-1]
    assert row["determined"] is True
    assert row["change_per_percent"] == pytest.approx(abs(moved) * 100.0, rel=1e-3)


def test_two_depths_for_one_target_are_said_to_be_free(design):
    found = inverse_design(design, PAIR, {"rigidity_ratio_series": 2.5}, DEPTHS)
    assert found.reached
    assert all(row["determined"] is False for row in found.rows if row["kind"] == "variable")
    assert any("free" in note for note in found.notes)


def test_out_of_reach_gives_the_nearest(coast, reference):
    ran = coast("design", reference, "--target", "rigidity_ratio_series=200", "-f", "json")
    rows = json.loads(ran.out)["rows"]
    assert ran.code == 1
    assert "no design in these ranges" in ran.err
    assert rows[0]["value"] == pytest.approx(13.481, rel=1e-4)  # S9: the most of the reference input
    assert [row["at_bound"] for row in rows[1:]] == [True, True]


def test_the_nearest_is_no_further_than_a_fine_grid(design):
    """Two targets that cannot both be had: no pair of depths on a grid comes nearer."""
    from coast_cli.design.inverse import _problem

    targets = {"rigidity_ratio_series": 2.0, "total_rigidity_series_n_m2": 4.5e-6}
    found = inverse_design(design, PAIR, targets, DEPTHS)
    assert not found.reached
    problem = _problem(design, PAIR, targets, DEPTHS)
    grid = np.stack(np.meshgrid(*(np.linspace(*ends, 30) for ends in zip(*problem.bounds, strict=True))), axis=-1)
    distance = np.linalg.norm(problem.residual(grid.reshape(-1, 2)), axis=1).min()
    mine = np.linalg.norm(problem.residual(np.array([[values(found)[name] for name in DEPTHS]])))
    assert mine <= distance * (1.0 + 1e-9)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--target", "beauty=1"), 2, "no such figure"),
        (("--target", "rigidity_ratio=1"), 2, "Did you mean rigidity_ratio"),
        (("--target", "rigidity_ratio_mean"), 2, "NAME=VALUE"),
        (("--target", "rigidity_ratio_mean=nan"), 2, "NAME=VALUE"),
        (("--target", "rigidity_ratio_mean=2", "--vary", "outer.depth"), 2, "outer.depth_mm"),
        (("--target", "rigidity_ratio_mean=2", "--vary", "outer.cut_mm"), 3, "no range is given"),
        (("--target", "rigidity_ratio_mean=2", "--pair", "MT1"), 2, "an outer and a middle tube"),
    ],
)
def test_bad_requests_are_refused(coast, reference, words, code, said):
    ran = coast("design", reference, *words)
    assert (ran.code, ran.out) == (code, "")
    assert said in ran.err
