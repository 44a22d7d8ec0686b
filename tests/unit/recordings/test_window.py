"""The part of recordings between two times."""

import pytest

from coast_cli.errors import BadInput, UsageError
from coast_cli.recordings.read import read_recordings
from coast_cli.recordings.window import between

TEXT = "run,time_s,stroke_mm,bend_deg\n" + "".join(f"a,{t},{t},{2 * t}\n" for t in range(6)) + "b,20,0,0\nb,21,1,2\n"


@pytest.fixture
def read(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text(TEXT)
    return read_recordings([path])


def test_rows_between_two_times_stay_and_the_rest_is_said(read):
    found = between(read, 2.0, 4.0)
    assert [list(run.time) for run in found.joint.runs] == [[2.0, 3.0, 4.0]]
    assert found.joint.runs[0].line[0] == 4
    assert found.notes[-1] == "5 of 8 rows lie outside the times asked for and are left out, and with them the runs b."
    assert len(between(read, 3.0, None).joint.runs) == 2
    assert between(read, None, None) is read


def test_what_cannot_be_chosen_is_refused(read, tmp_path):
    with pytest.raises(UsageError, match="a first time before the last"):
        between(read, 4.0, 2.0)
    with pytest.raises(BadInput, match="times from 0 to 21 s"):
        between(read, 30.0, None)
    path = tmp_path / "untimed.csv"
    path.write_text("stroke_mm,bend_deg\n0,0\n1,2\n2,4\n")
    with pytest.raises(BadInput, match="no time_s"):
        between(read_recordings([path]), 1.0, None)
