"""The page on real recordings runs, where they lie beside this checkout, and says so where they do not."""

import sys

from examples.real import diagnose


def test_it_says_not_here_without_the_recordings(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(diagnose, "RECORDINGS", tmp_path / "absent")
    monkeypatch.setattr(sys, "argv", ["diagnose.py", "--out", str(tmp_path / "out")])
    assert diagnose.main() == 0
    assert "not here" in capsys.readouterr().out


def test_it_calls_the_command_with_what_a_user_would(monkeypatch, tmp_path):
    called = []
    monkeypatch.setattr(diagnose.subprocess, "run", lambda command, **_: called.append(command) or _Done())
    assert diagnose.diagnose("wrist_C", tmp_path) == 0
    assert called[0][1:4] == ["-m", "coast_cli", "diagnose"]
    assert called[0].count("--hold-out") == 2


class _Done:
    returncode = 0
