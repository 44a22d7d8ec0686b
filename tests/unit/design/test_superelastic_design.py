"""A superelastic material reaches the strokes of every answer: stroke, check, tolerance; derivatives stay below the plateau."""

import numpy as np
import pytest

from coast_cli.design.checks import check_design
from coast_cli.design.figures import point_figures
from coast_cli.design.reach import Webs
from coast_cli.design.sensitivity import sensitivity_rows
from coast_cli.design.stroke import stroke_table
from coast_cli.design.tolerance import tolerance_rows
from coast_cli.spec.build import build
from coast_cli.spec.load import REFERENCE, load_config_text

TEXT = REFERENCE.read_text()
TABLE = """
[materials.nitinol.superelastic]
martensite_modulus_gpa = 25.0
upper_plateau_mpa = {upper}
lower_plateau_mpa = 80.0
"""


def design(upper=None):
    return build(load_config_text(TEXT + ("" if upper is None else TABLE.format(upper=upper)), "tubes.toml"))


def stroke_at_the_limit(design):
    return {row["check"]: row["value"] for row in check_design(design)}["max_stroke_mm"]


def test_a_high_plateau_changes_no_stroke():
    tables = [stroke_table(one.joint(), [0.02, 0.04], curvatures=[10.0, 40.0]) for one in (design(), design(900.0))]
    assert tables[1].columns["stroke_mm"] == pytest.approx(tables[0].columns["stroke_mm"], rel=1e-12)
    assert stroke_at_the_limit(design(900.0)) == pytest.approx(stroke_at_the_limit(design()), rel=1e-12)


def test_a_low_plateau_shortens_the_stroke_alike_in_check_and_tolerance():
    soft = design(200.0)
    assert stroke_at_the_limit(soft) < 0.995 * stroke_at_the_limit(design())
    rows, _, _ = tolerance_rows(soft, ("OT4", "MT1"), samples=64, seed=0, ranked=False, index_samples=8)
    nominal = next(row["nominal"] for row in rows if (row["kind"], row["name"]) == ("figure", "stroke_mm"))
    assert nominal == pytest.approx(stroke_at_the_limit(soft), rel=1e-9)


def test_derivatives_say_that_they_are_below_the_plateau():
    rows, notes = sensitivity_rows(design(200.0))
    assert any("below the stress plateau" in note for note in notes)
    assert rows == sensitivity_rows(design())[0]


def test_past_the_plateau_the_webs_strain_more_than_in_proportion():
    soft, linear = (Webs.of(one.joint()) for one in (design(200.0), design()))
    bends = np.array([10.0, 20.0, 60.0, 90.0])
    rise = soft.strain(bends) / linear.strain(bends)
    assert rise[:2] == pytest.approx(1.0, abs=1e-12)
    assert 1.02 < rise[2] < rise[3] < 1.2


def test_the_webs_of_many_pairs_are_those_of_the_joint():
    soft = design(200.0)
    joint = soft.joint()
    found = point_figures(joint, joint.outer.row, joint.middle.row, 60.0, 0.03)
    assert found["web_strain"][0] == pytest.approx(Webs.of(joint).strain(np.array([60.0]))[0])


def test_reach_stops_at_the_strain_that_the_softer_webs_have():
    text = TEXT.replace(
        "[checks]", "[checks]\nmax_web_strain = 0.012\nmin_bend_deg = { value = 10.0, bending_length_mm = 20.0 }"
    )
    found = []
    for table in ("", TABLE.format(upper=200.0)):
        one = build(
            load_config_text(text.replace("value = 6.0", "value = 60.0").replace("= 0.012\n[", "= 0.2\n[") + table)
        )
        rows = {row["check"]: row for row in check_design(one)}
        found.append(rows["min_bend_deg"]["value"])
        strain = Webs.of(one.joint()).strain(np.array([np.radians(found[-1]) / 0.02]))[0]
        assert strain <= 0.012 * (1.0 + 1e-9)
    assert found[0] != found[1]
