"""``coast path``: rows, exit codes, pictures, and one sentence for what is wrong."""

import csv
import io
import json
import math
from pathlib import Path

import pytest

from coast_cli.output.columns import COLUMNS

EXAMPLE = Path(__file__).parents[2] / "examples" / "path" / "branch.csv"
CORRECTIONS = "\n[corrections.backlash]\nwidth_mm = 0.18\n[corrections.capstan_hysteresis]\npulley_friction = 0.05\n"


@pytest.fixture
def written(tmp_path):
    def write(text, name="path.csv"):
        file = tmp_path / name
        file.write_text(text, encoding="utf-8")
        return file

    return write


def rows(ran):
    return json.loads(ran.out)["rows"]


def test_the_rows_are_the_documented_columns_in_every_format(coast, reference):
    ran = coast("path", reference, "--path", EXAMPLE, "-f", "json")
    answer = json.loads(ran.out)
    assert ran.code == 0
    assert answer["schema"] == "coast.path/1"
    assert all(list(row) == list(COLUMNS["path"]) for row in answer["rows"])
    assert [row["feed_mm"] for row in answer["rows"]] == pytest.approx([0, 18, 22, 30, 40, 50, 58, 62, 70, 80])
    assert len(answer["provenance"]["recordings"][0]["sha256"]) == 64
    assert answer["provenance"]["options"]["pair"] == "OT4/MT1"
    lines = list(csv.DictReader(io.StringIO(coast("path", reference, "--path", EXAMPLE, "-f", "csv").out)))
    assert [float(line["stroke_mm"]) for line in lines] == [row["stroke_mm"] for row in answer["rows"]]
    assert coast("path", reference, "--path", EXAMPLE, "-f", "json") == ran


def test_points_are_even_feeds_and_back_adds_the_way_out(coast, reference):
    found = rows(coast("path", reference, "--path", EXAMPLE, "--points", "5", "--back", "-f", "json"))
    assert [row["feed_mm"] for row in found] == pytest.approx([0, 20, 40, 60, 80, 60, 40, 20, 0])
    assert [row["way"] for row in found] == ["in"] * 5 + ["out"] * 4


def test_a_path_out_of_reach_exits_with_1_and_says_why(coast, reference, written):
    turned = written("s_mm,kappa_per_m\n0,0\n20,0\n22,40\n40,40\n44,-40\n70,-40\n")
    ran = coast("path", reference, "--path", turned, "-f", "json")
    assert ran.code == 1
    assert "the body stays within 1 mm of" in ran.err
    last = rows(ran)[-1]
    assert (last["reachable"], last["reason"]) == (False, "the body is more than 1 mm off the path")
    assert coast("path", reference, "--path", turned, "--within", "60", "-o", turned.with_suffix(".json")).code == 0


def test_the_limits_of_the_configuration_count(coast, edited):
    small = edited(("max_stroke_mm = { value = 6.0", "max_stroke_mm = { value = 4.0"))
    ran = coast("path", small, "--path", EXAMPLE, "-f", "json")
    assert ran.code == 1
    reasons = [row["reason"] for row in rows(ran)]
    assert reasons[-1] == "stroke above 4 mm (checks.max_stroke_mm)"
    assert reasons[0] is None


def test_pair_and_model(coast, reference, reference_text, written):
    ideal = rows(coast("path", reference, "--path", EXAMPLE, "--back", "-f", "json"))
    other = rows(coast("path", reference, "--path", EXAMPLE, "--pair", "OT1/MT2", "--within", "2", "-f", "json"))
    assert other[4]["tension_n"] > 1.5 * ideal[4]["tension_n"]
    model = written(reference_text + CORRECTIONS, "model.toml")
    ran = coast("path", reference, "--model", model, "--path", EXAMPLE, "--back", "-f", "json")
    assert [config["file"] for config in json.loads(ran.out)["provenance"]["configs"]] == [str(reference), str(model)]
    found = rows(ran)
    there = {row["feed_mm"]: row["stroke_mm"] for row in found if row["way"] == "in"}
    back = {row["feed_mm"]: row["stroke_mm"] for row in found if row["way"] == "out"}
    assert any(abs(there[feed] - back[feed]) > 0.1 for feed in back)
    bent = [row for row in found if row["bending_length_mm"] > 0.0]
    assert all(row["curvature_per_m"] == pytest.approx(ideal[4]["curvature_per_m"], abs=0.1) for row in bent)


def test_the_picture_has_the_path_and_both_controls(coast, reference, tmp_path):
    pytest.importorskip("matplotlib")
    files = [tmp_path / name for name in ("one.svg", "two.svg")]
    for file in files:
        assert coast("path", reference, "--path", EXAMPLE, "--back", "--plot", file).code == 0
    assert files[0].read_bytes() == files[1].read_bytes()
    drawn = files[0].read_text()
    assert all(f"<!-- {text} -->" in drawn for text in ("x (mm)", "feed (mm)", "path", "X1", "X2 bend", "80 mm"))


def test_a_picture_of_a_path_out_of_reach_marks_it(coast, reference, written, tmp_path):
    pytest.importorskip("matplotlib")
    turned = written("s_mm,kappa_per_m\n0,0\n20,0\n22,40\n40,40\n44,-40\n70,-40\n")
    coast("path", reference, "--path", turned, "--plot", tmp_path / "a.svg")
    assert "<!-- out of reach -->" in (tmp_path / "a.svg").read_text()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "cannot be read"),
        ("", "the file is empty"),
        ("s_mm,kapa_per_mm\n0,0\n9,0\n", "Did you mean kappa_per_mm"),
        ("s_mm,kappa_per_inch\n0,0\n9,0\n", "curvature with a unit that is not known"),
        ("s_mm,kappa_per_mm\n0,0\n9,nan\n", ":3:2: kappa_per_mm: not a number"),
        ("s_mm,kappa_per_mm\n9,0\n0,0\n", ":3:1: s_mm: the arc length does not grow"),
        ("x_mm,y_mm\n0,0\n1,0\n1,0\n3,0\n", ":4: two points coincide"),
    ],
)
def test_a_bad_path_is_refused_in_one_sentence(coast, reference, tmp_path, written, text, said):
    file = tmp_path / "path.csv"
    if text is not None:
        written(text)
    ran = coast("path", reference, "--path", file, "-o", tmp_path / "never.csv")
    assert (ran.code, ran.out) == (3, "")
    assert ran.err.startswith("coast: ")
    assert ran.err.count("\n") == 1
    assert said in ran.err
    assert not (tmp_path / "never.csv").exists()


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ((), 2),
        (("--path", EXAMPLE, "--within", "nan"), 2),
        (("--path", EXAMPLE, "--within", "-1"), 2),
        (("--path", EXAMPLE, "--points", "1"), 2),
        (("--path", EXAMPLE, "-f", "yaml"), 2),
        (("--path", EXAMPLE, "--plot", "path.gif"), 2),
        (("--path", EXAMPLE, "--pair", "OT9/MT1"), 3),
        (("--path", EXAMPLE, "--model", "absent.toml"), 3),
    ],
)
def test_exit_codes_and_one_sentence(coast, reference, words, code):
    ran = coast("path", reference, *words)
    assert (ran.code, ran.out) == (code, "")
    assert ran.err.count("\n") == 1


def test_points_of_a_picture_are_a_path_too(coast, reference, written):
    lines = "\n".join(f"{30.0 * math.sin(a / 10):.9f},{30.0 * (1.0 - math.cos(a / 10)):.9f}" for a in range(15))
    ran = coast("path", reference, "--path", written(f"x_mm,y_mm\n{lines}\n"), "-f", "json")
    assert ran.code == 0
    assert "cubic spline through 15 points" in ran.err
    assert rows(ran)[7]["curvature_per_m"] == pytest.approx(1000.0 / 30.0, rel=1e-2)
