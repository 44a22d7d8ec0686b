"""Scores, the Pareto set and the order of pairs, against plain definitions of each."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from coast_cli.design import rank as ranking
from coast_cli.design.rank import RankOptions, pareto, rank
from coast_cli.errors import BadInput, UsageError
from coast_cli.spec.load import load_config, load_config_text


def dominated(costs, index):
    others = costs[np.arange(len(costs)) != index]
    return bool(np.any(np.all(others <= costs[index], axis=1) & np.any(others < costs[index], axis=1)))


@given(arrays(float, st.tuples(st.integers(0, 40), st.just(3)), elements=st.integers(0, 4).map(float)))
def test_pareto_is_what_no_other_dominates(costs):
    np.testing.assert_array_equal(pareto(costs), [not dominated(costs, index) for index in range(len(costs))])


def test_the_score_is_the_weighted_root_of_scaled_squares(reference):
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
    low, high = costs.min(axis=1, keepdims=True), costs.max(axis=1, keepdims=True)
    expected = np.sqrt(np.array(weights) @ ((costs - low) / (high - low)) ** 2)
    np.testing.assert_allclose(np.array(columns["score"], dtype=float), expected)
    assert list(columns["score"]) == sorted(columns["score"])


def test_one_pair_alone_scores_zero(reference_text):
    text = reference_text
    for name in ("OT1", "OT2", "OT3", "MT2", "MT3"):
        start = text.index(f'name = "{name}"')
        header = text.rindex("[[", 0, start)
        rest = text.find("[", start)
        text = text[:header] + text[rest:]
    ranking = rank(load_config_text(text))
    assert list(ranking.columns["score"]) == [0.0]
    assert list(ranking.columns["pareto"]) == [True]


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
    ranking = rank(load_config(edited(("natural_curvature_per_m = 1.1 ", "natural_curvature_per_m = 2.0 "))))
    assert ranking.columns["leading_tube"][0] == "outer"
    assert any("snapping" in note for note in ranking.notes)


def test_more_pairs_than_memory_are_refused_with_the_way_that_takes_them(reference, monkeypatch):
    monkeypatch.setattr(ranking, "MOST_PAIRS", 11)
    with pytest.raises(BadInput, match="too many pairs to rank at once; found 12; allowed: up to 11"):
        rank(load_config(reference))
