"""A table of cells: marks that could be read in two ways, and many columns."""

from time import process_time

import pytest

from coast_cli.errors import BadInput
from coast_cli.recordings.read import read_recordings

JOINT = "run,time_s,outer,middle,bending_length_mm,stroke_mm,curvature_per_m\n"
ROWS = "a,0,OT4,MT1,30,1.5,0\na,0.1,OT4,MT1,30,2.0,8.5\na,0.2,OT4,MT1,30,2.5,17\n"


@pytest.fixture
def written(tmp_path):
    def write(text, name="rec.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def only_run(recordings):
    (run,) = recordings.joint.runs
    return run


def test_a_thousand_with_a_point_beside_decimal_commas_is_refused_with_its_line(written):
    text = "outer;middle;bending_length_mm;stroke_mm;tension_mn;curvature_per_m\n"
    rows = "OT4;MT1;30;1,5;950;0\nOT4;MT1;30;1,6;1.000;8,5\nOT4;MT1;30;1,7;1.050;9\n"
    refused = r":3:5: tension_mn: a thousand or one; found '1\.000'; allowed: a number without points"
    with pytest.raises(BadInput, match=refused):
        read_recordings([written(text + rows)])
    plain = read_recordings([written(text + rows.replace("1.0", "10"), "plain.csv")])
    assert only_run(plain).tension.tolist() == pytest.approx([0.95, 1.0, 1.05])


def test_a_comma_in_a_name_makes_no_decimal_commas(written):
    text = "run;outer;middle;bending_length_mm;stroke_mm;curvature_per_m\n"
    rows = "a, b;OT4;MT1;30;1.500;0\na, b;OT4;MT1;30;2.000;8.5\n"
    assert only_run(read_recordings([written(text + rows)])).stroke == pytest.approx([1.5e-3, 2e-3])


def test_a_name_that_our_csv_guards_is_read_back(written):
    named = JOINT + ROWS.replace("a,", "'=a,")
    assert only_run(read_recordings([written(named)])).name == "=a"


def test_many_unknown_columns_are_counted_not_listed(written):
    names = [f"foreign_{number}" for number in range(30)]
    text = ",".join(["bending_length_mm,stroke_mm,curvature_per_m", *names]) + "\n"
    read = read_recordings([written(text + "\n".join([",".join(["20", *"12"[:2], *"1" * 30])] * 2))], pair="MT1")
    unknown = [note for note in read.notes if "not known" in note]
    assert len(unknown) == 21
    assert unknown[-1].endswith(": 10 more columns are not known and not used.")


@pytest.mark.parametrize("name", ["foreign_{}", "notch_{}_deg"])
def test_columns_are_read_in_a_time_in_proportion_to_their_number(written, name):
    def seconds(count):
        names = [name.format(number + 1) for number in range(count)]
        extra = ["curvature_per_m"] if name.startswith("foreign") else []
        header = ",".join(["bending_length_mm", "stroke_mm", *extra, *names])
        row = ",".join(["20"] + ["1"] * (len(extra) + 1 + count))
        path = written(f"{header}\n{row}\n{row}\n", f"{count}.csv")
        start = process_time()
        read_recordings([path], pair="MT1")
        return process_time() - start

    few, many = (min(seconds(count) for _ in range(3)) for count in (3_000, 48_000))
    assert many < 40 * few  # 16 times as many columns; 256 times the time where each is looked for among all
