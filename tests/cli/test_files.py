"""Files written with -o appear whole or not at all, each in the format of its suffix."""

import json

import pytest

from coast_cli.errors import NotConverged
from coast_cli.output.answer import Answer, Columns
from coast_cli.output.atomic import write_files
from coast_cli.output.write import write_answer


def test_each_suffix_its_format_and_nothing_on_stdout(coast, reference, tmp_path):
    paths = [tmp_path / name for name in ("ranking.json", "ranking.csv", "ranking.txt")]
    ran = coast("rank-pairs", reference, *(word for path in paths for word in ("-o", path)))
    assert (ran.code, ran.out) == (0, "")
    for path, name in zip(paths, ("json", "csv", "table"), strict=True):
        assert path.read_text(encoding="utf-8") == coast("rank-pairs", reference, "--format", name).out
    both = coast("rank-pairs", reference, "-o", paths[0], "--format", "csv")
    assert both.out == paths[1].read_text()


def test_junit_is_an_xml_file(coast, reference, tmp_path):
    assert coast("check", reference, "-o", tmp_path / "report.xml").code == 0
    assert (tmp_path / "report.xml").read_text() == coast("check", reference, "-f", "junit").out


def test_a_failed_check_writes_its_report_and_exits_with_1(coast, edited, tmp_path):
    tight = edited(("value = 6.0", "value = 4.0"))
    ran = coast("check", tight, "-o", tmp_path / "report.xml", "-o", tmp_path / "report.json")
    assert (ran.code, ran.out) == (1, "")
    assert "<failure" in (tmp_path / "report.xml").read_text()
    assert not all(row["passed"] for row in json.loads((tmp_path / "report.json").read_text())["rows"])


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_an_answer_that_is_not_a_number_writes_nothing(capsys, tmp_path, value):
    answer = Answer("demo", Columns({"a": [1.0, 2.0], "b": [3.0, value]}))
    with pytest.raises(NotConverged, match="b of row 2 is not a finite number"):
        write_answer(answer, "csv", [tmp_path / "demo.csv"])
    assert capsys.readouterr().out == ""
    assert list(tmp_path.iterdir()) == []


def test_one_place_that_cannot_be_written_leaves_all_unwritten(coast, reference, tmp_path):
    for bad in (tmp_path / "absent" / "a.json", tmp_path / "folder.json"):
        (tmp_path / "folder.json").mkdir(exist_ok=True)
        ran = coast("rank-pairs", reference, "-o", tmp_path / "good.json", "-o", bad)
        assert (ran.code, ran.out) == (2, "")
        assert str(bad) in ran.err
        assert [path.name for path in tmp_path.iterdir()] == ["folder.json"]


def test_a_failure_in_the_middle_keeps_the_old_file(tmp_path):
    path = tmp_path / "kept.txt"
    path.write_text("old")

    def fail(stream):
        stream.write("half")
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_files({tmp_path / "other.txt": lambda stream: stream.write("whole"), path: fail})
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("kept.txt", "old")]


def test_bytes_and_links_are_written_in_place(tmp_path):
    target, link = tmp_path / "target.bin", tmp_path / "link.bin"
    target.write_bytes(b"old")
    link.symlink_to(target)
    write_files({link: lambda stream: stream.write(b"\x00new")}, binary=True)
    assert link.is_symlink()
    assert target.read_bytes() == b"\x00new"


def test_a_device_is_written_not_replaced(coast, reference):
    assert coast("rank-pairs", reference, "-o", "/dev/null").code == 2
    write_files({__import__("pathlib").Path("/dev/null"): lambda stream: stream.write("gone")})


def test_notes_go_to_stderr_and_into_json(capsys):
    answer = Answer("demo", [{"a": 1.5, "b": None}], {}, ("mind the gap.",))
    write_answer(answer, "json")
    out, err = capsys.readouterr()
    assert err == "coast: note: mind the gap.\n"
    assert json.loads(out)["notes"] == ["mind the gap."]
