"""``coast tolerance``, ``rank-pairs --robust`` and the pictures of designs."""

import json

import pytest

from coast_cli.design import samples
from coast_cli.output.columns import COLUMNS

PNG, SVG = b"\x89PNG", b"<?xml"


def rows(ran):
    return json.loads(ran.out)["rows"]


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("tolerance", ("--samples", "50")),
        ("design", ("--target", "rigidity_ratio_series=2.5")),
        ("rank-pairs", ("--robust",)),
    ],
)
def test_the_rows_are_the_documented_columns_and_the_same_each_time(coast, reference, command, words):
    ran = coast(command, reference, *words, "-f", "json")
    assert ran.code == 0
    assert all(list(row) == list(COLUMNS[command]) for row in rows(ran))
    assert coast(command, reference, *words, "-f", "json") == ran


def test_explored_rows_are_the_documented_columns(coast, tmp_path, reference_text):
    path = tmp_path / "space.toml"
    path.write_text(
        reference_text + "\n[explore]\ntubes = 8\nrefinements = 1\nouter.depth_mm = { min = 0.32, max = 0.39 }\n"
    )
    ran = coast("explore", path, "--top", "5", "-f", "json")
    assert ran.code == 0, ran.err
    assert all(list(row) == list(COLUMNS["explore"]) for row in rows(ran))
    assert coast("explore", path, "--top", "5", "-f", "json") == ran


def test_jobs_give_the_same_bytes(coast, reference):
    words = ("tolerance", reference, "--samples", "4200", "--only", "figure,check", "-f", "json")
    assert coast(*words) == coast(*words, "--jobs", "2")


def test_an_interrupt_keeps_the_samples_and_a_rerun_goes_on(coast, reference, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("tolerance", reference, "--samples", "300", "-f", "json")
    monkeypatch.setattr("coast_cli.design.samples.BLOCK", 100)
    solve, asked = samples.solve_block, []

    def interrupted(task):
        asked.append(task.first)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return solve(task)

    monkeypatch.setattr("coast_cli.design.samples.solve_block", interrupted)
    stopped = coast(*words)
    (kept,) = tmp_path.iterdir()
    assert (stopped.code, stopped.out) == (130, "")
    assert f"{kept.name} keeps 2 blocks, and the same command goes on from there" in stopped.err
    resumed = coast(*words)
    assert asked == [0, 100, 200, 200]
    assert not list(tmp_path.iterdir())
    assert resumed == coast(*words)


def test_only_some_kinds(coast, reference):
    ran = coast("tolerance", reference, "--samples", "50", "--only", "check,first", "-f", "json")
    assert {row["kind"] for row in rows(ran)} == {"check", "first"}
    assert "no [tolerances] table" in ran.err
    ran = coast("tolerance", reference, "--only", "checks")
    assert (ran.code, ran.out) == (2, "")


def test_the_seed_is_in_the_provenance_and_matters(coast, reference):
    one, two = (coast("tolerance", reference, "--samples", "50", "--seed", seed, "-f", "json") for seed in (0, 1))
    assert json.loads(two.out)["provenance"]["seed"] == 1
    assert rows(one) != rows(two)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("depth_mm = { plus_minus = -0.01 }", "plus_minus"),
        ("depth_mm = { plus_minus = 0.01, distribution = 'cauchy' }", "'normal' or 'uniform'"),
        ("depht_mm = { plus_minus = 0.01 }", "Did you mean depth_mm"),
        ("depth_mm = 0.01", "a table"),
    ],
)
def test_bad_tolerances_are_refused_with_their_line(coast, tmp_path, reference_text, table, said):
    path = tmp_path / "tubes.toml"
    path.write_text(f"{reference_text}\n[tolerances]\n{table}\n")
    ran = coast("tolerance", path)
    assert (ran.code, ran.out) == (3, "")
    assert said in ran.err
    assert f"tubes.toml:{len(reference_text.splitlines()) + 3}" in ran.err


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
@pytest.mark.parametrize(
    "words",
    [
        ("rank-pairs", "{config}"),
        ("beam", "{config}", "--tube", "OT4", "--tube", "MT1", "--points", "20"),
        ("stroke", "{config}", "--kappa", "0:40:10", "--x2", "20,40"),
    ],
    ids=lambda words: words[0],
)
def test_pictures_are_pictures_and_the_same_each_time(coast, reference, tmp_path, words, suffix):
    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    words = [word.format(config=reference) for word in words]
    paths = [tmp_path / f"{name}{suffix}" for name in ("one", "two")]
    for path in paths:
        assert coast(*words, "--plot", path).code == 0
    data = [path.read_bytes() for path in paths]
    assert data[0] == data[1]
    assert data[0].startswith({".png": PNG, ".svg": SVG, ".pdf": b"%PDF"}[suffix])


def test_distributions_are_drawn_with_their_limits(coast, reference, tmp_path):
    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    assert coast("tolerance", reference, "--samples", "50", "--plot", tmp_path / "figures.svg").code == 0
    drawn = (tmp_path / "figures.svg").read_text()
    assert all(f"<!-- {text} -->" in drawn for text in ("OT4/MT1, 50 samples", "as drawn", "limit", "stroke X1 (mm)"))


def test_a_front_is_drawn_beside_the_bench(coast, tmp_path, reference_text):
    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    path = tmp_path / "space.toml"
    path.write_text(
        reference_text + "\n[explore]\ntubes = 8\nrefinements = 0\nouter.depth_mm = { min = 0.32, max = 0.39 }\n"
    )
    assert coast("explore", path, "--plot", tmp_path / "front.svg").code == 0
    drawn = (tmp_path / "front.svg").read_text()
    assert all(f"<!-- {text} -->" in drawn for text in ("S4", "S12", "front", "bench", "rigidity ratio, mean"))


def test_a_picture_that_is_none_is_refused(coast, reference, tmp_path):
    ran = coast("rank-pairs", reference, "--plot", tmp_path / "pairs.docx")
    assert (ran.code, ran.out) == (2, "")
    assert ".png" in ran.err
