"""``coast diagnose`` from the command line, on the synthetic example: streams, files, exit codes, bad input.

What is asked here of the answer itself is little, since the effects are proved elsewhere: the play is found, and the
model file that is written gives the errors that were promised.
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from coast_cli.__main__ import main
from coast_cli.diagnosis.thresholds import thresholds_digest
from coast_cli.spec.digest import config_digest
from coast_cli.spec.load import load_config

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / "configs" / "tubes.toml"
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
HEADER = "run,time_s,bending_length_mm,stroke_mm,curvature_per_m\n"


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory):
    """One run of the command with every output."""
    folder = tmp_path_factory.mktemp("diagnosed")
    words = ["diagnose", CONFIG, RECORDING, "--hold-out", "large-20", "--save-model", folder / "model.toml"]
    words += ["--plot", folder / "plot.svg", "--report", folder / "report.html", "-o", folder / "answer.json"]
    code = main([str(word) for word in [*words, "-o", folder / "answer.txt", "--max-effects", "2"]])
    return code, folder


@pytest.fixture
def recording(tmp_path):
    def write(text, name="recording.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def run_of(name, strokes, *, length=20.0, noise=0.25, seed=1):
    """Rows of a run whose curvature follows the stroke in a line, with white noise."""
    bent = 14.3 * np.maximum(strokes - np.float64(1.2), 0.0) + noise * np.random.default_rng(seed).normal(
        size=len(strokes)
    )
    return "".join(
        f"{name},{2.0 * index:g},{length:g},{stroke:.4f},{kappa:.4f}\n"
        for index, (stroke, kappa) in enumerate(zip(strokes, bent, strict=True))
    )


def test_all_files_appear_and_the_answer_follows_the_contract(diagnosed):
    code, folder = diagnosed
    answer = json.loads((folder / "answer.json").read_text(encoding="utf-8"))
    assert code == 0
    assert sorted(path.name for path in folder.iterdir()) == [
        "answer.json",
        "answer.txt",
        "model.toml",
        "plot.svg",
        "report.html",
    ]
    assert answer["schema"] == "coast.diagnosis/1"
    assert answer["verdict"] == "physics"
    assert answer["effects"][0]["id"] == "backlash"
    assert answer["effects"][0]["parameters"]["width_mm"]["value"] == pytest.approx(0.18, abs=0.02)
    assert answer["where"][0]["share"] > 0.9
    assert answer["fit"]["held_out_runs"] == ["large-20"]
    assert answer["fit"]["with_effects"]["held_out"] < 0.5 * answer["fit"]["refitted"]["held_out"]
    assert answer["provenance"]["configs"][0]["sha256"] == config_digest(load_config(CONFIG))
    assert answer["provenance"]["seed"] == 0


def test_the_page_says_what_the_json_says(diagnosed):
    _, folder = diagnosed
    page = (folder / "answer.txt").read_text(encoding="utf-8")
    assert "verdict: physics" in page
    assert "backlash: play in the actuator" in page
    assert max(map(len, page.splitlines()[:-1])) <= 80


def test_the_model_file_loads_and_names_its_origin_without_a_clock(diagnosed):
    _, folder = diagnosed
    text = (folder / "model.toml").read_text(encoding="utf-8")
    model, config = load_config(folder / "model.toml"), load_config(CONFIG)
    assert model.corrections["backlash"]["width_mm"] == pytest.approx(0.18, abs=0.02)
    assert model.joint.deadband_mm != config.joint.deadband_mm
    assert model.outer == config.outer
    assert config_digest(config) in text
    assert re.search(rf"# Recording .*{RECORDING.name}, sha256 [0-9a-f]{{64}}\n", text)
    assert not re.search(r"\b20\d\d-\d\d-\d\d|\d\d:\d\d", text)


def test_compare_on_the_model_file_gives_the_promised_errors(coast, diagnosed):
    _, folder = diagnosed
    promised = json.loads((folder / "answer.json").read_text(encoding="utf-8"))["fit"]
    ran = coast("compare", CONFIG, RECORDING, "--model", folder / "model.toml", "--format", "json")
    rows = {row["run"]: row for row in json.loads(ran.out)["rows"]}
    assert rows["large-20"]["rmse_curvature_per_m"] == pytest.approx(promised["with_effects"]["held_out"], rel=1e-9)
    assert rows["large-20"]["rmse_tip_mm"] == pytest.approx(promised["tip_mm"]["with_effects"], rel=1e-9)


def test_a_corrected_model_that_is_right_is_not_corrected_again(coast, diagnosed):
    _, folder = diagnosed
    ran = coast("diagnose", folder / "model.toml", RECORDING, "--format", "json", "--max-effects", "1")
    assert json.loads(ran.out)["verdict"] in {"agrees", "parameters"}


def test_without_effects_to_try_the_model_file_holds_parameters_only(coast, tmp_path):
    ran = coast(
        "diagnose", CONFIG, RECORDING, "--max-effects", "0", "--save-model", tmp_path / "m.toml", "--format", "json"
    )
    assert json.loads(ran.out)["effects"] == []
    assert load_config(tmp_path / "m.toml").corrections == {}


def test_same_input_same_bytes(coast, recording):
    up = np.linspace(1.0, 3.0, 40)
    path = recording(HEADER + run_of("a", [*up, *up[::-1]]) + run_of("b", [*up, *up[::-1]], seed=2))
    first, second = (coast("diagnose", CONFIG, path, "--format", "json", "--max-effects", "1") for _ in range(2))
    assert first.out == second.out


def test_fail_on_mismatch(coast):
    words = ("diagnose", CONFIG, RECORDING, "--max-effects", "0", "--format", "json")
    assert coast(*words).code == 0
    assert coast(*words, "--fail-on-mismatch").code == 1


def test_agreement_does_not_fail(coast, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = coast("stroke", CONFIG, "--x2", "20", "--stroke", "1.3:3.2:0.02", "-o", "table.json")
    rows = json.loads(Path("table.json").read_text(encoding="utf-8"))["rows"]
    random = np.random.default_rng(5)
    lines = [
        f"{row['stroke_mm']:.4f},{row['curvature_per_m'] + 0.25 * random.normal():.4f}" for row in rows + rows[::-1]
    ]
    Path("clean.csv").write_text("stroke_mm,curvature_per_m\n" + "\n".join(lines) + "\n", encoding="utf-8")
    ran = coast(
        "diagnose", CONFIG, "clean.csv", "--x2", "20", "--max-effects", "1", "--fail-on-mismatch", "--format", "json"
    )
    assert made.code == 0
    assert json.loads(ran.out)["verdict"] == "agrees"
    assert ran.code == 0


def test_little_is_not_enough(coast, recording):
    ran = coast("diagnose", CONFIG, recording(HEADER + run_of("a", np.linspace(1.5, 3.0, 7))), "--format", "json")
    answer = json.loads(ran.out)
    assert answer["verdict"] == "insufficient"
    assert "7 samples" in answer["reason"]
    assert answer["next_recording"]
    assert answer["fit"] is None


def test_one_run_without_release_or_time_is_a_weaker_claim(coast, recording):
    text = run_of("a", np.linspace(1.0, 3.0, 80))
    rows = "\n".join(",".join(line.split(",")[2:]) for line in text.splitlines())
    path = recording("bending_length_mm,stroke_mm,curvature_per_m\n" + rows + "\n")
    notes = " ".join(json.loads(coast("diagnose", CONFIG, path, "--format", "json", "--max-effects", "1").out)["notes"])
    assert "no time_s" in notes
    assert "no release" in notes
    assert "weaker" in notes


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--hold-out", "large20"), 3, "Did you mean large-20"),
        (("--without", "backlash,backlsh"), 3, "Did you mean backlash"),
        (("--noise", "0"), 2, "a number above 0"),
        (("--format", "csv"), 2, "allowed: table, json"),
        (("--save-model", "model.json"), 2, "allowed: .toml"),
        (("--max-effects", "-1"), 2, "max-effects"),
        (("--plot", "no/such/plot.png"), 2, "there is no folder"),
        (("--report", "no/such/report.html"), 2, "there is no folder"),
        (("--columns", "stroke_mm"), 2, "columns stroke_mm"),
        (("-o", "."), 2, "this is a folder"),
    ],
)
def test_a_wrong_option_is_one_sentence(coast, words, code, said):
    ran = coast("diagnose", CONFIG, RECORDING, *words)
    assert ran.code == code
    assert ran.out == ""
    assert said in ran.err
    assert ran.err.count("\n") == 1


def test_effects_left_out_are_neither_named_nor_rivals_and_the_noise_is_as_given(coast):
    words = ("--without", "backlash, sensor_lag", "--noise", "0.3", "--max-effects", "1", "--format", "json")
    answer = json.loads(coast("diagnose", CONFIG, RECORDING, *words).out)
    named = {effect["id"] for effect in answer["effects"]} | {one for ids in answer["alternatives"] for one in ids}
    assert not named & {"backlash", "sensor_lag"}
    assert answer["provenance"]["options"]["without"] == ["backlash", "sensor_lag"]
    assert answer["provenance"]["options"]["noise"] == 0.3


def test_the_numbers_that_decide_stand_in_the_provenance(diagnosed):
    _, folder = diagnosed
    answer = json.loads((folder / "answer.json").read_text(encoding="utf-8"))
    assert answer["provenance"]["thresholds_sha256"] == thresholds_digest()


def test_every_run_held_out(coast):
    words = [word for name in ("small-20", "large-20", "small-40", "large-40") for word in ("--hold-out", name)]
    ran = coast("diagnose", CONFIG, RECORDING, *words)
    assert ran.code == 3
    assert "none is left" in ran.err


@pytest.fixture
def shapes(coast, tmp_path):
    """Two tubes as ``coast beam`` draws them, with 0.05 mm of noise."""
    random = np.random.default_rng(3)
    lines = ["run,tube,x_mm,y_mm"]
    for tube in ("OT3", "MT2"):
        rows = json.loads(coast("beam", CONFIG, "--tube", tube, "--points", "40", "--format", "json").out)["rows"]
        for row in rows:
            x, y = (row[name] + 0.05 * random.normal() for name in ("x_mm", "y_mm"))
            lines.append(f"{tube},{tube},{x:.4f},{y:.4f}")
    path = tmp_path / "shapes.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_shapes_are_diagnosed_drawn_and_saved_alike(coast, shapes, tmp_path):
    words = ("--max-effects", "1", "--plot", tmp_path / "s.png", "--report", tmp_path / "s.html", "--format", "json")
    ran = coast("diagnose", CONFIG, shapes, *words, "--save-model", tmp_path / "s.toml")
    answer = json.loads(ran.out)
    assert answer["verdict"] == "agrees"
    assert answer["noise"]["unit"] == "shape_mm"
    assert answer["noise"]["value"] == pytest.approx(0.05, rel=0.5)
    assert (tmp_path / "s.png").read_bytes()[:4] == b"\x89PNG"
    assert "data:image/png" in (tmp_path / "s.html").read_text(encoding="utf-8")
    assert load_config(tmp_path / "s.toml").outer.samples[2].natural_curvature_per_m == pytest.approx(5.5, rel=0.2)


def test_of_both_kinds_both_are_diagnosed(coast, shapes):
    ran = coast("diagnose", CONFIG, RECORDING, shapes, "--max-effects", "0", "--format", "json")
    answer = json.loads(ran.out)
    assert answer["noise"]["unit"] == "curvature_per_m"
    assert answer["shapes"]["noise"]["unit"] == "shape_mm"
    assert answer["carried_over"] == {"used": False, "without": None, "with": None}
    assert [one["name"] for one in answer["shared"]] == ["youngs_modulus_over_configured"]


def test_text_among_numbers_has_its_place(coast, recording):
    path = recording(HEADER + run_of("a", np.linspace(1.0, 3.0, 40)).replace("1.0000,", "one,", 1))
    ran = coast("diagnose", CONFIG, path)
    assert ran.code == 3
    assert f"{path}:2:" in ran.err
    assert "stroke_mm" in ran.err


def test_a_curvature_in_another_unit_than_it_says_is_refused(coast, recording):
    rows = "".join(f"{1.2 + 0.02 * n:.3f},{14.3 * 0.02 * n:.4f}\n" for n in range(80))
    ran = coast("diagnose", CONFIG, recording("stroke_mm,curvature_per_mm\n" + rows), "--x2", "20")
    assert ran.code == 3
    assert "bent tighter than its tube is thick" in ran.err
    assert "Is the unit" in ran.err


def test_runs_that_cannot_be_pooled_are_refused(coast, recording):
    bends = "stroke_mm,bend_deg\n" + "".join(f"{1.0 + 0.1 * n},{n}\n" for n in range(20))
    ran = coast("diagnose", CONFIG, RECORDING, recording(bends), "--x2", "20")
    assert ran.code == 3
    assert "found 'bend over stroke'; allowed: curvature over stroke" in ran.err


def test_the_example_is_what_its_script_writes():
    from importlib.util import module_from_spec, spec_from_file_location

    spec = spec_from_file_location("generate", RECORDING.with_name("generate.py"))
    generate = module_from_spec(spec)
    spec.loader.exec_module(generate)
    assert "\n".join(generate.rows()) + "\n" == RECORDING.read_text(encoding="utf-8")
