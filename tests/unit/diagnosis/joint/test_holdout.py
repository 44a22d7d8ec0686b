"""Which rows no fit may see: those named, or by rules that are told apart here."""

import numpy as np
import pytest

from coast_cli.diagnosis.joint.holdout import hold_out
from coast_cli.errors import BadInput
from tests.modelled_joint import TOP, cycle, make_run


def run(name, length=0.03, stroke=None):
    stroke = cycle() if stroke is None else stroke
    return make_run(stroke, np.zeros(stroke.size), name=name, length=length)


LOAD = np.linspace(0.0, TOP, 60)
TRIANGLE = np.concatenate([LOAD, LOAD[::-1]])


def test_named_runs_are_held_out_whole_in_their_order():
    runs = [run("a"), run("b"), run("c")]
    found = hold_out(runs, ["c", "a"])
    assert found.runs == ("a", "c")
    assert not found.chosen
    assert [bool(rows.all()) for rows in found.rows] == [True, False, True]
    assert not found.rows[1].any()


def test_an_unknown_name_is_refused_with_the_nearest():
    with pytest.raises(BadInput) as raised:
        hold_out([run("slow"), run("fast")], ["slwo"])
    assert "slow" in str(raised.value)
    assert "slwo" in str(raised.value)
    assert raised.value.exit_code == 3


def test_holding_out_everything_is_refused():
    with pytest.raises(BadInput, match="every run is held out"):
        hold_out([run("a"), run("b")], ["b", "a"])
    assert hold_out([run("a"), run("b")], ["b", "b"]).runs == ("b",)


def test_a_run_whose_conditions_others_meet_is_spared():
    runs = [run("a", 0.03), run("b", 0.02), run("c", 0.03), run("d", 0.02)]
    found = hold_out(runs)
    assert found.chosen
    assert found.runs == ("d",)
    assert [bool(rows.any()) for rows in found.rows] == [False, False, False, True]
    assert "bending length" in found.rule


def test_no_run_is_spared_that_alone_shows_a_length_or_a_release():
    assert hold_out([run("a", 0.03), run("b", 0.02), run("c", 0.04)]).runs == ()
    runs = [run("a", 0.03, LOAD), run("b", 0.03, LOAD), run("c", 0.03, TRIANGLE)]
    assert hold_out(runs).runs == ("b",)


def test_a_quarter_at_most_is_held_out_by_rule():
    assert len(hold_out([run(f"r{number}") for number in range(9)]).runs) == 2


def test_of_one_run_what_follows_the_first_cycle_is_kept_back():
    stroke = np.concatenate([TRIANGLE, TRIANGLE[: TRIANGLE.size // 2]])
    found = hold_out([run("a", stroke=stroke)])
    assert found.runs == ()
    assert "first full cycle" in found.rule
    assert "weaker" in found.rule
    held = np.flatnonzero(found.rows[0])
    assert held[-1] == stroke.size - 1
    assert abs(held[0] - TRIANGLE.size) <= 1
    assert np.all(np.diff(held) == 1)


def test_a_single_sweep_is_held_out_in_blocks():
    found = hold_out([run("a", stroke=TRIANGLE)])
    assert "blocks" in found.rule
    assert 0.15 < found.rows[0].mean() < 0.35
    assert not found.rows[0][:5].any()
    assert not found.rows[0][-5:].any()


def test_a_short_run_is_all_needed():
    found = hold_out([run("a", stroke=np.linspace(0.0, TOP, 20))])
    assert not found.rows[0].any()
    assert found.runs == ()
