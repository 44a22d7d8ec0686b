"""Files written with -o appear whole or not at all, each in the format of its suffix."""

import json
import os
from pathlib import Path

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


def someone_elses(path, monkeypatch):
    """Let a file or link belong to another user than the one who runs."""
    if os.geteuid() == 0:
        os.lchown(path, 12345, 12345)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: path.lstat().st_uid + 1)


def test_a_file_that_is_replaced_keeps_its_mode_and_owner(coast, reference, tmp_path):
    path = tmp_path / "ranking.json"
    path.write_text("old")
    path.chmod(0o640)
    if os.geteuid() == 0:
        os.chown(path, 12345, 23456)
    before = path.stat()
    assert coast("rank-pairs", reference, "-o", path).code == 0
    after = path.stat()
    assert (after.st_mode, after.st_uid, after.st_gid) == (before.st_mode, before.st_uid, before.st_gid)
    assert json.loads(path.read_text())["schema"] == "coast.rank-pairs/1"


def test_a_new_file_has_the_mode_that_the_user_gives_new_files(coast, reference, tmp_path):
    old = os.umask(0o027)
    try:
        assert coast("rank-pairs", reference, "-o", tmp_path / "ranking.json").code == 0
    finally:
        os.umask(old)
    assert (tmp_path / "ranking.json").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("planted", ["ranking.json", "shared"])
def test_a_link_that_somebody_else_put_there_is_not_written_through(coast, reference, tmp_path, monkeypatch, planted):
    (tmp_path / "private").mkdir()
    victim = tmp_path / "private" / "ranking.json"
    victim.write_text("mine")
    link = tmp_path / planted
    link.symlink_to("private" if planted == "shared" else victim)
    someone_elses(link, monkeypatch)
    ran = coast("rank-pairs", reference, "-o", link / "ranking.json" if planted == "shared" else link)
    assert ran.code == 2
    assert ran.err.endswith(f"as the link {link} belongs to another user.\n")
    assert victim.read_text() == "mine"


def test_a_link_put_in_the_place_of_a_draft_is_not_written_through(tmp_path):
    victim = tmp_path / "victim.txt"
    victim.write_text("mine")

    def plant(stream):
        (draft,) = (path for folder in tmp_path.glob(".coast-*") for path in folder.iterdir())
        assert draft.parent.stat().st_mode & 0o777 == 0o700
        (tmp_path / "answer.txt").symlink_to(victim)
        stream.write("answer")

    write_files({tmp_path / "answer.txt": plant})
    assert victim.read_text() == "mine"
    assert (tmp_path / "answer.txt").read_text() == "answer"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["answer.txt", "victim.txt"]


def test_links_in_a_circle_are_a_sentence(coast, reference, tmp_path):
    (tmp_path / "a.json").symlink_to("b.json")
    (tmp_path / "b.json").symlink_to("a.json")
    ran = coast("rank-pairs", reference, "-o", tmp_path / "a.json")
    assert (ran.code, ran.err) == (
        2,
        f"coast: {tmp_path / 'a.json'}: cannot be written, as its links lead in a circle.\n",
    )
    ran = coast("rank-pairs", tmp_path / "b.json")
    assert ran.code == 3
    assert "cannot be read" in ran.err


def test_a_file_of_another_user_is_not_taken_over(coast, reference, tmp_path, monkeypatch):
    path = tmp_path / "ranking.json"
    path.write_text("theirs")
    monkeypatch.setattr(os, "geteuid", lambda: path.stat().st_uid + 1)
    ran = coast("rank-pairs", reference, "-o", path)
    assert ran.code == 2
    assert "cannot be replaced and keep its owner" in ran.err
    assert path.read_text() == "theirs"


@pytest.mark.parametrize(
    "line",
    [
        "calibrate {config} {recording} -o no/a.toml",
        "check {config} -o no/a.xml",
        "design {config} --target stroke_mm=1 --save no/a.toml",
    ],
)
def test_a_folder_that_is_not_there_is_said_before_the_run(coast, reference, tmp_path, monkeypatch, line):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("coast_cli.spec.load.load_config", lambda *_: pytest.fail("the run began"))
    recording = Path(__file__).parents[2] / "examples" / "diagnose" / "recording.csv"
    ran = coast(*line.format(config=reference, recording=recording).split())
    assert ran.code == 2
    assert "there is no folder no" in ran.err
