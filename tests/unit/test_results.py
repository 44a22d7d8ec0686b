"""Results as a Python user meets them: a repr of one screen, a table in a notebook, a DataFrame, one path as text."""

import sys
from types import ModuleType

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
    }


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ranking", "Ranking: 12 rows"),
        ("recordings", "Recordings: 4 runs\n  small-20: OT4/MT1, 89 rows"),
        ("comparison", "Comparison: "),
        ("diagnosis", "Diagnosis: physics."),
    ],
)
def test_a_repr_is_one_screen(results, name, said):
    text = repr(results[name])
    assert text.startswith(said)
    assert len(text.splitlines()) <= 24
    assert max(map(len, text.splitlines())) <= 200


@pytest.mark.parametrize("name", ["ranking", "comparison", "diagnosis"])
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
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(coast.UsageError, match="pip install pandas"):
        results["ranking"].to_dataframe()


@pytest.mark.parametrize("paths", [str(RECORDING), RECORDING, [RECORDING], (str(RECORDING),)])
def test_a_path_is_text_or_a_path_one_or_several(paths):
    assert coast.read_recordings(paths, coast.load_config(REFERENCE)).run_names[0] == "small-20"
