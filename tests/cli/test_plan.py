"""``coast plan`` from the command line: rows, notes, protocol files, refusals."""

import json

import pytest

from coast_cli.effects.catalogue import effects_of

SWEEP = ("--drive", "0.9:2.8", "--x2", "20")


def rows_of(ran):
    return {row["effect"]: row for row in json.loads(ran.out)["rows"]}


@pytest.fixture
def protocol(tmp_path):
    def write(text):
        path = tmp_path / "protocol.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def drive(*columns, count=60, response=""):
    """A load and release; column texts are formatted with the time t (s), stroke x (mm)."""
    lines = []
    for index in range(count):
        t = 0.5 * index
        x = 0.9 + 2.0 * (1.0 - abs(2.0 * index / (count - 1) - 1.0))
        lines.append(",".join(column.format(t=t, x=x) for column in columns) + response)
    return "\n".join(lines) + "\n"


def test_rows_answer_for_the_whole_catalogue_what_is_told_apart_first(coast, reference):
    ran = coast("plan", reference, *SWEEP, "--format", "json")
    rows = rows_of(ran)
    assert ran.code == 0
    assert set(rows) == set(effects_of("joint"))
    assert [row["told_apart"] for row in rows.values()] == sorted(
        (r["told_apart"] for r in rows.values()), reverse=True
    )
    assert rows["backlash"]["told_apart"]
    assert rows["camera_scale"]["reason"] == "refitted parameters take it"
    assert "noise 0.25 1/m (assumed)" in ran.err
    assert "tension is not recorded" in ran.err


def test_same_input_same_bytes(coast, reference):
    assert coast("plan", reference, *SWEEP).out == coast("plan", reference, *SWEEP).out


def test_a_protocol_file_needs_no_response(coast, reference, protocol):
    path = protocol("time_s,stroke_mm\n" + drive("{t:.3f}", "{x:.4f}"))
    rows = rows_of(coast("plan", reference, "--protocol", path, "--x2", "20", "--noise", "0.3", "--format", "json"))
    assert rows["backlash"]["told_apart"]


def test_a_protocol_without_time_says_what_that_costs(coast, reference, protocol):
    path = protocol("bending_length_mm,stroke_mm\n" + drive("20", "{x:.4f}"))
    rows = rows_of(coast("plan", reference, "--protocol", path, "--format", "json"))
    assert rows["sensor_lag"]["reason"] == "needs time"


def test_a_bend_of_the_segment_is_planned_in_degrees(coast, reference):
    ran = coast("plan", reference, *SWEEP, "--response", "bend", "--format", "json")
    assert "noise 0.5 deg" in ran.err
    assert rows_of(ran)["backlash"]["visible"]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ((), 2, "either --protocol FILE.csv or --drive LOW:TOP"),
        (("--drive", "3:1", "--x2", "20"), 2, "drive 3:1"),
        (("--drive", "0.9:2.8"), 2, "bending lengths X2 are needed"),
        (("--drive", "0.9:2.8", "--x2", "400"), 2, "at most 75 mm"),
        (("--drive", "0.9:2.8", "--x2", "20", "--noise", "0"), 2, "--noise"),
        (("--drive", "0.9:2.8", "--x2", "20", "--response", "notch"), 2, "allowed: curvature, bend"),
        (("--drive", "0.9:2.8", "--x2", "20", "--pair", "OT9/MT1"), 3, "OT9"),
        (("--protocol", "no-such.csv", "--x2", "20"), 3, "no-such.csv"),
    ],
)
def test_a_wrong_plan_is_one_sentence(coast, reference, words, code, said):
    ran = coast("plan", reference, *words)
    assert ran.code == code
    assert ran.out == ""
    assert said in ran.err
    assert ran.err.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("stroke_mm\n" + "1.5\n" * 30, "never moves"),
        ("stroke_mm\n1.0\n1.5\n2.0\n", "too few samples"),
        ("stroke_mm\n1.0\nup\n2.0\n", ":3:"),
        ("time_s\n1.0\n2.0\n", "no drive column"),
        ("x_mm,y_mm\n0,0\n1,0\n2,0\n", "no drive column"),
    ],
)
def test_a_wrong_protocol_is_one_sentence(coast, reference, protocol, text, said):
    ran = coast("plan", reference, "--protocol", protocol(text), "--x2", "20")
    assert ran.code == 3
    assert said in ran.err
    assert ran.err.count("\n") == 1
