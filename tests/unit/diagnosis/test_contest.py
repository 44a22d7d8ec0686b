"""How hypotheses are ordered, which of them tell the same, and that candidates are left out in one place."""

from types import SimpleNamespace

import pytest

from coast_cli.diagnosis.contest import Contest, Hypothesis, ranked, run_contest
from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.thresholds import ALIKE_NATS, EFFECT_NATS, TIE
from coast_cli.effects.library.backlash import Backlash
from tests.modelled_joint import CONFIG, recording


def hypothesis(*ids, score=0.0, parameters=1, likelihood=0.0):
    fit = SimpleNamespace(ids=ids, parameter_count=parameters, rmse=1.0, log_likelihood=likelihood)
    return Hypothesis(fit, frozenset((identifier, 0.0) for identifier in ids), score)


BASE = hypothesis(parameters=0)


def test_scores_within_a_tie_go_by_fewer_parameters_and_then_by_id():
    best = hypothesis("c", score=10.0, parameters=3)
    fewer = hypothesis("b", score=10.0 - 0.9 * TIE, parameters=1)
    as_few = hypothesis("a", score=10.0 - 0.5 * TIE, parameters=1)
    behind = hypothesis("d", score=10.0 - 2.0 * TIE, parameters=0)
    assert [h.ids for h in ranked([behind, best, fewer, as_few], lambda h: h.score)] == [("a",), ("b",), ("c",), ("d",)]


def test_the_last_bit_of_a_score_decides_nothing():
    pair = [hypothesis("a", score=1.0), hypothesis("b", score=1.0 + 1e-15)]
    assert [h.ids for h in ranked(pair, lambda h: h.score)] == [("a",), ("b",)]


def test_an_effect_pays_for_being_named():
    assert hypothesis("a", "b", score=20.0).paid == pytest.approx(20.0 - 2.0 * EFFECT_NATS)


def test_alternatives_are_no_larger_and_close_and_the_best_of_their_ids():
    leading = hypothesis("a", score=30.0)
    close, twin = hypothesis("b", score=30.0 - 0.5 * ALIKE_NATS), hypothesis("b", score=29.9 - 0.5 * ALIKE_NATS)
    far, larger = hypothesis("c", score=29.0 - ALIKE_NATS, likelihood=-1.0), hypothesis("a", "d", score=31.0)
    contest = Contest(BASE, (larger, leading, close, twin, far, BASE), leading)
    assert contest.alternatives() == (close,)
    as_close = hypothesis("c", score=30.5 - EFFECT_NATS, likelihood=0.1)
    assert Contest(BASE, (leading, close, as_close, BASE), leading).alternatives() == (close, as_close)
    assert Contest(BASE, (BASE,), BASE).alternatives() == ()


def test_parts_earn_their_place_over_the_base_model():
    leading = hypothesis("a", "b", score=50.0)
    good, poor = hypothesis("a", score=EFFECT_NATS + 1.0), hypothesis("b", score=EFFECT_NATS - 1.0)
    assert Contest(BASE, (leading, good, poor, BASE), leading).parts() == (good,)


def test_what_is_left_out_is_neither_named_nor_a_rival():
    runs = recording((Backlash(width_mm=0.2),), noise=0.1)
    names = [run_contest(build_joint_problem(CONFIG, runs), 1).leading.ids]
    without = run_contest(build_joint_problem(CONFIG, runs, without=("backlash",)), 1)
    assert names == [("backlash",)]
    assert all("backlash" not in tried.ids for tried in without.tried)
