"""Standard output, for data alone; a reader that leaves early (``coast ... | head``) is no error."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import IO


def to_stdout(write: Callable[[IO[str]], object]) -> None:
    """Let ``write`` write to stdout; once nobody reads, the rest goes nowhere."""
    try:
        write(sys.stdout)
        sys.stdout.flush()
    except BrokenPipeError:
        # What Python still holds back would fail again when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
