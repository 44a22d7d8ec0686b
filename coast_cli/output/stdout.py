"""Standard output, for data alone; a reader that leaves early (``coast ... | head``) is no error."""

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
        # What Python still holds back would fail again when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise UsageError(f"stdout cannot be written ({error.strerror or error}).") from None
