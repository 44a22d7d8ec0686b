"""The controls along a path: they give back the path's curvature, and every limit is a reason of its own."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from coast_cli.design.path import LARGEST_BEND, plan_path
from coast_cli.effects.catalogue import CATALOGUE
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.mechanics.joint import curvature_from_stroke, stroke
from coast_cli.recordings.planar_path import path_of_curvature
from coast_cli.spec.build import build
from coast_cli.spec.config import Checks
from coast_cli.spec.load import load_config

WITHIN = 1e-3


@pytest.fixture(scope="module")
def joint():
    return build(load_config(Path(__file__).parents[3] / "configs" / "tubes.toml")).joint()


def branch(curvature, bend, *, lead=0.02, tail=0.02):
    """Return a path: a lead, a bend of that curvature and length, a tail."""
    ends = np.cumsum([0.0, lead, 1e-9, bend, 1e-9, tail])
    return path_of_curvature(ends, np.array([0.0, 0.0, curvature, curvature, 0.0, 0.0]))


def planned(joint, path, *effects, points=41, **options):
    return plan_path(joint, effects, path, np.linspace(0.0, path.length, points), **{"within": WITHIN, **options})


def column(plan, name):
    return np.array([np.nan if value is None else value for value in plan.columns[name]], dtype=float)


def test_a_constant_curvature_has_the_strokes_of_the_stroke_table(joint):
    path = path_of_curvature(np.array([0.0, 0.04]), np.array([30.0, 30.0]))
    plan = planned(joint, path)
    feed = column(plan, "feed_mm") / 1e3
    np.testing.assert_allclose(column(plan, "bending_length_mm"), feed * 1e3, rtol=0, atol=1e-9)
    np.testing.assert_allclose(column(plan, "stage_advance_mm"), feed * 1e3, rtol=0, atol=1e-9)
    assert column(plan, "outer_advance_mm").max() == 0.0
    bent = slice(1, None)
    wanted = stroke(joint, 30.0, feed[bent])
    np.testing.assert_allclose(column(plan, "stroke_mm")[bent], wanted.stroke * 1e3, rtol=1e-9)
    np.testing.assert_allclose(column(plan, "tension_n")[bent], wanted.tension, rtol=1e-9)
    assert column(plan, "stroke_mm")[0] == pytest.approx(joint.deadband * 1e3)
    assert plan.reached
    assert column(plan, "deviation_max_mm").max() < 1e-6


@pytest.mark.parametrize("curvature", [25.0, -25.0])
def test_the_controls_through_the_forward_model_are_the_path(joint, curvature):
    path = branch(curvature, 0.04)
    plan = planned(joint, path)
    x1, x2 = column(plan, "stroke_mm") / 1e3, column(plan, "bending_length_mm") / 1e3
    x3, x4 = column(plan, "outer_advance_mm") / 1e3, column(plan, "stage_advance_mm") / 1e3
    psi = np.radians(column(plan, "roll_deg"))
    kappa = curvature_from_stroke(joint, x1, np.maximum(x2, 1e-9)).curvature * np.cos(psi)
    # The robot, built anew from its controls: the middle tube's tip at X4, the bend X2 before it, the outer tube beyond.
    for row in np.flatnonzero(x2 > 1e-6):
        along = np.linspace(0.0, x3[row] + x4[row], 2001)
        inside = (along > x4[row] - x2[row]) & (along <= x4[row])
        angle = np.concatenate(([0.0], np.cumsum(np.where(inside, kappa[row], 0.0)[1:] * np.diff(along))))
        middle = np.exp(1j * 0.5 * (angle[1:] + angle[:-1])) * np.diff(along)
        place = np.concatenate(([0.0], np.cumsum(middle)))
        at_x, at_y = path.place_at(along)
        assert np.abs(place - (at_x + 1j * at_y)).max() < 1e-4
    bent = (x2 > 0.0) & (x3 == 0.0)
    np.testing.assert_allclose(kappa[bent], path.curvature_at(column(plan, "feed_mm")[bent] / 1e3), rtol=1e-5)
    np.testing.assert_allclose(kappa[x2 > 0.0], column(plan, "curvature_per_m")[x2 > 0.0], rtol=1e-9)


def test_the_roll_is_the_side_of_the_bend_and_nothing_else_changes(joint):
    left, right = (planned(joint, branch(side * 30.0, 0.04)) for side in (1.0, -1.0))
    assert set(column(left, "roll_deg")) == {0.0}
    assert set(column(right, "roll_deg")) == {180.0}
    for name in ("stroke_mm", "bending_length_mm", "outer_advance_mm", "stage_advance_mm", "deviation_max_mm"):
        np.testing.assert_allclose(column(left, name), column(right, name), rtol=0, atol=1e-6)


def test_extended_feed_keeps_the_shape(joint):
    plan = planned(joint, branch(30.0, 0.04))
    fed = column(plan, "outer_advance_mm") > 1e-3
    assert fed.any()
    for name in ("stroke_mm", "bending_length_mm", "stage_advance_mm", "curvature_per_m"):
        assert np.ptp(column(plan, name)[fed]) < 1e-9
    np.testing.assert_allclose(
        column(plan, "outer_advance_mm") + column(plan, "stage_advance_mm"), column(plan, "feed_mm"), rtol=0, atol=1e-9
    )


def test_a_correction_gives_the_stroke_and_the_way_back_another(joint):
    play = CATALOGUE["backlash"](width_mm=0.18)
    path = path_of_curvature(np.array([0.0, 0.05]), np.array([30.0, 30.0]))
    plan, ideal = (planned(joint, path, *effects, back=True) for effects in ((play,), ()))
    way = np.array(plan.columns["way"])
    assert (way == "in").sum() == 41
    assert (way == "out").sum() == 40
    inward, outward = (column(plan, "stroke_mm")[way == name] for name in ("in", "out"))
    np.testing.assert_allclose(inward[1:], column(ideal, "stroke_mm")[way == "in"][1:], rtol=0, atol=1e-3)
    np.testing.assert_allclose(outward[1:-1], inward[-3:0:-1] - 0.18, rtol=0, atol=2e-3)
    rows = column(plan, "bending_length_mm") > 0.0
    history = History(None, column(plan, "stroke_mm")[rows] / 1e3, None, column(plan, "bending_length_mm")[rows] / 1e3)
    predicted = predict(joint, (play,), [history], Layout("curvature", 1, 90.0))[0].response[:, 0]
    np.testing.assert_allclose(predicted, 30.0, rtol=0, atol=0.06)
    assert any("without corrections" in note for note in ideal.notes)
    assert not any("without corrections" in note for note in plan.notes)


def test_a_bending_length_that_is_off_is_made_up_for(joint):
    off = CATALOGUE["bending_length_offset"](offset_mm=1.5)
    plan, ideal = (planned(joint, branch(30.0, 0.04), *effects) for effects in ((off,), ()))
    bent = column(ideal, "bending_length_mm") > 2.0
    difference = column(ideal, "bending_length_mm")[bent] - column(plan, "bending_length_mm")[bent]
    np.testing.assert_allclose(difference, 1.5, rtol=0, atol=1e-9)


def reasons(plan):
    return {part for text in plan.columns["reason"] if text for part in text.split("; ")}


LIMITS = Checks(
    max_stroke_mm={"value": 4.0, "curvature_per_m": 40.0, "bending_length_mm": 40.0}, max_tendon_strain=0.006
)


@pytest.mark.parametrize(
    ("path", "options", "said"),
    [
        (branch(30.0, 0.04), {}, None),
        (branch(42.0, 0.062), {}, "bent by more than 145 degrees"),
        (branch(42.0, 0.999 * LARGEST_BEND / 42.0), {}, None),
        (branch(1200.0, 0.002), {"within": 0.1}, "notch faces touch above"),
        (branch(400.0, 0.004), {}, "where nitinol keeps a set"),
        (branch(50.0, 0.04), {"checks": LIMITS}, "stroke above 4 mm (checks.max_stroke_mm)"),
        (branch(50.0, 0.04), {"checks": LIMITS}, "tendon strain above 0.006 (checks.max_tendon_strain)"),
        (branch(30.0, 0.04, tail=0.09), {}, "the outer tube's notches no longer cover the bend"),
        (
            path_of_curvature(np.array([0.0, 0.03, 0.031, 0.06]), np.array([40.0, 40.0, -40.0, -40.0])),
            {},
            "the body is more than 1 mm off the path",
        ),
    ],
)
def test_each_limit_is_a_reason(joint, path, options, said):
    plan = planned(joint, path, **options)
    assert plan.reached == (said is None)
    if said is None:
        assert not reasons(plan)
    else:
        assert any(said in text for text in reasons(plan)), reasons(plan)
    assert [text is None for text in plan.columns["reason"]] == plan.columns["reachable"]


def test_only_rows_past_a_limit_are_out_of_reach(joint):
    plan = planned(joint, branch(40.0, 0.06), checks=LIMITS)
    past = column(plan, "stroke_mm") > 4.0
    strained = column(plan, "tendon_strain") > 0.006
    np.testing.assert_array_equal(np.array(plan.columns["reachable"]), ~(past | strained))
    assert 0 < past.sum() < past.size


def test_a_curvature_that_no_pull_holds_is_out_of_reach(joint):
    bent = CATALOGUE["precurvature"](curvature_per_m=40.0)
    plan = planned(joint, branch(30.0, 0.04), bent)
    assert reasons(plan) == {"no pull holds this curvature"}
    held = [value is not None for value in plan.columns["stroke_mm"]]
    assert held == plan.columns["reachable"]


def test_a_snap_is_out_of_reach(joint):
    snap = CATALOGUE["snap_through"](curvature_per_m=27.0, drop=0.5)
    assert "pulled so, the model settles at another curvature" in reasons(planned(joint, branch(30.0, 0.04), snap))


def test_one_tube_and_no_tendon(joint):
    one = replace(joint, outer=None)
    assert "one tube cannot be fed on beyond its bend" in reasons(
        planned(one, branch(20.0, 0.05, tail=0.07), within=1.0)
    )
    plan = planned(replace(joint, tendon=None), branch(30.0, 0.04))
    assert plan.reached
    assert set(plan.columns["stroke_mm"]) == {None}
    assert column(plan, "tension_n").max() > 0.5
    gravity = CATALOGUE["precurvature"](curvature_per_m=2.0)
    assert planned(replace(joint, tendon=None), branch(30.0, 0.04), gravity).reached


def test_notes_say_what_is_left_out(joint):
    notes = " ".join(planned(joint, branch(60.0, 0.03)).notes)
    assert "the bend is at 60 1/m from 20 to 50 mm" in notes
    assert "web strain reaches" in notes
    assert "its own 1.1 1/m" in notes
    assert planned(joint, path_of_curvature(np.array([0.0, 0.05]), np.zeros(2))).notes == ("the body stays straight.",)
