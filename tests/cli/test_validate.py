"""``coast validate``: every mistake of a file in one answer, with its line, in the formats that CI systems read."""

import json
from xml.etree import ElementTree as ET

import pytest

from coast_cli.errors import BadInput
from coast_cli.spec.load import load_config

WRONG_KEYS = """version = 1
[materials.nitinol]
youngs_modulus_gpa = "stiff"
density_kg_per_m3 = 6450.0
[outer]
material = "nitinol"
outer_diametr_mm = 0.5
inner_diameter_mm = 0.6
[[outer.samples]]
depth_mm = 0.3
[jont]
"""


@pytest.fixture
def wrong_design(edited):
    return edited(
        ("depth_mm = 0.314 ", "depth_mm = 0.014 "),
        ("depth_mm = 0.400 ", "depth_mm = 0.900 "),
        ('pair = "OT4/MT1"', 'pair = "OT4/MT9"'),
        ("min = 0.8, max", "min = 8.0, max"),
    )


def lines(ran):
    return [row["line"] for row in json.loads(ran.out)["rows"]]


def test_all_keys_and_values_that_are_wrong_are_told(coast, tmp_path):
    path = tmp_path / "tubes.toml"
    path.write_text(WRONG_KEYS, encoding="utf-8")
    ran = coast("validate", path, "-f", "json")
    assert (ran.code, lines(ran)) == (3, [3, 7, 9, 11])
    assert ran.err.count("\n") == 4
    assert "outer.samples[0].name: a required key is missing" in ran.err
    assert coast("validate", path, "--quiet", "-f", "json") == ran


def test_all_tubes_and_tables_that_are_wrong_are_told(coast, wrong_design):
    ran = coast("validate", wrong_design, "-f", "json")
    assert (ran.code, lines(ran)) == (3, [24, 39, 79, 83])
    first = json.loads(ran.out)["rows"][0]["message"]
    with pytest.raises(BadInput) as refused:
        load_config(wrong_design)
    assert str(refused.value) == first


def test_what_all_tubes_share_is_told_once(coast, edited):
    path = edited(("inner_diameter_mm = 0.40 ", "inner_diameter_mm = 0.60 "))
    ran = coast("validate", path, "-f", "json")
    assert len(lines(ran)) == 1
    assert "no wall is left" in ran.err


def test_a_misspelt_key_is_not_missing_as_well(coast, edited):
    ran = coast("validate", edited(("youngs_modulus_gpa = 45.0", "youngs_modulus_gp = 45.0")), "-f", "json")
    assert len(lines(ran)) == 1
    assert "Did you mean youngs_modulus_gpa?" in ran.err


def test_github_marks_every_mistake_at_its_line(coast, wrong_design, reference):
    ran = coast("validate", wrong_design, reference, "-f", "github")
    assert ran.code == 3
    marked = ran.out.splitlines()
    assert len(marked) == 4
    assert all(line.startswith("::error file=") and ",title=coast validate::" in line for line in marked)
    assert ",line=83,title" in marked[-1]
    assert coast("validate", reference, "-f", "github").out == (
        "::notice title=coast validate::1 configurations can be used\n"
    )


def test_junit_has_a_case_for_each_mistake(coast, wrong_design, reference, tmp_path):
    out = tmp_path / "report.xml"
    assert coast("validate", wrong_design, reference, "-o", out).code == 3
    root = ET.fromstring(out.read_text(encoding="utf-8"))
    assert (root.get("tests"), root.get("errors"), root.get("failures")) == ("5", "4", "0")
    assert len(root.findall(".//error")) == 4


@pytest.mark.parametrize("text", ["", "a = [", "\ufeff", "x = 1"])
def test_what_cannot_be_read_is_one_mistake(coast, tmp_path, text):
    path = tmp_path / "tubes.toml"
    path.write_text(text, encoding="utf-8")
    ran = coast("validate", path, "absent.toml", "-f", "json")
    assert ran.code == 3
    assert len(lines(ran)) >= 2
