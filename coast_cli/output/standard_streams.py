"""The streams of the process: stdout for data alone, stderr for words.

A reader that leaves early (``coast ... | head``) is no error; words that nobody can get change no answer.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import IO

from coast_cli.errors import UsageError


def to_stdout(write: Callable[[IO[str]], object]) -> None:
    """Let ``write`` write to stdout; once nobody reads, the rest goes nowhere.

    Raises:
        UsageError: stdout cannot be written, as on a full disk.
    """
    try:
        write(sys.stdout)
        sys.stdout.flush()
    except OSError as error:
        _give_up(sys.stdout)
        if not isinstance(error, BrokenPipeError):
            raise UsageError(f"stdout cannot be written ({error.strerror or error}).") from None


def to_stderr(text: str) -> None:
    """Write one line to stderr, or to nobody where that cannot be written."""
    try:
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()
    except OSError:
        _give_up(sys.stderr)


def _give_up(stream: IO[str]) -> None:
    """Lead a stream nowhere: what Python still holds back would fail again when it ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
