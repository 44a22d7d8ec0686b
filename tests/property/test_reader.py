"""Whatever stands in a file, the reader gives the numbers that were written, or one sentence; never anything else."""

import csv
import io
import itertools

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from coast_cli.errors import BadInput
from coast_cli.recordings.read import read_recordings


def attempt(path):
    """Return (recording, None) or (None, refusal)."""
    try:
        return read_recordings([path], pair="M", bending_length_mm=20.0).joint, None
    except BadInput as refusal:
        return None, refusal


PER_EXAMPLE = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
numbers = st.floats(-1e6, 1e6, allow_nan=False)
names = st.text("abcXYZ019 _-.é", min_size=1, max_size=8).map(str.strip).filter(bool)


@st.composite
def recordings(draw):
    runs = draw(st.lists(names, min_size=1, max_size=4, unique=True))
    counts = [draw(st.integers(2, 6)) for _ in runs]
    total = sum(counts)
    stroke = draw(st.lists(numbers, min_size=total, max_size=total))
    bend = draw(st.lists(st.none() | numbers, min_size=total, max_size=total))
    starts = np.cumsum([0, *counts])
    for start, stop in itertools.pairwise(starts):
        if all(value is None for value in bend[start:stop]):
            bend[start] = 1.0
    return runs, counts, stroke, bend


@PER_EXAMPLE
@given(
    recording=recordings(),
    separator=st.sampled_from(",;\t"),
    ending=st.sampled_from(["\n", "\r\n"]),
    quoting=st.sampled_from([csv.QUOTE_MINIMAL, csv.QUOTE_ALL]),
    bom=st.booleans(),
    comma=st.booleans(),
)
def test_what_was_written_is_read(tmp_path, recording, separator, ending, quoting, bom, comma):
    runs, counts, stroke, bend = recording

    def number(value):
        text = "" if value is None else repr(value)
        return text.replace(".", ",") if comma and separator == ";" else text

    stream = io.StringIO(newline="")
    writer = csv.writer(stream, delimiter=separator, lineterminator=ending, quoting=quoting)
    writer.writerow(["run", "stroke_m", "bend_rad"])
    writer.writerows(
        (name, number(s), number(b)) for name, s, b in zip(np.repeat(runs, counts), stroke, bend, strict=True)
    )
    path = tmp_path / "rec.csv"
    path.write_bytes((b"\xef\xbb\xbf" if bom else b"") + stream.getvalue().encode())
    read = read_recordings([path], pair="M", bending_length_mm=20.0).joint
    assert [run.name for run in read.runs] == runs
    assert [len(run) for run in read.runs] == counts
    assert np.concatenate([run.stroke for run in read.runs]).tolist() == stroke
    found = np.concatenate([run.response[:, 0] for run in read.runs])
    assert found == pytest.approx(np.array([np.nan if b is None else b for b in bend]), nan_ok=True, rel=0, abs=0)
    assert np.concatenate([run.line for run in read.runs]).tolist() == list(range(2, 2 + sum(counts)))


@PER_EXAMPLE
@given(
    data=st.binary(max_size=200)
    | st.text("0123456789.,;-eE\n\r\t\"'ab_ stroke_mm bend_deg run", max_size=200).map(str.encode)
    | st.text(max_size=100).map(lambda text: ("stroke_mm,bend_deg\n1,2\n" + text).encode())
)
def test_anything_else_is_one_sentence(tmp_path, data):
    path = tmp_path / "rec.csv"
    path.write_bytes(data)
    recording, refusal = attempt(path)
    assert recording is not None or ("\n" not in str(refusal) and str(path) in str(refusal))


@PER_EXAMPLE
@given(
    recording=recordings(), row=st.integers(0, 30), column=st.integers(0, 2), junk=st.text("xyz#?\"';\n ", max_size=3)
)
def test_a_spoiled_cell_never_passes_for_a_number(tmp_path, recording, row, column, junk):
    runs, counts, stroke, bend = recording
    rows = [
        [n, repr(s), "" if b is None else repr(b)]
        for n, s, b in zip(np.repeat(runs, counts).tolist(), stroke, bend, strict=True)
    ]
    row %= len(rows)
    rows[row][column] += junk
    path = tmp_path / "rec.csv"
    path.write_text("run,stroke_m,bend_rad\n" + "\n".join(map(",".join, rows)) + "\n", encoding="utf-8", newline="")
    read, refusal = attempt(path)
    if refusal is not None:
        assert refusal.line is None or 1 <= refusal.line <= len(rows) + 4
        return
    assert column == 0 or not junk.strip() or not set(junk) & set("xyz#?")
    assert set(np.concatenate([run.stroke for run in read.runs]).tolist()) <= set(stroke)
