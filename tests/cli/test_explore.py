"""``coast explore``: files that stream and resume, disks that fill, and the same bytes from any engine."""

import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec

import pytest

from coast_cli.design import exploration
from coast_cli.errors import UsageError
from tests.from_a_shell import popen
from tests.held import held

SPACE = """
[explore]
tubes = 256
refinements = 0
[explore.outer]
depth_mm = { min = 0.314, max = 0.400 }
[explore.middle]
depth_mm = { min = 0.243, max = 0.287 }
"""
SMALL = SPACE.replace("256", "16")


@pytest.fixture
def config(tmp_path, reference_text):
    def write(table=SMALL):
        path = tmp_path / "space.toml"
        path.write_text(reference_text + table, encoding="utf-8")
        return path

    return write


def blocks(note):
    """How many blocks an unfinished stream holds."""
    return json.loads(note.read_bytes().partition(b"\n")[0])["blocks"]


def start(*words, **options):
    command = [sys.executable, "-m", "coast_cli", "explore", *map(str, words)]
    return popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)


def test_every_pair_is_streamed_and_the_front_printed(coast, config, tmp_path):
    ran = coast("explore", config(), "--all", tmp_path / "pairs.csv", "-f", "json")
    answer = json.loads(ran.out)
    assert ran.code == 0
    assert answer["schema"] == "coast.explore/1"
    lines = (tmp_path / "pairs.csv").read_text().splitlines()
    assert len(lines) == 1 + 16 * 16
    assert lines[0].startswith("outer,middle,outer_depth_mm,middle_depth_mm,total_precurvature_rad")
    assert sum(line.endswith("true") for line in lines[1:]) >= len(answer["rows"]) > 0
    assert "256 pairs solved" in ran.err
    assert not list(tmp_path.glob("*.part*"))


def test_a_file_that_exists_is_not_replaced(coast, config, tmp_path):
    path = tmp_path / "pairs.csv"
    path.write_text("mine")
    ran = coast("explore", config(), "--all", path)
    assert (ran.code, ran.out, path.read_text()) == (2, "", "mine")
    assert "the file exists" in ran.err
    assert coast("explore", config(), "--all", path, "--overwrite").code == 0
    assert path.read_text() != "mine"


def test_only_csv_is_streamed(coast, config, tmp_path):
    ran = coast("explore", config(), "--all", tmp_path / "pairs.parquet")
    assert ran.code == 2
    assert ".csv" in ran.err


def test_what_another_command_left_unfinished_is_not_replaced(coast, config, tmp_path, monkeypatch):
    words, solve, asked = ("--all", tmp_path / "pairs.csv"), exploration.explore_block, []

    def interrupted(task):
        asked.append(task)
        if len(asked) == 2:
            raise KeyboardInterrupt
        return solve(task)

    monkeypatch.setattr(exploration, "explore_block", interrupted)
    first = config(SPACE.replace("256", "140"))
    assert coast("explore", first, *words).code == 130
    left = {path: path.read_bytes() for path in tmp_path.glob("pairs.csv.part/*")}
    assert len(left) == 2
    ran = coast("explore", config(SMALL), *words)
    assert (ran.code, ran.out) == (2, "")
    assert "pairs.csv.part holds what another command left unfinished" in ran.err
    assert {path: path.read_bytes() for path in tmp_path.glob("pairs.csv.part/*")} == left
    assert coast("explore", config(SMALL), *words, "--overwrite").code == 0
    assert len((tmp_path / "pairs.csv").read_text().splitlines()) == 1 + 16 * 16
    assert not list(tmp_path.glob("*.part*"))


def test_an_interrupt_before_the_first_block_leaves_nothing(coast, config, tmp_path, monkeypatch):
    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(exploration, "explore_block", interrupted)
    assert coast("explore", config(), "--all", tmp_path / "pairs.csv").code == 130
    assert not list(tmp_path.glob("*pairs*"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("-o", "front.xlsx"), "the suffix does not say a format"),
        (("-o", "absent/front.json"), "there is no folder"),
        (("--plot", "front.bmp"), "the suffix does not say a format"),
        (("--plot", "absent/front.png"), "there is no folder"),
    ],
)
def test_a_file_that_cannot_be_written_is_refused_before_the_run(coast, config, monkeypatch, words, said):
    def run(_):
        raise AssertionError("the run began")

    monkeypatch.setattr(exploration, "explore_block", run)
    ran = coast("explore", config(), *words)
    assert (ran.code, ran.out) == (2, "")
    assert said in ran.err
    assert ran.err.count("\n") == 1


def test_jobs_give_the_same_bytes(coast, config, tmp_path):
    alone = coast("explore", config(), "--all", tmp_path / "one.csv", "-f", "json")
    together = coast("explore", config(), "--all", tmp_path / "two.csv", "--jobs", "2", "-f", "json")
    assert alone == together
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "two.csv").read_bytes()


def test_an_interrupt_keeps_what_is_done_and_a_rerun_resumes(config, tmp_path):
    """Four blocks of 16,384 pairs; the interrupt comes once the first is written."""
    path, note = tmp_path / "pairs.csv", tmp_path / "pairs.csv.part" / "note"
    arguments = (config(SPACE), "--top", "3", "-f", "json", "--all")
    with held(tmp_path, "explore", *arguments, path) as running:
        running.send_signal(signal.SIGINT)
        _, said = running.communicate()
    assert running.returncode == 130
    assert "the same command goes on from there" in said
    assert "Traceback" not in said
    assert blocks(note) == 1
    assert not path.exists()
    resumed = start(*arguments, path).communicate()
    whole = start(*arguments, tmp_path / "whole.csv").communicate()
    assert resumed == whole
    assert path.read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_an_interrupt_without_a_stream_keeps_what_is_done_too(coast, config, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("explore", config(SPACE), "--top", "3", "-f", "json")
    whole, solve, asked = coast(*words), exploration.explore_block, []

    def interrupted(task):
        asked.append((task.outer, task.middle))
        if len(asked) == 3:
            raise KeyboardInterrupt
        return solve(task)

    monkeypatch.setattr(exploration, "explore_block", interrupted)
    stopped = coast(*words)
    (kept,) = tmp_path.glob("space.explore.*.part")
    assert (stopped.code, stopped.out) == (130, "")
    assert f"{kept.name} keeps 2 blocks, and the same command goes on from there" in stopped.err
    assert coast(*words) == whole
    assert asked == [(0, 0), (0, 1), (1, 0), (1, 0), (1, 1)]
    assert not kept.exists()


def test_a_folder_that_takes_no_file_is_said(coast, config, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(exploration, "refine", interrupted)
    monkeypatch.setattr("coast_cli.output.kept.write_note", refused)
    stopped = coast("explore", config(SMALL.replace("refinements = 0", "refinements = 1")))
    assert stopped.code == 130
    assert "interrupted: what is done cannot be kept (x: cannot be written)" in stopped.err


def refused(*_, **__):
    raise UsageError("x: cannot be written.")


@pytest.mark.skipif(os.name != "posix", reason="file size limits are POSIX")
def test_a_full_disk_is_said_and_what_is_written_stays(config, tmp_path):
    """A limit on the size of files stands for the disk; it stops the run past its middle."""
    import resource

    path = tmp_path / "pairs.csv"
    arguments = (config(SPACE), "--top", "3", "-f", "json", "--all")
    whole = start(*arguments, tmp_path / "whole.csv").communicate()
    limit = int(0.6 * (tmp_path / "whole.csv").stat().st_size)
    full = start(*arguments, path, prepare=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    out, said = full.communicate()
    assert (full.returncode, out) == (2, "")
    assert "run the same command again" in said
    assert "Traceback" not in said
    assert not path.exists()
    assert blocks(tmp_path / "pairs.csv.part" / "note") == 2
    assert start(*arguments, path).communicate() == whole
    assert path.read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_no_cluster_is_said(coast, config):
    if find_spec("distributed") is None:
        ran = coast("explore", config(), "--cluster", "tcp://127.0.0.1:9")
        assert "pip install 'coast-cli[cluster]'" in ran.err
    else:
        ran = coast("explore", config(), "--cluster", "nonsense://127.0.0.1")
        assert "no dask scheduler" in ran.err
    assert (ran.code, ran.out) == (2, "")


@pytest.fixture
def cluster(tmp_path):
    """A scheduler and two workers as processes of their own; yields (address, [scheduler, *workers])."""
    if find_spec("distributed") is None:
        pytest.skip("not here: dask.distributed, the extra [cluster]")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    note = tmp_path / "scheduler.json"

    def run(*words):
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]]
        return subprocess.Popen(command, env=environment, cwd=tmp_path, **quiet)

    file = ("--scheduler-file", str(note))
    running = [run("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *file)]
    alone = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(tmp_path / "dask"))
    running += [run("dask_worker", *file, *alone) for _ in range(2)]
    while not note.exists() or not note.stat().st_size:  # the file is there before its text is
        assert running[0].poll() is None
        time.sleep(0.05)
    try:
        yield json.loads(note.read_text())["address"], running
    finally:
        for process in running[::-1]:
            process.kill()
            process.wait()


@pytest.mark.parametrize("killed", [False, True], ids=["whole", "a worker killed"])
def test_a_cluster_gives_the_same_bytes(config, tmp_path, cluster, killed):
    address, crew = cluster
    arguments = (config(SPACE), "--top", "3", "-f", "json", "--all")
    alone = start(*arguments, tmp_path / "alone.csv").communicate()
    with held(tmp_path, "explore", *arguments, tmp_path / "cluster.csv", "--cluster", address) as running:
        if killed:
            crew[1].kill()
    out, said = running.communicate()
    assert running.returncode == 0, said
    assert out == alone[0]
    assert (tmp_path / "alone.csv").read_bytes() == (tmp_path / "cluster.csv").read_bytes()


def test_a_scheduler_that_goes_away_is_a_sentence_and_loses_nothing(config, tmp_path, cluster):
    address, (scheduler, *_) = cluster
    arguments = (config(SPACE.replace("256", "512")), "--top", "3", "-f", "json", "--all")
    whole = start(*arguments, tmp_path / "whole.csv").communicate()
    with held(tmp_path, "explore", *arguments, tmp_path / "pairs.csv", "--cluster", address) as running:
        scheduler.kill()
    out, said = running.communicate()
    assert (running.returncode, out) == (4, "")
    assert f"the dask scheduler at {address} is gone" in said
    assert all(line.startswith("coast: ") for line in said.splitlines())
    assert start(*arguments, tmp_path / "pairs.csv").communicate() == whole
    assert (tmp_path / "pairs.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
