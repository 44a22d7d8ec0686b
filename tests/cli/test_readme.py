"""The README shows real output: each ``console`` block is run and compared; run as a script, it writes them anew.

It also gives the CI its test command, word for word.
"""

import os
import re
import shlex
import sys
from io import StringIO
from pathlib import Path

import pytest

from coast_cli.__main__ import main

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
BLOCK = re.compile(r"(?<=^```console\n)\$ coast (?P<words>.*)\n(?P<shown>(?:.*\n)*?)(?=^```$)", re.MULTILINE)


def blocks():
    return [(match["words"], match["shown"]) for match in BLOCK.finditer(README.read_text(encoding="utf-8"))]


@pytest.mark.parametrize(("words", "shown"), blocks(), ids=[words for words, _ in blocks()])
def test_the_output_shown_is_what_the_command_prints(coast, monkeypatch, words, shown):
    monkeypatch.chdir(ROOT)
    assert coast(*shlex.split(words)).out == shown


def test_there_are_outputs_to_compare():
    assert len(blocks()) >= 4


def test_the_ci_calls_the_test_command_of_the_readme():
    commands = re.findall(r"^```sh\n(.*)\n```$", README.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(commands) == 2
    assert "coast rank-pairs configs/tubes.toml" in commands[0]
    assert commands[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()


def printed(match):
    stdout, sys.stdout = sys.stdout, StringIO()
    try:
        main(shlex.split(match["words"]))
        return f"$ coast {match['words']}\n{sys.stdout.getvalue()}"
    finally:
        sys.stdout = stdout


if __name__ == "__main__":
    os.chdir(ROOT)
    README.write_text(BLOCK.sub(printed, README.read_text(encoding="utf-8")), encoding="utf-8")
