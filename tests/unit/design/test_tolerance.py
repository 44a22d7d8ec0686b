"""Tolerances: probabilities against direct samples, indices against closed forms, impossible tubes counted."""

import re
import tracemalloc

import numpy as np
import pytest
from scipy.stats import norm

from coast_cli.design.indices import sobol_indices_of
from coast_cli.design.rank import RankOptions
from coast_cli.design.robust import robust_rank
from coast_cli.design.samples import make_pair, make_pairs, shares
from coast_cli.design.tolerance import tolerance_rows
from coast_cli.design.variation import variation
from coast_cli.errors import CoastError
from coast_cli.mechanics.section import full_section, notched_section
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config, load_config_text
from tests.one_pair import pair_figures


def rows_of(text, **options):
    options = {"samples": 1000, "seed": 1, "ranked": False, "index_samples": 8} | options
    rows, notes, columns = tolerance_rows(build(load_config_text(text)), ("OT4", "MT1"), **options)
    return {(row["kind"], row["name"], row["input"]): row for row in rows}, notes, columns


def mean_rigidity(rng, count, diameters, depth):
    """Mean rigidity over E of direct samples, from the formulas of the section alone."""
    outer = (diameters[0] + 0.0035 * rng.standard_normal(count)) / 2.0
    inner = (diameters[1] + 0.0075 * rng.standard_normal(count)) / 2.0
    cut = notched_section(outer, inner, depth + 0.005 * rng.standard_normal(count)).second_moment
    return (full_section(outer, inner).second_moment + cut) / 2.0


def test_a_probability_agrees_with_a_million_direct_samples(reference_text):
    """The interval is 95 %, so three independent seeds: at least two of them hold the direct value, and all nearly."""
    rng = np.random.default_rng(99)
    ratio = mean_rigidity(rng, 1_000_000, (0.50, 0.40), 0.400) / mean_rigidity(rng, 1_000_000, (0.36, 0.28), 0.243)
    direct = np.mean(ratio <= 4.0)
    held = []
    for seed in (1, 2, 3):
        row = rows_of(reference_text, seed=seed)[0]["check", "rigidity_ratio", "max"]
        held.append(row["probability_low"] <= direct <= row["probability_high"])
        assert abs(row["probability"] - direct) < 4.0 * np.sqrt(direct * (1.0 - direct) / 1000)
    assert sum(held) >= 2


def test_each_sample_is_what_one_pair_alone_gives(reference):
    design = build(load_config(reference))
    outer, middle = design.tube("OT4"), design.tube("MT1")
    varied = variation(design.config, (outer, middle))
    nominal = make_pair(design, varied, (outer, middle), np.full((1, len(varied.inputs)), 0.5)).columns
    alone = pair_figures(outer, middle, design.gravity)
    np.testing.assert_allclose(nominal["total_precurvature_rad"], alone.total_precurvature, rtol=1e-10)
    np.testing.assert_allclose(nominal["total_rigidity_series_n_m2"], alone.total_series, rtol=1e-10)


def test_samples_follow_from_the_seed_and_their_number_alone():
    table = np.random.default_rng(4).random((50, 7))
    np.testing.assert_array_equal(shares(4, 7, 13, 20), table[13:33])


def test_blocks_of_another_size_give_the_same_samples(reference_text, monkeypatch):
    rows, _, whole = rows_of(reference_text, samples=300)
    monkeypatch.setattr("coast_cli.design.samples.BLOCK", 70)
    others, _, parts = rows_of(reference_text, samples=300)
    for name, column in whole.items():
        np.testing.assert_allclose(parts[name], column, rtol=1e-9)
    for key, row in rows.items():
        assert row["probability"] == others[key]["probability"]


def test_a_run_that_goes_on_gives_the_same_figures(reference_text, monkeypatch):
    monkeypatch.setattr("coast_cli.design.samples.BLOCK", 70)
    states = []
    rows, _, whole = rows_of(reference_text, samples=300, keep=states.append)
    assert [state["stroke_mm"].size for state in states] == [70, 140, 210, 280, 300]
    again, _, resumed = rows_of(reference_text, samples=300, beginning=states[1])
    assert again == rows
    assert all(np.array_equal(resumed[name], whole[name]) for name in whole)


def test_memory_grows_by_the_figures_alone(reference_text, monkeypatch):
    monkeypatch.setattr("coast_cli.design.samples.BLOCK", 64)

    def most(samples):
        tracemalloc.start()
        rows_of(reference_text, samples=samples)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak

    most(64)  # imports
    assert most(640) - most(64) < 576 * 10 * 8 * 4  # ten figures, and copies of a few for their statistics


def test_sobol_indices_of_a_linear_figure_are_its_shares_of_variance():
    """f = sum a_i x_i of independent normals: S_i = a_i^2 / sum a^2, and no interaction."""
    factors = np.array([3.0, 2.0, 1.0, 0.5])
    shares = factors**2 / np.sum(factors**2)
    found = sobol_indices_of(lambda draws: {"linear": 7.0 + norm.ppf(draws) @ factors}, 4, 1024, 0)
    first, total = found.indices["linear"]
    np.testing.assert_allclose(first, shares, atol=0.01)
    np.testing.assert_allclose(total, shares, atol=0.01)


def test_sobol_indices_of_a_product_see_the_interaction():
    """f = x y of uniforms on 0..1: V = 7/144, S = 1/48 / (7/144) = 3/7 each, and 1/7 shared."""
    found = sobol_indices_of(lambda draws: {"product": draws[:, 0] * draws[:, 1]}, 2, 1024, 0)
    first, total = found.indices["product"]
    np.testing.assert_allclose(first, 3.0 / 7.0, atol=0.01)
    np.testing.assert_allclose(total, 4.0 / 7.0, atol=0.01)


def test_a_figure_that_one_input_moves_has_its_index(reference_text):
    text = (
        reference_text
        + """
[tolerances]
outer_diameter_mm = { plus_minus = 0.0 }
inner_diameter_mm = { plus_minus = 0.0 }
depth_mm = { plus_minus = 0.0 }
youngs_modulus_percent = { plus_minus = 5.0, distribution = "uniform" }
"""
    )
    rows, _, columns = rows_of(text, index_samples=256)
    assert rows["figure", "rigidity_ratio_mean", None]["std"] == pytest.approx(3.3908 * 0.05 / 3**0.5 * 2**0.5, rel=0.1)
    for name in ("outer", "middle"):
        row = rows["index", "rigidity_ratio_mean", f"{name}.youngs_modulus_percent"]
        assert row["first_order"] == pytest.approx(0.5, abs=0.02)
    assert np.ptp(columns["stroke_mm"]) < 1e-12  # the joint has a modulus of its own


def test_tubes_that_cannot_be_are_counted_not_dropped(reference_text):
    text = reference_text + "\n[tolerances]\ndepth_mm = { plus_minus = 0.2 }\n"
    rows, notes, columns = rows_of(text)
    share = rows["check", "impossible", None]["probability"]
    assert share > 0.1
    assert np.isnan(columns["total_precurvature_rad"]).mean() == pytest.approx(share)
    assert rows["check", "rigidity_ratio", "min"]["probability"] == pytest.approx(1.0 - share, abs=0.002)
    assert any("cannot be made" in note for note in notes)


def test_tolerances_that_leave_nothing_are_said(reference_text):
    text = reference_text.replace("outer_diameter_mm = 0.36", "outer_diameter_mm = 0.399")
    text = text.replace("inner_diameter_mm = 0.28", "inner_diameter_mm = 0.2501")
    text += '\n[tolerances]\nouter_diameter_mm = { plus_minus = 90.0, distribution = "uniform" }\n'
    with pytest.raises(CoastError, match="no sample can be assembled"):
        rows_of(text, samples=20)


def test_roll_and_natural_curvature_widen_the_precurvature(reference_text):
    plain = rows_of(reference_text)[0]["figure", "total_precurvature_rad", None]["std"]
    table = "\n[tolerances]\nnatural_curvature_per_m = { plus_minus = 3.0 }\nroll_deg = { plus_minus = 10.0 }\n"
    assert rows_of(reference_text + table)[0]["figure", "total_precurvature_rad", None]["std"] > 1.5 * plain


def test_the_robust_ranking_orders_by_the_chance_of_passing(reference):
    columns = robust_rank(load_config(reference), RankOptions(), samples=64).columns
    chances = list(columns["probability_passing"])
    assert chances == sorted(chances, reverse=True)
    assert sum(columns["probability_first"]) == pytest.approx(1.0)
    assert list(columns["rank"]) == list(range(1, 13))


def test_the_robust_ranking_needs_limits(reference_text):
    config = load_config_text(reference_text[: reference_text.index("[checks]")])
    with pytest.raises(CoastError, match="robust ranking"):
        robust_rank(config, RankOptions())


def test_memory_is_bounded_however_many_notches_a_tube_has(reference_text):
    """Tables of pieces would take 3 GB of 200 samples at once; tubes of 12 m are too soft to be solved, so it is quick."""
    text = re.sub(r"count = \d+", "count = 20000", reference_text)
    design = build(load_config_text(text))
    tubes = design.tube("OT4"), design.tube("MT1")
    varied = variation(design.config, tubes)
    draws = shares(0, len(varied.inputs), 0, 200)
    tracemalloc.start()
    columns = make_pairs(design, varied, tubes, draws)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert columns["total_precurvature_rad"].size == 200
    assert peak < 400e6
