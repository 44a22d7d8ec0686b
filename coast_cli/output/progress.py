"""How far a long run is and how much time is left, on stderr where that is a terminal; a file or a pipe gets none."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from coast_cli.output.view import VIEW


@contextmanager
def progress(text: str, total: int, done: int = 0) -> Iterator[Callable[[], None]]:
    """Yield what to call after each of ``total`` steps, ``done`` of which were done before."""
    if VIEW.get().quiet or not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(text, total=total, completed=done)
        yield lambda: bar.advance(task)
