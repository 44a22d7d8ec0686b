"""``coast compare`` with several models, its residuals, and the part of a recording between two times."""

import csv
import json

import pytest

HEADER = "run,time_s,stroke_mm,bend_deg,load_n_m\n"


@pytest.fixture
def device(tmp_path):
    """Two models of one transmission, and a recording that the second one foretells to the letter."""
    for name, ratio in (("first", 9.0), ("second", 10.0)):
        (tmp_path / f"{name}.toml").write_text(f'[joint]\nkind = "transmission"\nratio = {ratio}\n')
    rows = [f"{run},{0.1 * k:.1f},{s},{10 * s},0.5\n" for run in "ab" for k, s in enumerate((-2, -1, 0, 1, 2, 1, 0))]
    (tmp_path / "r.csv").write_text(HEADER + "".join(rows))
    return tmp_path


def test_several_models_stand_in_one_table(coast, device):
    models = ("--model", device / "first.toml", "--model", device / "second.toml")
    ran = coast("compare", device / "first.toml", device / "r.csv", *models, "-f", "json")
    rows = json.loads(ran.out)["rows"]
    assert [(row["run"], row["model"].rpartition("/")[2]) for row in rows[:4]] == [
        ("a", "first.toml"),
        ("a", "second.toml"),
        ("b", "first.toml"),
        ("b", "second.toml"),
    ]
    errors = {row["model"].rpartition("/")[2]: row["rmse_bend_deg"] for row in rows if row["run"] == "all"}
    assert errors["second.toml"] == pytest.approx(0.0, abs=1e-9)
    assert errors["first.toml"] == pytest.approx((11.0 / 7.0) ** 0.5)
    one = json.loads(coast("compare", device / "first.toml", device / "r.csv", "-f", "json").out)["rows"]
    assert "model" not in one[0]


def test_residuals_are_written_with_their_time(coast, device):
    file = device / "left.csv"
    ran = coast("compare", device / "first.toml", device / "r.csv", "--residuals", file, "--from", "0.3")
    assert ran.code == 0
    assert "run" in ran.out
    assert "6 of 14 rows lie outside" in ran.err
    with file.open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 8
    assert rows[0] == {
        "model": str(device / "first.toml"),
        "run": "a",
        "line": "5",
        "time_s": "0.3",
        "drive": "1.0",
        "quantity": "bend_deg",
        "recorded": rows[0]["recorded"],
        "predicted": rows[0]["predicted"],
        "residual": rows[0]["residual"],
    }
    assert float(rows[0]["recorded"]) == pytest.approx(10.0)
    assert float(rows[0]["residual"]) == pytest.approx(1.0)


def test_a_picture_has_a_line_for_each_model(coast, device):
    pytest.importorskip("matplotlib")
    models = ("--model", device / "first.toml", "--model", device / "second.toml")
    ran = coast("compare", device / "first.toml", device / "r.csv", *models, "--plot", device / "both.svg")
    assert ran.code == 0
    assert (device / "both.svg").stat().st_size > 1000


def test_times_that_leave_nothing_are_refused(coast, device):
    ran = coast("recordings", device / "r.csv", "--from", "5")
    assert ran.code == 3
    assert "times from 0 to 0.6 s" in ran.err
    assert coast("compare", device / "first.toml", device / "r.csv", "--from", "2", "--to", "1").code == 2
