"""Signs of life of long work on stderr: on a terminal a bar or a turning wheel, in a file or a pipe a line a minute."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

from coast_cli.output.view import VIEW
from coast_cli.output.write import say

_SECONDS = 60.0
_DOING: list[Callable[[], str]] = []  # what is at work, the innermost last


@contextmanager
def a_line_a_minute(command: str) -> Iterator[None]:
    """Say each minute how far the command is, unless stderr is a terminal that already shows it."""
    if VIEW.get().quiet:
        yield
        return
    done, began = Event(), time.monotonic()

    def tell() -> None:
        while not done.wait(_SECONDS):
            if not (_DOING and sys.stderr.isatty()):
                say(_DOING[-1]() if _DOING else f"{command}: at work for {_minutes(time.monotonic() - began)}")

    teller = Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        done.set()
        teller.join()


@contextmanager
def progress(text: str, total: int, done: int = 0) -> Iterator[Callable[[], None]]:
    """Yield what to call after each of ``total`` steps, ``done`` of which were done before."""
    began, count = time.monotonic(), done

    def advance() -> None:
        nonlocal count
        count += 1

    def said() -> str:
        passed, steps = time.monotonic() - began, count - done
        left = f", about {_minutes(passed / steps * (total - count))} left" if steps else ""
        return f"{text}: {count} of {total} done{left}"

    with _doing(said):
        if VIEW.get().quiet or not sys.stderr.isatty():
            yield advance
            return
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(text, total=total, completed=done)
            yield lambda: bar.advance(task)


@contextmanager
def waiting(text: str) -> Iterator[None]:
    """Show ``text`` until the block ends: with a turning wheel on a terminal."""
    began = time.monotonic()
    with _doing(lambda: f"{text}: at work for {_minutes(time.monotonic() - began)}"):
        if VIEW.get().quiet or not sys.stderr.isatty():
            yield
            return
        from rich.console import Console
        from rich.markup import escape

        with Console(stderr=True).status(escape(text)):
            yield


@contextmanager
def _doing(said: Callable[[], str]) -> Iterator[None]:
    _DOING.append(said)
    try:
        yield
    finally:
        _DOING.remove(said)


def _minutes(seconds: float) -> str:
    return f"{max(seconds / 60.0, 0.0):.0f} min"
