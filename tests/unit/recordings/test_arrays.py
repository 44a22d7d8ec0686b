"""Recordings from arrays and DataFrames: the same runs as from a file of the same cells, and the same sentences."""

import csv

import numpy as np
import pytest

from coast_cli.errors import BadInput
from coast_cli.recordings.read import read_protocol, read_recordings
from coast_cli.spec.load import load_config
from tests.conftest import REFERENCE, ROOT

RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
CONFIG = load_config(REFERENCE)
TEXTS = ("run", "outer", "middle")


def columns():
    with RECORDING.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    return {name: [row[name] if name in TEXTS else float(row[name] or "nan") for row in rows] for name in rows[0]}


class Frame:
    """What is asked of a DataFrame, whatever library it is of."""

    def __init__(self, data):
        self.data = {name: np.array(values, dtype=object if name in TEXTS else float) for name, values in data.items()}

    @property
    def columns(self):
        return list(self.data)

    def __getitem__(self, name):
        return self.data[name]


@pytest.mark.parametrize("made", [dict, Frame])
def test_the_runs_are_those_of_the_file(made):
    seen, expected = read_recordings(made(columns()), CONFIG), read_recordings(RECORDING, CONFIG)
    assert seen.run_names == expected.run_names
    for one, other in zip(seen.joint.runs, expected.joint.runs, strict=True):
        assert (one.pair, one.kind) == (other.pair, other.kind)
        for name in ("time", "stroke", "bending_length", "response"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_the_same_arrays_have_the_same_digest_and_others_another():
    data = columns()
    digests = [read_recordings(one, CONFIG).sources[0][1] for one in (data, dict(data), data | {"time_s": 2.0})]
    assert digests[0] == digests[1] != digests[2]


def test_a_number_alone_stands_for_the_column_and_nan_is_a_dropped_frame():
    drive = {"stroke_mm": np.arange(1, 6), "curvature_per_m": [1.0, np.nan, 3.0, 4.0, 5.0], "bending_length_mm": 20}
    (run,) = read_recordings(drive | {"middle": "MT1", "outer": "OT4"}, CONFIG).joint.runs
    assert (run.name, run.pair) == ("arrays", "OT4/MT1")
    assert run.bending_length.tolist() == [0.02] * 5
    assert run.valid.tolist() == [True, False, True, True, True]


def test_foreign_names_and_several_tables_go_together():
    drive = {"X1": [1.0, 2.0, 3.0], "kappa": [1.0, 2.0, 3.0]}
    named = {"stroke_mm": "X1", "curvature_per_m": "kappa"}
    found = read_recordings([drive, drive], CONFIG, columns=named, bending_length_mm=20.0)
    assert len(found.joint.runs) == 2
    assert len(set(found.run_names)) == 2


GOOD = {"stroke_mm": [1.0, 2.0, 3.0], "curvature_per_m": [1.0, 2.0, 3.0], "bending_length_mm": 20.0}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"stroke_mm": [1.0, 2.0, np.nan]}, "<arrays>:3:1: stroke_mm: not a number; found 'nan'"),
        ({"stroke_mm": ["1", "2", "up"]}, "<arrays>:3:1: stroke_mm: not a number; found 'up'"),
        ({"stroke_mm": [1.0, 2.0, None]}, "<arrays>:3:1: stroke_mm: an empty cell"),
        ({"stroke_mm": [1.0, 2.0, np.inf]}, "<arrays>:3:1: stroke_mm: not a number; found 'inf'"),
        ({"stroke_mm": [1.0, 2.0]}, "stroke_mm: a column of another length; found 2; allowed: 3"),
        ({"stroke_mm": [[1.0], [2.0], [3.0]]}, "stroke_mm: not one row of values; found 'shape (3, 1)'"),
        ({"stroke_mm": [True, False, True]}, "stroke_mm: neither numbers nor texts; found 'bool'"),
        ({"stroke_mm": np.array(["2026-11-20"] * 3, dtype="datetime64[D]")}, "neither numbers nor texts"),
        ({"bending_length_mm": 20_000.0}, "longer than the notched length"),
    ],
)
def test_what_cannot_be_is_one_sentence(change, said):
    with pytest.raises(BadInput) as caught:
        read_recordings(GOOD | change, CONFIG)
    assert said in str(caught.value)


@pytest.mark.parametrize("nothing", [{}, {"stroke_mm": []}, {"stroke_mm": 1.0}])
def test_no_rows_are_refused(nothing):
    with pytest.raises(BadInput, match="no rows"):
        read_recordings(nothing, CONFIG)


def test_a_protocol_may_leave_out_the_response():
    runs, _ = read_protocol({"stroke_mm": [1.0, 2.0, 3.0], "bending_length_mm": 30.0}, CONFIG)
    assert runs[0].stroke.tolist() == [0.001, 0.002, 0.003]
