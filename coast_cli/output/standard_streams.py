"""The streams of the process: stdout for data alone, stderr for words.

A reader that leaves early (``coast ... | head``) is no error; words that nobody can get change no answer.
"""

from __future__ import annotations

import codecs
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import IO

from coast_cli.errors import UsageError

_ESCAPED = "coast.escaped"


def prepare() -> None:
    """Lead closed streams nowhere, and let every character leave: one that the encoding lacks as an escape of JSON."""
    codecs.register_error(_ESCAPED, _escape)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed by the caller
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115  # open to the end
        elif getattr(stream, "errors", "") in {"strict", "surrogateescape"} and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=_ESCAPED)


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


def _escape(error: UnicodeError) -> tuple[str, int]:
    r"""Return ``\u2026`` for what cannot be encoded, which is the same character in JSON, in pairs past U+FFFF."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    units = error.object[error.start : error.end].encode("utf-16-be", "surrogatepass").hex()
    return "".join(f"\\u{units[place : place + 4]}" for place in range(0, len(units), 4)), error.end


def _give_up(stream: IO[str]) -> None:
    """Lead a stream nowhere: what Python still holds back would fail again when it ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
