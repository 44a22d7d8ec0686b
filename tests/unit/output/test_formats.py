"""Each format says the same rows: JSON and CSV to the last digit, JUnit to its schema, tables for people."""

import csv
import io
import json
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from coast_cli.output import csv as csv_format
from coast_cli.output import github, junit, latex, markdown, table
from coast_cli.output import json as json_format
from coast_cli.output.answer import Answer, Columns

finite = st.floats(allow_nan=False, allow_infinity=False)
cells = st.one_of(st.none(), st.booleans(), st.integers(), finite, st.text(st.characters(exclude_categories=["Cs"])))


def rendered(module, answer):
    stream = io.StringIO()
    module.render(answer, stream)
    return stream.getvalue()


def answer_of(rows):
    return Answer("demo", rows, {"configs": [{"file": "a.toml", "sha256": "0" * 64}]})


@given(st.lists(st.fixed_dictionaries({"a": cells, "b": cells}), max_size=5))
def test_json_holds_the_rows_as_they_are(rows):
    read = json.loads(rendered(json_format, answer_of(rows)))
    assert read["schema"] == "coast.demo/1"
    assert read["rows"] == rows
    assert list(read) == ["schema", "provenance", "notes", "rows"]


@given(st.lists(st.fixed_dictionaries({"a": finite, "b": st.text("ab,\"'\n x")}), min_size=1, max_size=5))
def test_csv_holds_every_digit_and_quotes_what_must_be(rows):
    read = list(csv.DictReader(io.StringIO(rendered(csv_format, answer_of(rows)), newline="")))
    assert [(float(row["a"]), row["b"]) for row in read] == [(row["a"], row["b"].replace("\n", "\\n")) for row in rows]


def test_csv_of_nothing_is_nothing():
    assert rendered(csv_format, answer_of([])) == ""


@given(st.lists(st.fixed_dictionaries({"long_column_name_in_mm": finite, "b": cells}), max_size=5))
def test_a_table_takes_any_row_and_has_no_trailing_spaces(rows):
    text = rendered(table, answer_of(rows))
    assert all(line == line.rstrip(" ") for line in text.split("\n"))
    assert "a.toml  sha256 0000000000000000\n" in text


def test_a_table_leaves_out_columns_without_a_value_and_markup_is_text():
    text = rendered(table, answer_of([{"name": "[bold]x[/bold]", "none": None, "value": 1.23456789, "ok": False}]))
    assert "[bold]x[/bold]" in text
    assert "none" not in text
    assert "1.2346" in text
    assert " no" in text


CHECKS = [
    {
        "config": "a&b.toml",
        "pair": "O/<M>",
        "check": "max_stroke_mm",
        "bound": "max",
        "value": 4.79,
        "limit": 6.0,
        "passed": True,
        "line": 84,
    },
    {
        "config": "a&b.toml",
        "pair": "O/<M>",
        "check": 'rigidity_"ratio"',
        "bound": "min",
        "value": 1.0,
        "limit": 2.0,
        "passed": False,
        "line": 83,
    },
    {
        "config": "c,d:e%.toml",
        "pair": "A/B",
        "check": "max_stroke_mm",
        "bound": "max",
        "value": 9.0,
        "limit": 6.0,
        "passed": False,
        "line": 7,
    },
]


BROKEN = {**dict.fromkeys(CHECKS[0]), "config": "<x>.toml", "passed": False, "error": "<x>.toml: the file is empty."}


@pytest.mark.parametrize("rows", [[], CHECKS[:1], CHECKS, [*CHECKS, BROKEN], [BROKEN]])
def test_junit_validates_against_its_schema(rows):
    # The library's own deprecated use of a standard module is not this project's warning.
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import xmlschema

        schema = xmlschema.XMLSchema(str(Path(__file__).with_name("junit.xsd")))
        report = rendered(junit, answer_of(rows))
        schema.validate(report)
        assert not schema.is_valid(report.replace("testsuites", "suites"))


def test_junit_counts_and_says_what_failed():
    root = ET.fromstring(rendered(junit, answer_of(CHECKS)))
    assert (root.get("tests"), root.get("failures")) == ("3", "2")
    assert [suite.get("name") for suite in root] == ["a&b.toml", "c,d:e%.toml"]
    failure = root.find(".//failure")
    assert failure.get("message") == 'O/<M>: rigidity_"ratio" is 1, past its min of 2'
    assert failure.text.startswith("a&b.toml:83: ")


def test_a_configuration_that_was_not_checked_is_an_error_and_no_failure():
    root = ET.fromstring(rendered(junit, answer_of([*CHECKS, BROKEN])))
    assert [root.get(name) for name in ("tests", "failures", "errors")] == ["4", "2", "1"]
    assert root.find(".//error").get("message") == "<x>.toml: the file is empty."
    line = rendered(github, Answer("check", [BROKEN])).splitlines()[0]
    assert line == "::error file=<x>.toml,line=1,title=coast check::<x>.toml: the file is empty."


def test_github_escapes_what_its_commands_reserve():
    lines = rendered(github, Answer("check", CHECKS)).splitlines()
    assert lines[1] == (
        "::error file=c%2Cd%3Ae%25.toml,line=7,title=coast check::A/B: max_stroke_mm is 9, past its max of 6"
    )
    assert rendered(github, Answer("check", CHECKS[:1])) == "::notice title=coast check::1 limits hold\n"


def test_columns_are_rows_made_one_at_a_time():
    import numpy as np

    rows = Columns({"a": np.arange(3.0), "b": np.array(["x", None, "z"], dtype=object)})
    assert len(rows) == 3
    assert rows[1] == {"a": 1.0, "b": None}
    assert type(rows[1]["a"]) is float
    assert list(rows[1:]) == [rows[1], rows[2]]
    with pytest.raises(ValueError, match="differ in length"):
        Columns({"a": [1], "b": [1, 2]})
    assert len(Columns({})) == 0


def test_a_million_rows_cost_no_more_than_their_columns():
    import numpy as np

    rows = Columns({"a": np.zeros(1_000_000), "b": np.zeros(1_000_000)})
    assert sys.getsizeof(rows) < 1000
    assert sum(1 for _ in rows[:10]) == 10


def test_markdown_and_latex_escape_what_they_reserve():
    rows = [
        {"run_1": "a|b_c*", "x_mm": 1.23456789, "ok": True, "none": None},
        {"run_1": "50 %", "x_mm": None, "ok": False, "none": None},
    ]
    lines = rendered(markdown, answer_of(rows)).splitlines()
    assert lines == [
        "| run\\_1 | x\\_mm | ok |",
        "|---|---:|---:|",
        "| a\\|b\\_c\\* | 1.2346 | yes |",
        "| 50 % | - | no |",
    ]
    text = rendered(latex, answer_of(rows))
    assert text.splitlines()[0] == r"\begin{tabular}{lrr}"
    assert r"a|b\_c* & 1.2346 & yes \\" in text
    assert r"50 \% & - & no \\" in text
    assert rendered(latex, answer_of([])) == rendered(markdown, answer_of([])) == ""
