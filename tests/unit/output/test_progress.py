"""Signs of life: a wheel or a bar on a terminal, a line a minute in a pipe."""

import time
from io import StringIO
from threading import Event

import pytest

from coast_cli.output import progress as module
from coast_cli.output.progress import a_line_a_minute, progress, waiting


class Terminal(StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(("stream", "shown"), [(Terminal(), True), (StringIO(), False)])
def test_waiting_shows_on_a_terminal_only(monkeypatch, stream, shown):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr("sys.stderr", stream)
    with waiting("diagnosing run[1]"):
        pass
    assert ("diagnosing run[1]" in stream.getvalue()) is shown


@pytest.fixture
def minute(monkeypatch, capsys):
    """A minute of a hundredth of a second, and what stderr gets until a text is in it."""
    monkeypatch.setattr(module, "_SECONDS", 0.01)

    def until(text):
        said = ""
        for _ in range(2000):
            said += capsys.readouterr().err
            if text in said:
                return said.splitlines()
            time.sleep(0.005)
        raise AssertionError(said)

    return until


def test_a_pipe_gets_a_line_a_minute_from_any_command(minute):
    with a_line_a_minute("compare"):
        lines = minute("\n")
    assert lines[0] == "coast: compare: at work for 0 min"


def test_a_pipe_gets_the_steps_of_a_long_run(minute):
    with a_line_a_minute("explore"), progress("blocks", 12, 4) as advance:
        assert minute("\n")[0] == "coast: blocks: 4 of 12 done"
        advance()
        minute("blocks: 5 of 12 done, about 0 min left")


def test_a_pipe_gets_what_is_waited_for(minute):
    with a_line_a_minute("diagnose"), waiting("diagnosing wrist"):
        assert minute("\n")[0] == "coast: diagnosing wrist: at work for 0 min"


def test_nothing_is_said_after_the_work(minute, capsys):
    with a_line_a_minute("compare"):
        minute("\n")
    capsys.readouterr()
    time.sleep(0.05)
    assert capsys.readouterr().err == ""


def test_every_command_gives_signs_of_life(coast, reference, monkeypatch):
    from coast_cli.design import rank

    monkeypatch.setattr(module, "_SECONDS", 0.01)
    whole, say, said = rank.rank, module.say, Event()

    def slow(*words):
        assert said.wait(60.0)
        return whole(*words)

    monkeypatch.setattr(rank, "rank", slow)
    monkeypatch.setattr(module, "say", lambda text: (say(text), said.set()))
    assert "coast: rank-pairs: at work for 0 min\n" in coast("rank-pairs", reference).err
