"""A sign of life is for terminals alone."""

from io import StringIO

import pytest

from coast_cli.output.waiting import waiting


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
