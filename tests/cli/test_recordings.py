"""``coast recordings``, ``compare`` and ``calibrate`` from the command line, on the synthetic example."""

import json
from pathlib import Path

import numpy as np
import pytest

from coast_cli.output.columns import COLUMNS
from coast_cli.spec.load import load_config

RECORDING = Path(__file__).parents[2] / "examples" / "diagnose" / "recording.csv"
FIT = ("--fit", "youngs_modulus_gpa,deadband_mm")
WORDS = {
    "recordings": (RECORDING, "--config", "{config}"),
    "compare": ("{config}", RECORDING),
    "calibrate": ("{config}", RECORDING),
}


def words_of(command, reference):
    return [str(word).format(config=reference) for word in WORDS[command]]


@pytest.mark.parametrize("command", WORDS)
def test_rows_are_the_documented_columns_and_bytes_repeat(coast, reference, command):
    ran = coast(command, *words_of(command, reference), "-f", "json")
    answer = json.loads(ran.out)
    assert ran.code == 0
    assert answer["schema"] == f"coast.{command}/1"
    names = [name for name in COLUMNS[command] if name in answer["rows"][0]]
    assert all(list(row) == names for row in answer["rows"])
    assert {name for name in COLUMNS[command] if not name.startswith(("correlation", "model"))} <= set(names)
    assert len(answer["provenance"]["recordings"][0]["sha256"]) == 64
    assert coast(command, *words_of(command, reference), "-f", "json") == ran
    assert coast(command, *words_of(command, reference), "-f", "csv").code == 0
    assert coast(command, *words_of(command, reference)).out.strip()


def test_what_can_be_decided_is_said_on_stderr(coast):
    ran = coast("recordings", RECORDING)
    assert ran.code == 0
    assert "release is recorded in 4 of 4 runs" in ran.err
    assert "release is recorded" not in ran.out


def test_compare_before_and_after_calibration(coast, reference, tmp_path):
    model = tmp_path / "calibrated.toml"
    ran = coast("calibrate", reference, RECORDING, *FIT, "--hold-out", "large-20", "-o", model, "-f", "json")
    assert ran.code == 0
    assert "release wants deadband_mm" in ran.err
    assert "runs held out (large-20)" in ran.err
    text = model.read_text(encoding="utf-8")
    assert text.startswith("# Written by coast calibrate")
    assert "# Fitted joint.deadband_mm = " in text
    row = json.loads(ran.out)["rows"][1]
    assert load_config(model).joint.deadband_mm == row["value"]

    def pooled(*words):
        return json.loads(coast("compare", *words, "-f", "json").out)["rows"][-1]

    before, after = pooled(reference, RECORDING), pooled(reference, RECORDING, "--model", model)
    assert after["rmse_curvature_per_m"] < 0.6 * before["rmse_curvature_per_m"]
    assert pooled(model, RECORDING)["rmse_curvature_per_m"] == after["rmse_curvature_per_m"]
    assert before["run"] == "all"
    assert before["n"] == 356


def test_calibrate_writes_both_kinds_of_file(coast, reference, tmp_path):
    files = [tmp_path / name for name in ("m.toml", "rows.json", "rows.csv", "rows.txt")]
    ran = coast("calibrate", reference, RECORDING, *FIT, *[word for file in files for word in ("-o", file)])
    assert ran.out == ""
    assert all(file.stat().st_size for file in files)


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_plots_are_the_same_bytes(coast, reference, tmp_path, suffix):
    first, second = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
    for path in (first, second):
        assert coast("compare", reference, RECORDING, "--plot", path).code == 0
    assert first.stat().st_size > 10_000
    if suffix == "png":
        assert first.read_bytes() == second.read_bytes()


def test_shapes_and_joints_in_one_call(coast, reference, tmp_path):
    arc = np.linspace(0.0, 90.0, 40)
    lines = ["tube,x_mm,y_mm", *(f"OT3,{s:.3f},{-1e-3 * s * s:.3f}" for s in arc)]
    shape = tmp_path / "shape.csv"
    shape.write_text("\n".join(lines) + "\n", encoding="utf-8")
    plot = tmp_path / "both.png"
    rows = json.loads(coast("compare", reference, RECORDING, shape, "-f", "json", "--plot", plot).out)["rows"]
    assert [row["run"] for row in rows][-3:] == ["shape", "mean", "all"]
    assert rows[-3]["rmse_shape_mm"] > 0.0
    assert rows[-1]["rmse_shape_mm"] == rows[-3]["rmse_shape_mm"]
    assert plot.exists()


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--columns", "stroke_mm"), 2, "OURS=THEIRS"),
        (("--columns", "stroke_mm=nope"), 3, "does not have"),
        (("--columns", "stroke_mm=stroke"), 3, "Did you mean stroke_mm?"),
        (("--columns", "stroke_um=nope"), 3, "does not have"),
        (("--model", "none.toml"), 3, "no such file"),
        (("--plot", "x.bmp"), 2, "suffix"),
    ],
)
def test_wrong_words(coast, reference, words, code, said):
    ran = coast("compare", reference, RECORDING, *words)
    assert ran.code == code
    assert said in ran.err
    assert "Traceback" not in ran.err


def test_bad_recordings_are_one_sentence_with_exit_code_3(coast, reference, tmp_path):
    path = tmp_path / "bad.csv"
    path.write_text("stroke_mm,curvature_per_m\n1,2\n2,x\n", encoding="utf-8")
    for command in ("compare", "calibrate"):
        ran = coast(command, reference, path, "--x2", "20")
        assert (ran.code, ran.out) == (3, "")
        assert f"{path}:3:2: curvature_per_m: not a number; found 'x'" in ran.err
    assert coast("recordings", path, "--x2", "20", "--pair", "M").code == 3


def test_the_real_sets_are_read_compared_and_calibrated(coast, shared):
    for name, unit in (("notched_wrist", "rmse_notch_deg"), ("tendon_sheath", "rmse_bend_deg")):
        folder = shared / name
        files = sorted(folder.glob("*.csv"))
        assert coast("recordings", *files, "--config", folder / "tubes.toml").code == 0
        rows = json.loads(coast("compare", folder / "tubes.toml", *files, "-f", "json").out)["rows"]
        assert rows[-1][unit] > 10.0
        assert 0.1 < rows[-1]["noise"] < 1.5
        assert coast("calibrate", folder / "tubes.toml", *files, "--fit", "youngs_modulus_gpa").code == 0
