"""Help where a new user looks for it: `coast` alone, -h, `coast help`, examples that run, completion, swapped arguments."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from coast_cli.cli.app import COMMANDS, FIRST, TABLES
from coast_cli.cli.examples import EXAMPLES

ROOT = Path(__file__).parents[2]
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
# Run with the README, the guide and the walk, or with tests of their own; here they would only take time.
SHOWN_ELSEWHERE = {"explore", "tolerance", "trace", "calibrate", "diagnose", "report", "plan", "design", "compare"}


def test_coast_alone_says_what_to_do_first(coast):
    ran = coast()
    assert (ran.code, ran.err, ran.out) == (0, "", FIRST)
    assert "coast init" in ran.out


@pytest.mark.parametrize("name", COMMANDS)
def test_every_help_has_examples_and_all_ways_to_it_agree(coast, name):
    ran = coast(name, "--help")
    assert (ran.code, ran.err) == (0, "")
    assert ran == coast("help", name) == coast(name, "-h")
    for words in EXAMPLES[name]:
        assert f"coast {name} {words}".strip() in ran.out
    assert ("--show" in ran.out) == (name in TABLES)
    assert "--quiet" in ran.out


def test_the_help_of_all_is_found_too(coast):
    assert coast("help") == coast("-h") == coast("--help")
    assert coast("help", "rank").code == 2


@pytest.mark.parametrize("name", sorted(set(COMMANDS) - SHOWN_ELSEWHERE))
def test_examples_run_as_they_stand(coast, name, tmp_path, monkeypatch):
    for folder in ("configs", "examples"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    monkeypatch.chdir(tmp_path)
    for words in EXAMPLES[name]:
        assert coast(name, *shlex.split(words)).code in {0, 1}, words


@pytest.mark.parametrize(("line", "offered"), [("coast ra", "rank-pairs"), ("coast stroke --ka", "--kappa")])
def test_a_shell_is_told_how_a_line_may_go_on(line, offered):
    words = {"_COAST_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}
    command = [sys.executable, "-m", "coast_cli"]
    ran = subprocess.run(command, env=os.environ | words, capture_output=True, text=True, check=True, cwd=ROOT)
    assert ran.stdout.split() == [offered]


@pytest.mark.parametrize("words", [("compare", RECORDING), ("path", ROOT / "examples/path/branch.csv", "--path")])
def test_swapped_arguments_are_said(coast, reference, words):
    ran = coast(*words, reference)
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.endswith("tubes.toml is: the configuration comes first.\n")


def test_quiet_leaves_the_data_and_the_errors(coast, reference):
    loud, quiet = coast("rank-pairs", reference), coast("rank-pairs", reference, "--quiet")
    assert loud.err
    assert (quiet.out, quiet.err) == (loud.out, "")
    assert coast("rank-pairs", "absent.toml", "-q").err.startswith("coast: absent.toml")


def test_rows_and_columns_are_chosen_in_every_format(coast, reference):
    words = ("rank-pairs", reference, "--show", "sample,score", "--sort", "-score", "--top", "2")
    rows = json.loads(coast(*words, "-f", "json").out)["rows"]
    assert [list(row) for row in rows] == [["sample", "score"]] * 2
    assert rows[0]["score"] > rows[1]["score"]
    assert coast(*words, "-f", "csv").out.splitlines()[0] == "sample,score"
    assert coast(*words).out.splitlines()[0].split() == ["sample", "score"]
    ran = coast("rank-pairs", reference, "--show", "scroe")
    assert (ran.code, ran.out) == (2, "")
    assert "Did you mean score?" in ran.err


@pytest.mark.parametrize("width", [30, 60, 200])
def test_the_page_of_a_diagnosis_fits_the_terminal(coast, reference, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    ran = coast("diagnose", reference, RECORDING, "--max-effects", "1", "-q")
    assert ran.code == 0
    assert max(map(len, ran.out.splitlines())) <= min(width, 80)


@pytest.mark.parametrize("width", [20, 60, 80, 120, 200])
def test_tables_fit_the_terminal(coast, reference, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    for words in (
        ("rank-pairs", reference),
        ("explain", "backlash"),
        ("stroke", reference, "--kappa", "9", "--x2", "20"),
    ):
        assert max(map(len, coast(*words).out.splitlines())) <= width
    wide = coast("rank-pairs", reference, "--wide").out
    monkeypatch.delenv("COLUMNS")
    assert wide == coast("rank-pairs", reference).out


def test_another_value_stands_for_that_of_the_file(coast, edited, reference):
    changed = edited(("depth_mm = 0.400 ", "depth_mm = 0.390 "))
    words = ("-f", "json", "--set", "outer.samples.OT4.depth_mm=0.39")
    found = json.loads(coast("rank-pairs", reference, *words).out)
    assert found["rows"] == json.loads(coast("rank-pairs", changed, "-f", "json").out)["rows"]
    (origin,) = found["provenance"]["configs"]
    assert origin["set"] == ["outer.samples.OT4.depth_mm=0.39"]
    ran = coast("stroke", reference, "--kappa", "20", "--x2", "20", "--set", "joint.pair=OT3/MT1", "-f", "json")
    assert json.loads(ran.out)["rows"][0]["outer"] == "OT3"


@pytest.mark.parametrize(
    ("assignment", "code", "said"),
    [
        ("outer.samples.OT9.depth_mm=1", 2, "there is no OT9; allowed: OT1, OT2, OT3, OT4"),
        ("joint.deadband_mm", 2, "allowed: KEY=VALUE"),
        ("joint.pair.deep=1", 2, "pair is a value, not a table"),
        ("joint.deadbnd_mm=1", 3, "Did you mean deadband_mm?"),
        ("joint.deadband_mm=wide", 3, "joint.deadband_mm: not allowed; found 'wide'"),
    ],
)
def test_a_change_that_cannot_be_is_refused(coast, reference, assignment, code, said):
    ran = coast("rank-pairs", reference, "--set", assignment)
    assert (ran.code, ran.out) == (code, "")
    assert said in ran.err


def test_a_change_needs_a_file(coast, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert coast("stroke", "--kappa", "9", "--x2", "20", "--set", "joint.deadband_mm=1").code == 2
