"""``coast sensitivity``: rows, notes, and that JSON is complete."""

import json

from coast_cli.output.columns import COLUMNS


def test_rows_and_notes(coast, reference):
    result = coast("sensitivity", str(reference), "--format", "json")
    assert result.code == 0
    answer = json.loads(result.out)
    assert answer["schema"] == "coast.sensitivity/1"
    rows = answer["rows"]
    assert set(rows[0]) == set(COLUMNS["sensitivity"])
    assert {row["figure"] for row in rows} >= {
        "tip_shift",
        "total_precurvature",
        "ratio_mean",
        "total_series",
        "stroke",
    }
    assert {row["subject"] for row in rows} >= {"OT1", "MT3", "OT4/MT1"}
    assert "one combination of joint.youngs_modulus" in result.err


def test_without_a_joint_the_tips_remain(coast, reference, tmp_path):
    text = reference.read_text(encoding="utf-8")
    config = tmp_path / "tubes.toml"
    config.write_text(text[: text.index("[joint]")], encoding="utf-8")
    result = coast("sensitivity", str(config), "--format", "json")
    assert result.code == 0
    assert {row["figure"] for row in json.loads(result.out)["rows"]} == {"tip_x", "tip_y", "tip_shift"}
