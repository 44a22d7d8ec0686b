"""What an unfinished run left: damaged, forged, enlarged or planted, it is refused with what to delete, and never believed."""

import json
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from coast_cli.design import exploration

ROOT = Path(__file__).parents[2]
SPACE = """
[explore]
tubes = 16
refinements = 0
[explore.outer]
depth_mm = { min = 0.314, max = 0.400 }
[explore.middle]
depth_mm = { min = 0.243, max = 0.287 }
"""


@pytest.fixture(params=["stream", "kept"])
def unfinished(request, coast, tmp_path, reference_text, monkeypatch):
    """The words of a run that was interrupted after two of four blocks, and the folder that it left."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "space.toml").write_text(reference_text + SPACE, encoding="utf-8")
    words = ["explore", "space.toml", "-f", "json", *(["--all", "pairs.csv"] if request.param == "stream" else [])]
    solve, asked, tasks = exploration.explore_block, [], exploration.tasks
    monkeypatch.setattr(exploration, "tasks", lambda text, name, *_, **more: tasks(text, name, 8, **more))

    def interrupted(task):
        asked.append(task)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return solve(task)

    with monkeypatch.context() as patched:
        patched.setattr(exploration, "explore_block", interrupted)
        assert coast(*words).code == 130
    (folder,) = tmp_path.glob("*.part")
    return words, folder


def test_the_folder_is_the_users_alone_and_goes_at_the_end(coast, unfinished):
    words, folder = unfinished
    assert folder.stat().st_mode & 0o777 == 0o700
    assert coast(*words).code == 0
    assert not folder.exists()


def edited_head(**changes):
    def edit(data):
        line, _, rest = data.partition(b"\n")
        return json.dumps(json.loads(line) | changes).encode() + b"\n" + rest

    return edit


def forged(data):
    """Other figures under the old digest."""
    place = data.index(b"\n") + 100
    return data[:place] + bytes(byte ^ 1 for byte in data[place : place + 8]) + data[place + 8 :]


DAMAGE = {
    "empty": lambda _: b"",
    "one-byte": lambda data: data[:1],
    "half": lambda data: data[: len(data) // 2],
    "without-end": lambda data: data[:-1],
    "longer": lambda data: data + b"\0",
    "zeros": lambda data: bytes(len(data)),
    "noise": lambda data: bytes((7 * place) % 251 for place in range(len(data))),
    "zip": lambda data: b"PK\x03\x04" + data,
    "text": lambda _: b"hello\n",
    "no-object": lambda data: b"[]\n" + data,
    "null": lambda data: b"null\n" + data,
    "deep": lambda data: b"[" * 100_000 + b"\n" + data,
    "not-utf-8": lambda data: b"\xff\xfe\n" + data,
    "no-keys": lambda data: b"{}\n" + data,
    "figures": forged,
    "more-blocks": edited_head(blocks=3),
    "blocks-of-text": edited_head(blocks="many"),
    "negative": edited_head(blocks=-1),
    "no-arrays": edited_head(arrays=[]),
    "huge-arrays": edited_head(arrays=[["costs", "<f8", [10**12, 10**6]]]),
    "objects": edited_head(arrays=[["costs", "|O", [2]]]),
    "strange-kind": edited_head(arrays=[["costs", "spam", [2]]]),
    "version": edited_head(coast_note=99),
    "version-text": edited_head(coast_note="1"),
    "digest": lambda data: data[:-32] + bytes(32),
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_a_note_that_is_not_as_it_was_written_is_refused_with_what_to_delete(coast, unfinished, damage):
    words, folder = unfinished
    note = folder / "note"
    note.write_bytes(damage(note.read_bytes()))
    ran = coast(*words)
    assert (ran.code, ran.out) == (3, "")
    assert folder.name in ran.err
    assert "Delete the folder to begin anew" in ran.err
    assert ran.err.count("\n") == 1


@pytest.mark.parametrize("unfinished", ["stream"], indirect=True)
@pytest.mark.parametrize("change", ["edited", "shorter", "no-note"])
def test_rows_that_are_not_those_that_were_written_are_refused(coast, unfinished, change):
    words, folder = unfinished
    rows, data = folder / "rows.csv", (folder / "rows.csv").read_bytes()
    if change == "no-note":
        (folder / "note").unlink()
    else:
        rows.write_bytes(data.replace(b"0.3", b"0.4", 1) if change == "edited" else data[:-100])
    ran = coast(*words)
    assert (ran.code, ran.out) == (3, "")
    assert "pairs.csv.part: the rows are not those that were written. Delete the folder" in ran.err
    assert coast(*words, "--overwrite").code == 0


@pytest.mark.parametrize("unfinished", ["stream"], indirect=True)
def test_rows_beyond_the_note_are_done_again(coast, unfinished, tmp_path):
    words, folder = unfinished
    with (folder / "rows.csv").open("ab") as rows:
        rows.write(b"half a row of the next bl")
    assert coast(*words).code == 0
    assert coast(*words[:-1], "whole.csv").code == 0
    assert (tmp_path / "pairs.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_a_folder_to_which_others_may_write_is_not_believed(coast, unfinished):
    words, folder = unfinished
    folder.chmod(0o777)
    ran = coast(*words)
    assert ran.code == 3
    assert f"{folder.name}: an unfinished run is not believed where other users could have written" in ran.err
    assert folder.stat().st_mode & 0o777 == 0o777


def test_a_folder_of_another_user_is_not_believed(coast, unfinished, monkeypatch):
    words, folder = unfinished
    owner = folder.stat().st_uid
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    ran = coast(*words)
    assert ran.code == 3
    assert "not believed where other users could have written" in ran.err


@pytest.mark.parametrize("planted", ["folder", "note"])
def test_a_link_in_its_place_is_neither_followed_nor_written_through(coast, unfinished, tmp_path, planted):
    words, folder = unfinished
    (tmp_path / "elsewhere").mkdir()
    for path in list(folder.iterdir()):
        path.rename(tmp_path / "elsewhere" / path.name)
    before = {path.name: path.read_bytes() for path in (tmp_path / "elsewhere").iterdir()}
    if planted == "folder":
        folder.rmdir()
        folder.symlink_to("elsewhere")
    else:
        (folder / "note").symlink_to("../elsewhere/note")
    ran = coast(*words)
    assert ran.code == 3
    assert folder.name in ran.err
    assert "elete" in ran.err
    assert {path.name: path.read_bytes() for path in (tmp_path / "elsewhere").iterdir()} == before


@pytest.mark.parametrize("unfinished", ["stream"], indirect=True)
def test_a_link_in_the_place_of_the_rows_is_not_written_through(coast, unfinished, tmp_path):
    words, folder = unfinished
    victim = tmp_path / "victim.csv"
    victim.write_text("mine")
    (folder / "rows.csv").unlink()
    (folder / "rows.csv").symlink_to(victim)
    ran = coast(*words)
    assert ran.code == 2
    assert "pairs.csv: cannot be written" in ran.err
    assert victim.read_text() == "mine"


def test_a_file_where_the_folder_should_be_is_said(coast, tmp_path, reference_text, monkeypatch):
    monkeypatch.chdir(tmp_path)
    config = tmp_path / "pairs.csv.part"
    config.write_text(reference_text + SPACE)
    ran = coast("explore", config, "--all", "pairs.csv")
    assert ran.code == 3
    assert "pairs.csv.part: is no folder that an unfinished run left" in ran.err
    assert config.read_text() == reference_text + SPACE


@pytest.mark.parametrize("unfinished", ["kept"], indirect=True)
def test_a_note_costs_no_more_memory_than_its_file(unfinished):
    """One of 4 MB that says it holds 4 GB, under a limit of 1 GB on top of what the command needs."""
    words, folder = unfinished
    note = folder / "note"
    enlarged = edited_head(arrays=[["costs", "<f8", [2**29]]])(note.read_bytes())
    note.write_bytes(enlarged + bytes(4 * 2**20))
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "coast_cli", *words]
    ran = subprocess.run(
        command,
        env={**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2 * 2**30, 2 * 2**30)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 3
    assert ran.stderr.endswith("what an unfinished run left is damaged. Delete the folder to begin anew.\n")
