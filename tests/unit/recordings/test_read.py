"""Reading recordings: other people's files come in unedited, and what is wrong is said with file, line and column."""

import re
import tracemalloc

import numpy as np
import pytest

from coast_cli.errors import BadInput
from coast_cli.recordings import table
from coast_cli.recordings.device import split_pair
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import REFERENCE, load_config

JOINT = "run,time_s,outer,middle,bending_length_mm,stroke_mm,curvature_per_m\n"
ROWS = "a,0,OT4,MT1,30,1.5,0\na,0.1,OT4,MT1,30,2.0,8.5\na,0.2,OT4,MT1,30,2.5,17\n"


@pytest.fixture
def config():
    return load_config(REFERENCE)


@pytest.fixture
def written(tmp_path):
    def write(text, name="rec.csv"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def only_run(recordings):
    (run,) = (recordings.joint or recordings.shape).runs
    return run


def test_a_plain_file(written, config):
    recordings = read_recordings([written(JOINT + ROWS)], config)
    run = only_run(recordings)
    assert (run.name, run.outer, run.middle, run.kind, run.pair) == ("a", "OT4", "MT1", "curvature", "OT4/MT1")
    assert run.line.tolist() == [2, 3, 4]
    assert run.time.tolist() == [0.0, 0.1, 0.2]
    assert run.bending_length == pytest.approx([0.03] * 3)
    assert run.stroke == pytest.approx([1.5e-3, 2e-3, 2.5e-3])
    assert run.response.tolist() == [[0.0], [8.5], [17.0]]
    assert run.tension is None
    assert run.drive is run.stroke
    assert recordings.notes == ()
    assert recordings.shape is None
    assert recordings.run_names == ("a",)


PLAIN = (JOINT + ROWS).encode()


@pytest.mark.parametrize(
    "data",
    [
        b"\xef\xbb\xbf" + PLAIN,
        PLAIN.replace(b"\n", b"\r\n"),
        PLAIN.replace(b"\n", b"\r"),
        b"\n" + PLAIN,
        PLAIN.replace(b"\n", b"\n\n"),
        PLAIN.rstrip(b"\n"),
        PLAIN.replace(b",", b";"),
        PLAIN.replace(b",", b";").replace(b".", b","),
        PLAIN.replace(b",", b"\t"),
        PLAIN.replace(b",", b", "),
        PLAIN.replace(b"OT4", b'"OT4"').replace(b"2.5", b'"2.5"'),
        PLAIN.replace(b"\n", b",\n"),
        b"".join(b'"' + line.replace(b",", b'","') + b'"\n' for line in PLAIN.splitlines()),
    ],
    ids=[
        "bom",
        "crlf",
        "cr",
        "blank-first",
        "blank-between",
        "no-newline",
        "semicolon",
        "decimal-comma",
        "tab",
        "spaces",
        "quotes",
        "trailing",
        "all-quoted",
    ],
)
def test_the_same_numbers_however_the_file_was_saved(data, written, config):
    run = only_run(read_recordings([written(data)], config))
    assert (run.name, run.pair) == ("a", "OT4/MT1")
    assert run.stroke == pytest.approx([1.5e-3, 2e-3, 2.5e-3], rel=1e-15)
    assert run.time.tolist() == [0.0, 0.1, 0.2]
    assert run.response.tolist() == [[0.0], [8.5], [17.0]]


def test_decimal_commas_are_said(written, config):
    data = PLAIN.replace(b",", b";").replace(b".", b",")
    assert "decimal commas" in read_recordings([written(data)], config).notes[0]


def test_a_bending_length_in_metres_is_doubted(written, config):
    doubted = "run 'a' has a bending length below one pitch, 0.6 mm: is it in mm?"
    assert doubted in read_recordings([written(JOINT + ROWS.replace(",30,", ",0.03,"))], config).notes[0]


def test_a_renaming_the_wrong_way_round_is_told(written):
    with pytest.raises(BadInput, match=re.escape("Ours comes first: stroke_mm=X1 [mm].")):
        read_recordings([written("X1 [mm],kappa\n1,2\n")], columns={"X1 [mm]": "stroke_mm"})


def test_blank_lines_keep_line_numbers(written, config):
    run = only_run(read_recordings([written(b"\n\n" + PLAIN.replace(b"\na,0.1", b"\n\na,0.1"))], config))
    assert run.line.tolist() == [4, 6, 7]


@pytest.mark.parametrize(
    ("name", "cell", "attribute", "expected"),
    [
        ("stroke_um", "2000", "stroke", 2e-3),
        ("stroke_m", "0.002", "stroke", 2e-3),
        ("Stroke_mm", "2", "stroke", 2e-3),
        ("tension_n", "2", "tension", 2.0),
        ("tension_mN", "2000", "tension", 2.0),
    ],
)
def test_units_of_the_drive_by_suffix(name, cell, attribute, expected, written):
    run = only_run(read_recordings([written(f"{name},bend_deg\n{cell},1\n{cell},2\n")], pair="M", bending_length_mm=20))
    assert getattr(run, attribute) == pytest.approx([expected] * 2, rel=1e-15)
    assert run.drive == pytest.approx([expected] * 2)


@pytest.mark.parametrize(
    ("name", "cell", "kind", "expected"),
    [
        ("curvature_per_mm", "0.02", "curvature", 20.0),
        ("curvature_per_m", "20", "curvature", 20.0),
        ("bend_deg", "180", "bend", np.pi),
        ("bend_rad", "3.5", "bend", 3.5),
        ("notch_1_rad", "0.1", "notch", 0.1),
        ("notch_1_deg", "90", "notch", np.pi / 2),
    ],
)
def test_units_of_the_response_by_suffix(name, cell, kind, expected, written):
    run = only_run(
        read_recordings([written(f"stroke_mm,{name}\n1,{cell}\n2,{cell}\n")], pair="M", bending_length_mm=20)
    )
    assert run.kind == kind
    assert run.response == pytest.approx(np.full((2, 1), expected), rel=1e-15)


def test_foreign_names_and_defaults(written, config):
    path = written("X1,kappa,ambient\n1500,0.001,20\n2000,0.002,20\n", "monday.csv")
    columns = {"stroke_um": "X1", "curvature_per_mm": "kappa"}
    recordings = read_recordings([path], config, columns=columns, bending_length_mm=25.0)
    run = only_run(recordings)
    assert (run.name, run.pair) == ("monday", "OT4/MT1")
    assert run.bending_length == pytest.approx([0.025] * 2)
    assert run.stroke == pytest.approx([1.5e-3, 2e-3])
    assert run.response[:, 0] == pytest.approx([1.0, 2.0])
    assert "'ambient'" in recordings.notes[0]


def test_pair_from_option_beats_the_config(written, config):
    path = written("stroke_mm,bend_deg\n1,0\n2,3\n")
    assert only_run(read_recordings([path], config, pair="OT1/MT3", bending_length_mm=20)).pair == "OT1/MT3"
    assert only_run(read_recordings([path], config, pair="MT3", bending_length_mm=20)).outer is None


def test_an_empty_outer_cell_is_a_joint_of_one_tube(written, config):
    run = only_run(read_recordings([written((JOINT + ROWS).replace("OT4", ""))], config))
    assert (run.outer, run.pair) == (None, "MT1")


def test_notches_in_any_order_of_columns(written):
    run = only_run(
        read_recordings(
            [written("tension_n,notch_2_deg,notch_1_deg,notch_3_deg\n0,2,1,3\n1,2,1,3\n")],
            pair="M",
            bending_length_mm=8,
        )
    )
    assert np.degrees(run.response) == pytest.approx(np.array([[1, 2, 3], [1, 2, 3]]))


def test_dropped_frames_are_nan_and_nothing_else_is(written, config):
    run = only_run(read_recordings([written((JOINT + ROWS).replace(",8.5", ",").replace(",17", ",NaN"))], config))
    assert run.valid.tolist() == [True, False, False]
    assert np.isnan(run.response[1:, 0]).all()


def test_tension_beside_stroke_is_a_witness(written):
    run = only_run(
        read_recordings([written("stroke_mm,tension_n,bend_deg\n1,3,0\n2,4,1\n")], pair="M", bending_length_mm=9)
    )
    assert run.tension.tolist() == [3.0, 4.0]
    assert run.drive == pytest.approx([1e-3, 2e-3])


def test_the_most_detailed_response_is_read_and_the_other_named(written):
    recordings = read_recordings(
        [written("stroke_mm,bend_deg,curvature_per_m\n1,3,0\n2,4,1\n")], pair="M", bending_length_mm=9
    )
    assert only_run(recordings).kind == "curvature"
    assert "bend_deg is not used" in recordings.notes[0]


def test_many_files_and_same_run_names(written, config):
    recordings = read_recordings([written(JOINT + ROWS, "one.csv"), written(JOINT + ROWS, "two.csv")], config)
    assert recordings.run_names == ("one:a", "two:a")
    assert len(recordings.sources) == 2
    assert recordings.sources[0][1] == recordings.sources[1][1]
    assert "FILE:RUN" in recordings.notes[0]


def test_both_kinds_in_a_call(written, config):
    shape = "run,tube,x_mm,y_mm,natural\ns,OT1,0,0,up\ns,OT1,10,-1,up\ns,OT1,20,-3,up\n"
    recordings = read_recordings([written(JOINT + ROWS, "j.csv"), written(shape, "s.csv")], config)
    assert recordings.run_names == ("a", "s")
    (run,) = recordings.shape.runs
    assert (run.outer, run.middle, run.natural, run.pair) == ("OT1", None, "up", "OT1")
    assert run.x == pytest.approx([0.0, 0.01, 0.02])
    assert run.y == pytest.approx([0.0, -0.001, -0.003])


@pytest.mark.parametrize(
    ("columns", "cells", "expected"),
    [
        ("tube,", "MT1,", (None, "MT1")),
        ("outer,middle,", "OT1,MT1,", ("OT1", "MT1")),
        ("outer,middle,", "OT1,,", ("OT1", None)),
        ("", "", ("OT4", "MT1")),
    ],
)
def test_tubes_of_a_shape(columns, cells, expected, written, config):
    text = f"{columns}x_mm,y_mm\n" + "".join(f"{cells}{i},{-i * i}\n" for i in range(4))
    run = only_run(read_recordings([written(text)], config))
    assert (run.outer, run.middle) == expected


def row(number, text):
    """Return the reference file with its n-th line (from 1) replaced."""
    lines = (JOINT + ROWS).splitlines()
    lines[number - 1] = text
    return "\n".join(lines) + "\n"


BAD = {
    "missing column": ("run,stroke_mm\na,1\na,2\n", 1, None, "no response column"),
    "no drive": ("run,bend_deg\na,1\na,2\n", 1, None, "no drive column"),
    "no kind": ("foo,bar\n1,2\n3,4\n", 1, None, "by a mapping"),
    "wrong unit": ("stroke_cm,bend_deg\n1,2\n3,4\n", 1, 1, "stroke_mm"),
    "no unit": ("stroke,bend_deg\n1,2\n3,4\n", 1, 1, "without a unit"),
    "wrong notch unit": ("stroke_mm,notch_1_mm\n1,2\n3,4\n", 1, 2, "notch"),
    "notch from 2": ("stroke_mm,notch_2_deg\n1,2\n3,4\n", 1, None, "count from 1"),
    "column twice": ("stroke_mm,stroke_mm,bend_deg\n1,1,2\n2,2,3\n", 1, None, "same name"),
    "quantity twice": ("stroke_mm,stroke_m,bend_deg\n1,1,2\n2,2,3\n", 1, None, "two columns"),
    "text in a number": (row(3, "a,0.1,OT4,MT1,30,two,8.5"), 3, 6, "'two'"),
    "hexadecimal": (row(3, "a,0.1,OT4,MT1,30,0x2,8.5"), 3, 6, "'0x2'"),
    "underscore": (row(3, "a,0.1,OT4,MT1,30,1_0,8.5"), 3, 6, "'1_0'"),
    "infinity": (row(3, "a,0.1,OT4,MT1,30,inf,8.5"), 3, 6, "'inf'"),
    "overflow": (row(3, "a,0.1,OT4,MT1,30,1e999,8.5"), 3, 6, "'1e999'"),
    "other digits": (row(3, "a,0.1,OT4,MT1,30,\N{ARABIC-INDIC DIGIT TWO},8.5"), 3, 6, "not a number"),
    "nan in a drive": (row(3, "a,0.1,OT4,MT1,30,nan,8.5"), 3, 6, "'nan'"),
    "text in a response": (row(4, "a,0.2,OT4,MT1,30,2.5,lost"), 4, 7, "'lost'"),
    "empty drive": (row(3, "a,0.1,OT4,MT1,30,,8.5"), 3, 6, "empty cell"),
    "empty run": (row(3, ",0.1,OT4,MT1,30,2.0,8.5"), 3, 1, "empty cell"),
    "short row": (row(3, "a,0.1,OT4"), 3, None, "3 cells"),
    "long row": (row(3, "a,0.1,OT4,MT1,30,2.0,8.5,9"), 3, None, "8 cells"),
    "time back": (row(4, "a,0.05,OT4,MT1,30,2.5,17"), 4, 2, "time goes back"),
    "unknown outer": ((JOINT + ROWS).replace("OT4", "OT5"), 2, 3, "OT1, OT2, OT3, OT4"),
    "unknown middle": ((JOINT + ROWS).replace("MT1", "MT9"), 2, 4, "MT1"),
    "tube changes": (row(3, "a,0.1,OT3,MT1,30,2.0,8.5"), 3, 3, "changes within a run"),
    "empty middle": ((JOINT + ROWS).replace("MT1", ""), 2, 4, "no middle tube"),
    "too long": (row(3, "a,0.1,OT4,MT1,76,2.0,8.5"), 3, 5, "up to 75 mm"),
    "zero length": (row(3, "a,0.1,OT4,MT1,0,2.0,8.5"), 3, 5, "must be positive"),
    "run mixed": (JOINT + ROWS + ROWS.replace("a,", "b,") + ROWS, 8, 1, "begins again"),
    "one sample": (JOINT + "a,0,OT4,MT1,30,1.5,0\n", 2, None, "one sample"),
    "all dropped": (JOINT + "a,0,OT4,MT1,30,1.5,\na,1,OT4,MT1,30,1.5,\n", 2, None, "missing"),
    "no rows": (JOINT, 1, None, "no rows"),
    "empty": ("", None, None, "empty"),
    "blank": ("\n\n", None, None, "empty"),
    "binary": (b"\x89PNG\r\n\x1a\n\xff\xfe", 1, None, "UTF-8"),
    "utf-16": ((JOINT + ROWS).encode("utf-16"), 1, None, "UTF-8"),
    "latin-1": ((JOINT + ROWS).encode() + "ä".encode("latin-1"), 5, None, "UTF-8"),
    "no such tube": ("run,tube,x_mm,y_mm\ns,XX,0,0\ns,XX,1,0\ns,XX,2,0\n", 2, 2, "'XX'"),
    "no y": ("run,tube,x_mm\ns,OT1,0\ns,OT1,1\n", 1, None, "y_mm"),
    "two points": ("tube,x_mm,y_mm\nOT1,0,0\nOT1,1,0\n", 2, None, "2 points"),
    "same point": ("tube,x_mm,y_mm\nOT1,0,0\nOT1,0,0\nOT1,1,0\n", 3, None, "coincide"),
    "wrong side": ("tube,x_mm,y_mm,natural\nOT1,0,0,left\nOT1,1,0,left\nOT1,2,0,left\n", 2, 4, "up, down"),
    "too many notches": (
        "tension_n," + ",".join(f"notch_{i}_deg" for i in range(1, 127)) + "\n" + 2 * (",".join("1" * 127) + "\n"),
        2,
        127,
        "125",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_said_with_its_place(case, written, config):
    text, line, column, words = BAD[case]
    path = written(text)
    with pytest.raises(BadInput) as caught:
        read_recordings([path], config, bending_length_mm=30)
    error = caught.value
    assert (error.exit_code, error.file, error.line, error.column) == (3, str(path), line, column)
    assert words in str(error)
    assert "\n" not in str(error)


def test_a_missing_file_a_folder_and_a_file_given_twice(tmp_path, written):
    with pytest.raises(BadInput, match="cannot be read"):
        read_recordings([tmp_path / "none.csv"])
    with pytest.raises(BadInput, match="cannot be read"):
        read_recordings([tmp_path])
    path = written(JOINT + ROWS)
    with pytest.raises(BadInput, match="given twice"):
        read_recordings([path, path])
    with pytest.raises(BadInput, match="no recording"):
        read_recordings([])


def test_a_huge_file_is_refused_before_it_is_read(written, monkeypatch):
    monkeypatch.setattr(table, "LARGEST_FILE", 100)
    with pytest.raises(BadInput, match="too large"):
        read_recordings([written(JOINT + 10 * ROWS)])


@pytest.mark.parametrize(
    ("columns", "words"),
    [({"stroke_mm": "X1"}, "does not have"), ({"strokes": "stroke_mm"}, "Did you mean")],
)
def test_wrong_renaming(columns, words, written):
    with pytest.raises(BadInput, match=words):
        read_recordings([written("stroke_um,bend_deg\n1,1\n2,1\n")], columns=columns, pair="M", bending_length_mm=9)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"pair": "OT9/MT1"}, "OT9"),
        ({"pair": "OT1/"}, "OUTER/MIDDLE"),
        ({"bending_length_mm": -1.0}, "positive"),
        ({"bending_length_mm": None}, "bending length X2"),
    ],
)
def test_wrong_options(options, words, written, config):
    with pytest.raises(BadInput, match=words):
        read_recordings([written("stroke_mm,bend_deg\n1,1\n2,1\n")], config, **{"bending_length_mm": 20.0, **options})


def test_pairs():
    assert split_pair("A/B") == ("A", "B")
    assert split_pair(" B ") == (None, "B")
    for wrong in ("", "A/", "A/B/C"):
        with pytest.raises(BadInput):
            split_pair(wrong)


def test_memory_stays_near_the_size_of_the_file(written):
    rows = 60_000
    body = "".join(f"{i * 1e-4:.5f},{i % 977 * 1e-2:.4f}\n" for i in range(rows))
    path = written("stroke_mm,bend_deg\n" + body)
    tracemalloc.start()
    read_recordings([path], pair="M", bending_length_mm=9)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 12 * path.stat().st_size


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("stroke_mm,bend_deg\n1,2\n3,1e16\n", "too large for any recording"),
        ("stroke_mm,bend_deg,note\n1,2,a\n3,4," + "b" * 20_000 + "\n", "a cell is too long; found '20000 characters'"),
        (
            'stroke_mm,bend_deg,note\n1,2,"a"\n3,4,' + "b" * 20_000 + "\n",
            "a cell is too long; found '20000 characters'",
        ),
        (
            'stroke_mm,bend_deg,note\n1,2,"a\n3,4,' + "b" * 200_000 + "\n",
            "not a CSV file: field larger than field limit",
        ),
        ("stroke_mm,notch_" + "1" * 5000 + "_deg\n1,2\n3,4\n", "no response column"),
    ],
)
def test_cells_past_all_bounds_are_refused(written, text, said):
    with pytest.raises(BadInput, match=re.escape(said)):
        read_recordings([written(text)], pair="M", bending_length_mm=9)


def test_a_table_wider_than_memory_and_quotes_past_theirs_are_refused(written, monkeypatch):
    monkeypatch.setattr(table, "LARGEST_COLUMN", 1000)
    with pytest.raises(BadInput, match="at most 5 in a table of 200 rows"):
        read_recordings([written("stroke_mm,bend_deg\n" + "1,2.00000\n" * 200)], pair="M", bending_length_mm=9)
    monkeypatch.setattr(table, "LARGEST_QUOTED", 1000)
    with pytest.raises(BadInput, match="quoted cells"):
        read_recordings([written("stroke_mm,bend_deg\n" + '1,"2"\n' * 200)], pair="M", bending_length_mm=9)


def test_a_stream_that_never_ends_and_a_name_that_cannot_be_are_refused(monkeypatch):
    monkeypatch.setattr(table, "LARGEST_FILE", 10_000)
    for path, said in (("/dev/zero", "too large"), ("a\0b", "cannot be read")):
        with pytest.raises(BadInput, match=said):
            read_recordings([path], pair="M", bending_length_mm=9)
