"""A sign of life on stderr while something takes long; a file or a pipe gets none."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from coast_cli.output.view import VIEW


@contextmanager
def waiting(text: str) -> Iterator[None]:
    """Show ``text`` with a turning wheel until the block ends, where stderr is a terminal."""
    if VIEW.get().quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status(escape(text)):
        yield
