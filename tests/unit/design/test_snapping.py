"""Forecasts of jumps over a bench: which pairs, at which stroke, and that each number is that of its own pair."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from coast_cli.design.checks import check_design
from coast_cli.design.rank import rank
from coast_cli.design.snapping import snap_rows, snaps
from coast_cli.design.tolerance import tolerance_rows
from coast_cli.errors import BadInput
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.pairs import pair_table
from coast_cli.mechanics.snap import RollingPair, TendonInBore, crossing, largest_roll_index, roll_begins, roll_index
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config, load_config_text

CONFIG = Path(__file__).parents[3] / "configs" / "tubes.toml"


@pytest.fixture(scope="module")
def design():
    return build(load_config(CONFIG))


def test_jumps_are_forecast_where_the_outer_tube_leads_and_not_for_the_pair_that_the_paper_chose(design):
    rows = {(row["sample"], row["mechanism"]): row for row in snap_rows(design)}
    assert len(rows) == 24
    jump = {sample for (sample, mechanism), row in rows.items() if mechanism == "crossing" and row["margin"] < 0.0}
    assert jump == {"S2", "S3", "S7", "S11"}
    assert all(rows[sample, "crossing"]["leading_tube"] == "outer" for sample in jump)
    assert rows["S4", "crossing"]["margin"] == rows["S4", "roll"]["margin"] == 1.0
    for (_, mechanism), row in rows.items():
        known = [row[name] is not None for name in ("stroke_mm", "before_per_m", "jump_deg")]
        assert all(known) if row["margin"] < 0.0 else not any(known)
        assert mechanism == "crossing" or row["margin"] > 0.0


def test_the_rest_shape_is_equation_8_over_the_segment(design):
    found = snaps(design, 0.03)
    cut = [
        replace(tube, depth=tube.depth[:50], cut=tube.cut[:50], uncut=tube.uncut[:50])
        for tube in (design.tube("OT3"), design.tube("MT2"))
    ]
    table = pair_table(cut[:1], cut[1:], design.gravity)
    assert found.rest[1, 2] == pytest.approx(-table.signed_precurvature[0, 0] / 0.03)


def test_the_jump_of_one_pair_by_hand(design):
    found, own = snaps(design, 0.04), design.joint("OT3/MT1")
    gain = np.exp(own.pulley_friction * own.wrap_angle) * own.notch_friction ** (0.04 / own.pitch)
    play = own.middle.inner_radius - own.tendon.radius
    rigidity = np.array(own.rigidity)
    numbers = (found.rest[0, 2], rigidity, 0.04, own.lever_arm - play, play, own.tendon.stiffness / gain)
    jump = crossing(TendonInBore(*(np.asarray(value) for value in numbers)))
    assert found.crossing.index[0, 2] == pytest.approx(float(jump.index))
    assert found.crossing_stroke[0, 2] == pytest.approx(float(jump.stroke) + own.deadband)
    assert found.crossing_jump[0, 2] == pytest.approx(float(jump.after - jump.before) * 0.04)


def test_middle_tubes_of_other_lengths_have_their_own_segment(design):
    short = replace(
        design.middle[2], **{name: getattr(design.middle[2], name)[:90] for name in ("depth", "cut", "uncut")}
    )
    mixed = snaps(replace(design, middle=(*design.middle[:2], short)), 0.03)
    assert mixed.rest[:2] == pytest.approx(snaps(design, 0.03).rest[:2])
    assert mixed.rest[2] == pytest.approx(snaps(design, 0.03).rest[2])  # uniform tubes are alike anywhere


def test_the_largest_index_and_where_it_begins():
    pair = RollingPair((-5.5, 8.0), (1.2e-6, 6e-7), (4e-6, 2e-6), (2e-8, 1.5e-8), 0.06)
    bends = np.linspace(pair.rest, 10.0, 20001)
    index, at = largest_roll_index(pair, 10.0)
    assert float(index) == pytest.approx(roll_index(pair, bends).max(), rel=1e-6)
    assert roll_index(pair, roll_begins(pair, float(at))) == pytest.approx(1.0, abs=1e-5)


def test_a_rolling_pair_is_said_with_its_stroke(design):
    strong = tuple(replace(tube, natural_curvature=25.0 * np.sign(tube.natural_curvature)) for tube in design.outer)
    bent = tuple(replace(tube, natural_curvature=-30.0) for tube in design.middle)
    found = snaps(replace(design, outer=strong, middle=bent), 0.04)
    rolls = found.roll_index > 1.0
    assert rolls.any()
    assert np.array_equal(np.isfinite(found.roll), rolls)
    assert np.all(found.roll_stroke[rolls] >= Joint.__dataclass_fields__["deadband"].default)


@pytest.mark.parametrize("table", ["tendon", "joint"])
def test_without_a_joint_or_its_tendon_there_is_no_forecast(table):
    text = CONFIG.read_text()
    start = text.index(f"[{table}]")
    end = text.index("\n[", start)
    cut = text[:start] + text[end:]
    bare = build(load_config_text(cut[: cut.index("[checks]")]))
    assert snaps(bare) is None
    with pytest.raises(BadInput, match="needs pairs, a joint and its tendon"):
        snap_rows(bare)


def checked(limit, pair):
    text = CONFIG.read_text().replace("[checks]", f"[checks]\nmin_snap_margin = {limit}")
    return check_design(build(load_config_text(text, "tubes.toml")), pair)


def test_a_check_holds_a_pair_to_its_margin():
    for pair, passed in (("OT4/MT1", True), ("OT3/MT1", False)):
        row = checked(0.2, pair)[-1]
        assert (row["check"], row["bound"], row["passed"]) == ("min_snap_margin", "min", passed)
        assert row["line"] is not None
    assert row["value"] == pytest.approx(-0.470, abs=1e-3)


def test_tolerances_say_that_they_leave_the_margin_out():
    text = CONFIG.read_text().replace("[checks]", "[checks]\nmin_snap_margin = 0.2")
    design = build(load_config_text(text, "tubes.toml"))
    _, notes, _ = tolerance_rows(design, ("OT4", "MT1"), samples=16, seed=0, ranked=False, index_samples=4)
    assert any("min_snap_margin" in note for note in notes)


def test_the_ranking_shows_the_nearer_forecast_of_each_pair(design):
    columns = rank(design.config).columns
    found = {name: columns[name] for name in ("sample", "snap_margin", "snap_by", "snap_stroke_mm", "snap_jump_deg")}
    rows = {sample: values for sample, *values in zip(*found.values(), strict=True)}
    assert rows["S4"] == [1.0, None, None, None]
    one = next(row for row in snap_rows(design) if (row["sample"], row["mechanism"]) == ("S3", "crossing"))
    assert rows["S3"] == [one["margin"], "crossing", one["stroke_mm"], one["jump_deg"]]
    assert rows["S5"][1:] == ["roll", None, None]


def test_a_ranking_without_a_joint_has_no_forecast():
    text = CONFIG.read_text()
    columns = rank(load_config_text(text[: text.index("[tendon]")])).columns
    assert set(columns["snap_margin"]) == {None}
