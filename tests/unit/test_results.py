"""Results as a Python user meets them: a repr of one screen, a table in a notebook, a DataFrame, one path as text."""

import sys
from types import ModuleType

import numpy as np
import pytest

import coast_cli as coast
from tests.conftest import REFERENCE, ROOT

RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"


@pytest.fixture(scope="module")
def results():
    config = coast.load_config(REFERENCE)
    recordings = coast.read_recordings(str(RECORDING), config)
    return {
        "ranking": coast.rank(config),
        "recordings": recordings,
        "comparison": coast.compare(config, recordings),
        "diagnosis": coast.diagnose(config, recordings),
        "strokes": coast.stroke_table(coast.build(config).joint(), [0.02, 0.04], curvatures=[10.0, 20.0, 40.0]),
        "plan": coast.plan(config, coast.sweep(config, (0.9e-3, 2.8e-3), [0.02])),
        "config": config,
        "design": coast.build(config),
        "joint": coast.build(config).joint(),
        "run": recordings.joint.runs[0],
        "tube": coast.build(config).tube("MT3"),
        "shape": coast.solve_beam(coast.build(config).tube("MT3"), 9.81),
    }


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ranking", "Ranking: 12 rows"),
        ("recordings", "Recordings: 4 runs\n  small-20: OT4/MT1, 89 rows"),
        ("comparison", "Comparison: "),
        ("diagnosis", "Diagnosis: physics."),
        ("strokes", "StrokeTable: 6 rows"),
        ("plan", "Plan: "),
        ("config", "Config: "),
        ("design", "Design:\n  outer = (OT1, OT2, OT3, OT4)"),
        ("joint", "Joint:\n  outer = OT4"),
        ("run", "JointRun:\n  name = 'small-20'"),
        ("tube", "NotchedTube:\n  name = 'MT3'"),
        ("shape", "BeamSolution:\n  s = array of 251, 0 to 0.075"),
    ],
)
def test_a_repr_is_one_screen(results, name, said):
    text = repr(results[name])
    assert text.startswith(said)
    assert len(text.splitlines()) <= 24
    assert max(map(len, text.splitlines())) <= 200


@pytest.mark.parametrize("name", ["ranking", "comparison", "diagnosis", "strokes", "plan"])
def test_a_notebook_shows_it(results, name):
    html = results[name]._repr_html_()
    assert html.startswith("<")
    assert "<script" not in html


def test_rows_are_a_dataframe_where_pandas_is_there(results, monkeypatch):
    stand_in = ModuleType("pandas")
    stand_in.DataFrame = list
    monkeypatch.setitem(sys.modules, "pandas", stand_in)
    rows = results["ranking"].to_dataframe()
    assert len(rows) == 12
    assert rows[0]["sample"] == "S4"
    assert results["comparison"].to_dataframe()[0]["run"] == "small-20"
    assert [row["curvature_per_m"] for row in results["strokes"].to_dataframe()] == [10.0, 20.0, 40.0] * 2
    assert {row["effect"] for row in results["plan"].to_dataframe()} >= {"backlash"}
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(coast.UsageError, match="pip install pandas"):
        results["ranking"].to_dataframe()


@pytest.mark.parametrize("paths", [str(RECORDING), RECORDING, [RECORDING], (str(RECORDING),)])
def test_a_path_is_text_or_a_path_one_or_several(paths):
    assert coast.read_recordings(paths, coast.load_config(REFERENCE)).run_names[0] == "small-20"


@pytest.mark.parametrize("name", ["ranking", "comparison", "diagnosis", "strokes"])
def test_a_result_draws_itself(results, name, tmp_path):
    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    picture = results[name].plot(tmp_path / "picture.svg")
    assert (tmp_path / "picture.svg").read_bytes() == picture.render("svg")
    assert picture._repr_png_().startswith(b"\x89PNG")
    assert picture.figure().get_axes()


def test_without_matplotlib_a_picture_is_one_sentence(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(coast.UsageError, match=r"need matplotlib: pip install matplotlib"):
        results["ranking"].plot()


def test_a_diagnosis_predicts_with_its_model(results, tmp_path):
    """What play left out moves the release: the corrected model is nearer the recording than the model as configured."""
    found, recordings = results["diagnosis"], results["recordings"]
    predicted = found.predict(recordings)
    assert set(predicted) == set(recordings.run_names)
    plain = coast.compare(results["config"], recordings)
    for run, other in zip(recordings.joint.runs, plain.joint, strict=True):
        ours, theirs = (np.nanmean((values - run.response) ** 2) for values in (predicted[run.name], other.predicted))
        assert ours < 0.25 * theirs
    drive = {"stroke_mm": [0.5, 1.5, 2.5, 1.5], "bending_length_mm": 30.0}
    (planned,) = found.predict(drive).values()
    assert planned.shape == (4, 1)
    assert planned[3] > planned[1]
    (tmp_path / "model.toml").write_text(found.model_text(), encoding="utf-8")
    assert coast.load_config(tmp_path / "model.toml").corrections == found.model().corrections
    assert "backlash" in found.model().corrections


def test_a_small_space_is_explored_in_one_call():
    text = REFERENCE.read_text(encoding="utf-8")
    space = "[explore]\ntubes = 8\nrefinements = 0\n[explore.outer]\ndepth_mm = { min = 0.314, max = 0.400 }\n"
    found = coast.explore(coast.load_config_text(text[: text.index("[checks]")] + space))
    assert repr(found).startswith(f"Exploration: {len(found.rows)} rows")
    assert found.to_dataframe is not None
    assert len(found.rows) >= 1
    with pytest.raises(coast.BadInput, match="from the text of a configuration"):
        coast.explore(coast.Config.model_validate(coast.load_config_text(text).model_dump()))


@pytest.mark.parametrize("ask", [coast.calibrate, coast.compare, coast.diagnose])
def test_a_path_in_place_of_what_is_read_from_it_is_one_sentence(results, ask):
    with pytest.raises(coast.BadInput, match="no recordings; found 'str'; allowed: what read_recordings returns"):
        ask(results["config"], str(RECORDING))
    with pytest.raises(coast.BadInput, match=r"no configuration; found '\w+Path'; allowed: what load_config returns"):
        ask(REFERENCE, results["recordings"])
