"""Scores, the Pareto set and the order of pairs, against plain definitions of each."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from coast_cli.design import rank as ranking
from coast_cli.design.rank import RankOptions, pareto, rank
from coast_cli.design.references import rank_references
from coast_cli.errors import BadInput, UsageError
from coast_cli.spec.load import load_config, load_config_text


def dominated(costs, index):
    others = costs[np.arange(len(costs)) != index]
    return bool(np.any(np.all(others <= costs[index], axis=1) & np.any(others < costs[index], axis=1)))


@given(arrays(float, st.tuples(st.integers(0, 40), st.just(3)), elements=st.integers(0, 4).map(float)))
def test_pareto_is_what_no_other_dominates(costs):
    np.testing.assert_array_equal(pareto(costs), [not dominated(costs, index) for index in range(len(costs))])


def test_the_score_is_the_weighted_root_of_squares_over_references(reference):
    weights = (2.0, 0.5, 1.0)
    columns = rank(load_config(reference), RankOptions(rigidity="series", weights=weights)).columns
    costs = np.array(
        [
            columns["total_precurvature_rad"],
            np.abs(np.log(np.array(columns["rigidity_ratio_series"], dtype=float))),
            columns["total_rigidity_series_n_m2"],
        ],
        dtype=float,
    )
    expected = np.sqrt(np.array(weights) @ (costs / np.array([[0.3], [-np.log(0.8)], [1e-4]])) ** 2)
    np.testing.assert_allclose(np.array(columns["score"], dtype=float), expected)
    assert list(columns["score"]) == sorted(columns["score"])
    np.testing.assert_allclose(columns["margin"][:-1], np.diff(columns["score"]))
    assert columns["margin"][-1] is columns["margin_stable"][-1] is None


def test_one_pair_alone_keeps_its_score_and_has_no_margin(reference, reference_text):
    text = reference_text
    for name in ("OT1", "OT2", "OT3", "MT2", "MT3"):
        text = without(text, name)
    alone, among = rank(load_config_text(text)).columns, rank(load_config(reference)).columns
    assert alone["score"][0] == pytest.approx(among["score"][0], rel=1e-12)
    assert alone["margin"] == [None]
    assert list(alone["pareto"]) == [True]


def without(text, name):
    start = text.index(f'name = "{name}"')
    header = text.rindex("[[", 0, start)
    return text[:header] + text[text.find("[", start) :]


def test_references_come_from_the_rank_table_then_the_checks_then_the_defaults(reference_text):
    given = "[rank]\ntotal_precurvature_rad = 0.5\nrigidity_ratio = 2.0\nsource = 'ten benches'\n"
    config = load_config_text(reference_text + given)
    turn, ratio, total = rank_references(config)
    assert (turn.value, turn.source) == (0.5, "rank.total_precurvature_rad")
    assert ratio.value == pytest.approx(np.log(2.0))
    assert (total.value, total.source[:7]) == (1e-4, "default")
    assert any(
        "0.5 rad (rank.total_precurvature_rad)" in note and "; ten benches." in note for note in rank(config).notes
    )
    bare = reference_text[: reference_text.index("[checks]")]
    assert [one.value for one in rank_references(load_config_text(bare))] == pytest.approx([0.3, np.log(1.25), 1e-4])


@pytest.mark.parametrize(
    ("limits", "value", "source"),
    [
        ("min = 0.8, max = 4.0", 1.25, "checks.rigidity_ratio.min"),
        ("max = 4.0", 4.0, "checks.rigidity_ratio.max"),
        ("min = 1.0, max = 4.0", 4.0, "checks.rigidity_ratio.max"),
        ("min = 0.0, max = 1.0", 1.25, "default"),
    ],
)
def test_a_bound_of_the_ratio_measures_it_where_it_leaves_room(edited, limits, value, source):
    config = load_config(edited(("min = 0.8, max = 4.0", limits)))
    found = rank_references(config)[1]
    assert (np.exp(found.value), found.source) == (pytest.approx(value), source)


def test_a_narrow_margin_does_not_survive_other_references(reference):
    columns = rank(load_config(reference)).columns
    assert columns["margin_stable"][:2] == [True, False]  # S4 before S3; S3 before S2 rests on the references


def test_samples_are_numbered_middle_major(reference):
    columns = rank(load_config(reference)).columns
    pairs = dict(zip(columns["sample"], zip(columns["outer"], columns["middle"], strict=True), strict=True))
    assert pairs["S1"] == ("OT1", "MT1")
    assert pairs["S4"] == ("OT4", "MT1")
    assert pairs["S5"] == ("OT1", "MT2")
    assert pairs["S12"] == ("OT4", "MT3")


@pytest.mark.parametrize("weights", [(1.0,), (0.0, 0.0, 0.0), (1.0, -1.0, 0.0)])
def test_weights_that_weigh_nothing(weights):
    with pytest.raises(UsageError, match="three numbers"):
        RankOptions(weights=weights)


def test_a_leading_outer_tube_in_front_is_noted(edited):
    assert not any("snapping" in note for note in rank(load_config(edited())).notes)
    ranking = rank(load_config(edited(("natural_curvature_per_m = 1.1 ", "natural_curvature_per_m = 8.0 "))))
    assert ranking.columns["leading_tube"][0] == "outer"
    assert any("snapping" in note for note in ranking.notes)


def test_more_pairs_than_memory_are_refused_with_the_way_that_takes_them(reference, monkeypatch):
    monkeypatch.setattr(ranking, "MOST_PAIRS", 11)
    with pytest.raises(BadInput, match="too many pairs to rank at once; found 12; allowed: up to 11"):
        rank(load_config(reference))
