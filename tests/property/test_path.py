"""Whatever path is asked for: a documented exit code, finite numbers, and controls that add up."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from coast_cli.__main__ import main
from coast_cli.design.follow_leader import deviation, nearest_body
from coast_cli.recordings.planar_path import path_of_curvature

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / "configs" / "tubes.toml"
TEXT = (ROOT / "examples" / "path" / "branch.csv").read_text(encoding="utf-8")
CELLS = ["", "nan", "inf", "-1", "1e308", "x", '"', "1_0", "0.0", "-0.04", "1e-300", "5,5"]
QUIET = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@st.composite
def damaged(draw):
    lines = TEXT.splitlines()
    kind = draw(st.sampled_from(["cut", "cell", "swap", "header", "bytes"]))
    if kind == "cut":
        return TEXT[: draw(st.integers(0, len(TEXT)))].encode()
    row = draw(st.integers(1, len(lines) - 1))
    if kind == "cell":
        cells = lines[row].split(",")
        cells[draw(st.integers(0, 1))] = draw(st.sampled_from(CELLS))
        lines[row] = ",".join(cells)
    elif kind == "swap":
        other = draw(st.integers(1, len(lines) - 1))
        lines[row], lines[other] = lines[other], lines[row]
    elif kind == "header":
        at = draw(st.integers(0, len(lines[0]) - 1))
        lines[0] = lines[0][:at] + draw(st.sampled_from(["", "x", ";", "é", " "])) + lines[0][at + 1 :]
    else:
        at = draw(st.integers(0, len(TEXT) - 1))
        return TEXT[:at].encode() + draw(st.binary(min_size=1, max_size=3)) + TEXT[at + 1 :].encode()
    return "\n".join(lines).encode()


def numbers_in(value):
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from numbers_in(inner)
    elif isinstance(value, float):
        yield value


def answered(capsys, path, *words):
    code = main(["path", str(CONFIG), "--path", str(path), "-f", "json", *words])
    out, err = capsys.readouterr()
    assert code in {0, 1, 2, 3, 4}
    assert "Traceback" not in err
    assert "please report it" not in err
    if code > 1:
        assert out == ""
        assert err.count("\n") == 1
        return code, None
    answer = json.loads(out)
    assert all(math.isfinite(value) for value in numbers_in(answer))
    assert code == int(not all(row["reachable"] for row in answer["rows"]))
    for row in answer["rows"]:
        assert row["outer_advance_mm"] + row["stage_advance_mm"] == pytest.approx(row["feed_mm"], abs=1e-9)
        assert 0.0 <= row["bending_length_mm"] <= row["stage_advance_mm"] + 1e-9
        assert row["reachable"] == (row["reason"] is None)
    return code, answer


@QUIET
@given(content=damaged())
def test_damage_is_refused_in_a_sentence_or_answered_in_numbers(tmp_path, capsys, content):
    path = tmp_path / "path.csv"
    path.write_bytes(content)
    answered(capsys, path, "--within", "1000")


@QUIET
@given(
    step=st.lists(st.floats(0.01, 30.0), min_size=1, max_size=6),
    curvature=st.lists(st.floats(-2000.0, 2000.0), min_size=7, max_size=7),
)
def test_any_curvature_is_answered(tmp_path, capsys, step, curvature):
    path = tmp_path / "path.csv"
    lines = [f"{along!r},{kappa!r}" for along, kappa in zip([0.0, *np.cumsum(step).tolist()], curvature, strict=False)]
    path.write_text("s_mm,kappa_per_m\n" + "\n".join(lines) + "\n")
    code, _ = answered(capsys, path, "--within", "1000")
    assert code in {0, 1}


@QUIET
@given(
    lead=st.floats(0.0, 0.05),
    bend=st.floats(0.005, 0.07),
    tail=st.floats(0.0, 0.05),
    curvature=st.floats(5.0, 40.0),
    side=st.sampled_from([1.0, -1.0]),
)
def test_a_path_of_one_bend_is_followed(lead, bend, tail, curvature, side):
    ends = np.cumsum([0.0, lead + 1e-6, 1e-6, bend, 1e-6, tail + 1e-6])
    path = path_of_curvature(ends, side * np.array([0.0, 0.0, curvature, curvature, 0.0, 0.0]))
    found = nearest_body(path, 0.075, extends=True)
    largest, mean = deviation(path, found, np.linspace(0.0, path.length, 33))
    assert largest.max() < 2e-6
    assert (mean <= largest + 1e-12).all()
    assert np.sign(found.curvature) == side
