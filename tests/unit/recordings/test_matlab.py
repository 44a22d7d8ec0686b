"""MATLAB files: vectors, matrices and structures as columns; what is no recording is one sentence."""

import io
import zlib
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from coast_cli.errors import BadInput
from coast_cli.recordings import matlab
from coast_cli.recordings.mapping import load_mapping
from coast_cli.recordings.matlab import read_mat
from coast_cli.recordings.matlab_elements import variables_of
from coast_cli.recordings.read import read_recordings

DRIVE = np.linspace(0.0, 4.0, 30)


@pytest.fixture
def saved(tmp_path):
    def save(variables, **options):
        path = tmp_path / "data.mat"
        savemat(path, variables, **options)
        return str(path)

    return save


@pytest.mark.parametrize("options", [{}, {"do_compression": True}, {"format": "4"}, {"oned_as": "column"}])
def test_vectors_are_columns(options, saved, tmp_path):
    path = saved({"X1": DRIVE, "kappa": 3.0 * DRIVE, "short": np.arange(3.0), "length": 20.0}, **options)
    mapping = tmp_path / "map.toml"
    mapping.write_text('[columns]\nstroke_mm = "X1"\ncurvature_per_m = "kappa"\nbending_length_mm = "length"\n')
    read = read_recordings([path], columns=load_mapping(mapping))
    (run,) = read.joint.runs
    assert run.stroke == pytest.approx(1e-3 * DRIVE)
    assert run.response[:, 0] == pytest.approx(3.0 * DRIVE)
    assert run.bending_length == pytest.approx([0.02] * 30)
    assert any("short not used" in note for note in read.notes)


def test_what_scipy_reads_is_read_the_same(saved):
    rng = np.random.default_rng(0)
    kinds = [np.float64, np.float32, np.int8, np.uint8, np.int16, np.uint16, np.int32, np.uint32, np.int64, np.uint64]
    variables = {f"v{i}": (100 * rng.random((7, 1 + i % 3))).astype(kind) for i, kind in enumerate(kinds)}
    variables |= {"flag": np.array([[True, False]]), "text": "drei \u00b0", "empty": np.zeros((0, 3))}
    for options in ({}, {"do_compression": True}):
        path = saved(variables, **options)
        mine, theirs = variables_of(Path(path).read_bytes(), 10**6), loadmat(path)
        for name, value in mine.items():
            expected = theirs[name]
            assert value == expected[0] if isinstance(value, str) else (value == expected).all()
        assert set(mine) == set(variables)


def test_structures_matrices_and_texts(saved):
    path = saved({"log": {"drive": {"mm": DRIVE}, "name": "monday"}, "data": np.column_stack((DRIVE, 2 * DRIVE))})
    table, _ = read_mat(path)
    assert set(table.names) == {"log.drive.mm", "log.name", "data_1", "data_2"}
    assert table.numbers("data_2") == pytest.approx(2 * DRIVE)
    assert table.texts("log.name")[1] == ("monday",)


def test_missing_numbers(saved):
    path = saved({"stroke_mm": DRIVE, "bend_deg": np.where(DRIVE > 3.5, np.nan, DRIVE)})
    assert np.isnan(read_recordings([path]).joint.runs[0].response).any()
    path = saved({"stroke_mm": np.where(DRIVE > 3.5, np.nan, DRIVE), "bend_deg": DRIVE})
    with pytest.raises(BadInput, match="stroke_mm: not a number"):
        read_recordings([path])


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "not a MATLAB file"),
        (b"\x89HDF\r\n\x1a\n", "7.3"),
        (b"MATLAB 7.3 MAT-file" + b" " * 200, "7.3"),
        (b"x" * 300, "not a MATLAB file"),
    ],
)
def test_what_is_no_matlab_file(data, said, tmp_path):
    path = tmp_path / "x.mat"
    path.write_bytes(data)
    with pytest.raises(BadInput, match=said):
        read_recordings([path])


def test_no_vectors(saved):
    with pytest.raises(BadInput, match="no vector"):
        read_mat(saved({"a": 1.0}))
    with pytest.raises(BadInput, match="no vector"):
        read_mat(saved({}))


def test_a_small_file_that_unpacks_to_a_large_one_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(matlab, "LARGEST_FILE", 10_000)
    stream = io.BytesIO()
    savemat(stream, {"a": np.zeros(1_000_000)}, do_compression=True)
    path = tmp_path / "bomb.mat"
    path.write_bytes(stream.getvalue())
    assert len(zlib.compress(stream.getvalue())) < 10_000
    with pytest.raises(BadInput, match="unpacks to too much"):
        read_mat(str(path))
