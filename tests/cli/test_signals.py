"""SIGINT, SIGTERM and SIGHUP: a sentence from the first import on, and what is done is kept, however often they come."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from coast_cli.design import exploration
from coast_cli.output import kept
from coast_cli.output.checkpoint import write_note
from tests.held import held

ROOT = Path(__file__).parents[2]
SIGNALS = {signal.SIGINT: "interrupted", signal.SIGTERM: "ended by SIGTERM", signal.SIGHUP: "ended by SIGHUP"}
SPACE = """
[explore]
tubes = 16
refinements = 0
[explore.outer]
depth_mm = { min = 0.314, max = 0.400 }
[explore.middle]
depth_mm = { min = 0.243, max = 0.287 }
"""
# The signal comes with the n-th import, counted from where the program's own lines begin.
AT_AN_IMPORT = """
import os, signal, sys
from coast_cli.__main__ import main
left = int(sys.argv.pop(1))
number = int(sys.argv.pop(1))
def count(event, _):
    global left
    if event == "import":
        left -= 1
        if left == 0:
            os.kill(os.getpid(), number)
sys.addaudithook(count)
code = main()
if number == 0:
    print(-left, file=sys.stderr)
sys.exit(code)
"""


def run(*words, ignored=()):
    def begin():
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN if number in ignored else signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)

    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-c", AT_AN_IMPORT, *map(str, words)]
    return subprocess.run(
        command, env={**os.environ, "PYTHONPATH": path}, preexec_fn=begin, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def imports():
    """How many imports a whole run makes here: their number changes with the libraries' versions."""
    return int(run(0, 0, "rank-pairs", ROOT / "configs" / "tubes.toml").stderr.split()[-1])


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
@pytest.mark.parametrize("share", [0.05, 0.15, 0.3, 0.6, 0.95])
def test_a_signal_while_modules_are_loaded_is_one_sentence(reference, number, share, imports):
    ran = run(round(share * imports), number.value, "rank-pairs", reference)
    assert (ran.returncode, ran.stdout, ran.stderr) == (128 + number, "", f"coast: {SIGNALS[number]}.\n")


def test_a_hangup_that_was_ignored_from_the_start_stays_ignored(reference):
    ran = run(240, signal.SIGHUP.value, "rank-pairs", reference, ignored=[signal.SIGHUP])
    assert ran.returncode == 0
    assert "S4" in ran.stdout


@pytest.fixture
def words(tmp_path, reference_text, monkeypatch):
    """An exploration of four blocks, in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "space.toml").write_text(reference_text + SPACE, encoding="utf-8")
    tasks = exploration.tasks
    monkeypatch.setattr(exploration, "tasks", lambda text, name, *_, **more: tasks(text, name, 8, **more))
    for number in SIGNALS:
        default = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
        signal.signal(number, default)  # a test run in the background has them ignored
    return ["explore", "space.toml", "-f", "json"]


def ended_at(block, number, monkeypatch):
    """Let a signal come while the given block is solved."""
    solve, asked = exploration.explore_block, []

    def interrupted(task):
        asked.append(task)
        if len(asked) == block:
            os.kill(os.getpid(), number)
        return solve(task)

    monkeypatch.setattr(exploration, "explore_block", interrupted)


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
@pytest.mark.parametrize("stream", [(), ("--all", "pairs.csv")], ids=["kept", "stream"])
def test_each_signal_keeps_what_is_done(coast, words, tmp_path, monkeypatch, number, stream):
    whole = coast(*words)
    with monkeypatch.context() as patched:
        ended_at(3, number, patched)
        ran = coast(*words, *stream)
    assert (ran.code, ran.out) == (128 + number, "")
    assert "keeps 2 blocks, and the same command goes on from there" in ran.err
    assert ran.err.endswith(f"coast: {SIGNALS[number]}.\n")
    assert coast(*words, *stream) == whole
    assert not list(tmp_path.glob("*.part"))


def test_a_second_signal_does_not_cut_short_what_is_kept(coast, words, monkeypatch):
    whole = coast(*words)

    def impatient(*args):
        os.kill(os.getpid(), signal.SIGINT)
        write_note(*args)

    with monkeypatch.context() as patched:
        ended_at(3, signal.SIGTERM, patched)
        patched.setattr(kept, "write_note", impatient)
        ran = coast(*words)
    assert ran.code == 143
    assert "keeps 2 blocks" in ran.err
    assert coast(*words) == whole


def test_an_interrupt_that_python_cannot_raise_where_it_comes_is_raised_after(coast, words, monkeypatch):
    class Swallows:
        def __del__(self):
            os.kill(os.getpid(), signal.SIGINT)
            sum(range(1000))

    solve = exploration.explore_block

    def work(task):
        Swallows()
        for _ in range(200):
            solve(task)

    monkeypatch.setattr(exploration, "explore_block", work)
    ran = coast(*words)
    assert (ran.code, ran.err) == (130, "coast: interrupted.\n")


def test_an_answer_that_cannot_be_written_loses_no_block(coast, words, tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    solve = exploration.explore_block

    def removed(task):
        if (tmp_path / "out").is_dir():
            (tmp_path / "out").rmdir()
        return solve(task)

    monkeypatch.setattr(exploration, "explore_block", removed)
    ran = coast(*words, "-o", "out/front.json")
    assert ran.code == 2
    assert "keeps 4 blocks" in ran.err
    monkeypatch.setattr(exploration, "explore_block", lambda _: pytest.fail("a block was done again"))
    assert coast(*words).code == 0


def test_an_interrupt_of_several_processes_is_sentences_alone(words, tmp_path):
    config = (tmp_path / "space.toml").read_text(encoding="utf-8").replace("tubes = 16", "tubes = 384")
    (tmp_path / "space.toml").write_text(config, encoding="utf-8")
    with held(tmp_path, *words, "--jobs", "2", "--all", "pairs.csv") as running:
        running.send_signal(signal.SIGTERM)
        said = running.communicate()[1]
    assert running.returncode == 143
    assert [line.partition(":")[0] for line in said.splitlines()] == ["coast", "coast"]
