"""Text that leaves: in the stream's own encoding without losing a row, and in CSV with nothing that a spreadsheet runs."""

import csv
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from coast_cli.output.answer import Answer
from coast_cli.output.columns import COLUMNS
from coast_cli.output.csv import guarded, render
from coast_cli.output.table import render as render_table

ROOT = Path(__file__).parents[2]
NAMES = {
    "=cmd|'/C calc'!A0": "'=cmd|'/C calc'!A0",
    "+1+2": "'+1+2",
    "-2+3": "'-2+3",
    "@SUM(A1)": "'@SUM(A1)",
    "'=1": "''=1",
    "\uff1d1": "'\uff1d1",
    "a\x1b[31mb": "a\\x1b[31mb",
    "\t=1": "\\t=1",
    "two\nlines": "two\\nlines",
    "-5": "-5",
    "+1.5e-3": "+1.5e-3",
    "OT4/MT1": "OT4/MT1",
    "it's": "it's",
}


def run(encoding, *words):
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONIOENCODING": encoding}
    command = [sys.executable, "-m", "coast_cli", *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, check=False)


@pytest.mark.parametrize("encoding", ["cp1252", "ascii", "latin-1:strict"])
@pytest.mark.parametrize("format", ["table", "json", "csv"])
def test_a_stream_that_lacks_a_character_loses_no_row(coast, edited, encoding, format):
    config = edited(name="κ…😀.toml")
    whole = coast("validate", config, config, "-f", format)
    ran = run(encoding, "validate", config, config, "-f", format)
    text = ran.stdout.decode(encoding.partition(":")[0])
    assert (ran.returncode, whole.code) == (0, 0)
    assert text.count("\n") == whole.out.count("\n")
    assert r"\u03ba" in text
    assert r"\ud83d\ude00" in text
    assert "internal error" not in ran.stderr.decode("ascii", "replace")
    if format == "json":
        assert json.loads(text) == json.loads(whole.out)


def test_a_table_has_a_plain_rule_where_a_drawn_one_cannot_be_shown(coast, reference):
    text = run("cp1252", "rank-pairs", reference).stdout.decode("cp1252")
    assert text == coast("rank-pairs", reference).out.replace("─", "-")


def test_a_name_that_is_no_unicode_is_written_as_its_escape(coast, reference_text, tmp_path):
    config = tmp_path / os.fsdecode(b"bad\xff.toml")
    config.write_text(reference_text)
    for suffix in ("json", "csv", "txt"):
        assert coast("validate", config, "-o", tmp_path / f"a.{suffix}").code == 0
        assert "bad\\udcff.toml" in (tmp_path / f"a.{suffix}").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "a.json").read_text())["rows"][0]["config"].endswith("bad\udcff.toml")


@pytest.mark.parametrize(("name", "cell"), NAMES.items(), ids=[ascii(name) for name in NAMES])
def test_a_name_is_no_formula_and_no_control_character(name, cell):
    stream = io.StringIO()
    render(Answer("demo", [{"name": name, "value": -1.5, "count": 3, "holds": True, "nothing": None}]), stream)
    assert guarded(name) == cell
    assert list(csv.reader(io.StringIO(stream.getvalue())))[1] == [cell, "-1.5", "3", "true", ""]
    table = io.StringIO()
    render_table(Answer("demo", [{"name": name}]), table)
    assert "\x1b" not in table.getvalue()


def test_a_guarded_name_comes_back_as_it_was(coast, tmp_path):
    path = tmp_path / "rec.csv"
    path.write_text(
        "run,outer,middle,bending_length_mm,stroke_mm,curvature_per_m\n" + '"\'=1+2",OT4,MT1,20,1,1\n' * 2,
        encoding="utf-8",
    )
    ran = coast("recordings", path, "-f", "json")
    assert json.loads(ran.out)["rows"][0]["run"] == "=1+2"
    assert "'=1+2" in coast("recordings", path, "-f", "csv").out


def test_an_empty_front_is_a_csv_with_its_header(coast, edited, tmp_path):
    config = edited(("max_total_precurvature_rad = 0.30", "max_total_precurvature_rad = 1e-9"))
    with config.open("a", encoding="utf-8") as stream:
        stream.write("\n[explore]\ntubes = 8\nrefinements = 0\nouter.depth_mm = { min = 0.32, max = 0.39 }\n")
    ran = coast("explore", config, "-o", tmp_path / "front.csv")
    assert ran.code == 0, ran.err
    assert (tmp_path / "front.csv").read_text(encoding="utf-8") == ",".join(COLUMNS["explore"]) + "\n"
