"""Errors that the user may see: each is one sentence, and each carries the exit code of the command that meets it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


class CoastError(Exception):
    """An error that is shown as its message alone, without a traceback."""

    exit_code = 4

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class UsageError(CoastError):
    """The command line asks for something that does not exist or cannot go together."""

    exit_code = 2


class NotConverged(CoastError):
    """A solver did not reach its tolerance; the message says what to change."""

    exit_code = 4


class BadInput(CoastError):
    """An input is wrong: where it stands, what was found and what is allowed, in one sentence.

    Args:
        message: what is wrong, without a final full stop.
        file, line, column: where; line and column count from 1.
        key: the dotted name of the field or column.
        found: the offending value as the user wrote it.
        allowed: what would have been accepted.
        hint: what to do, a sentence of its own.
    """

    exit_code = 3

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        column: int | None = None,
        key: str | None = None,
        found: object = None,
        allowed: str | None = None,
        hint: str | None = None,
    ) -> None:
        self.message = message
        self.file = file
        self.line = line
        self.column = column
        self.key = key
        self.found = found
        self.allowed = allowed
        self.hint = hint
        super().__init__(self._sentence())

    def _sentence(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)
        key = None if self.key is None else shortened(self.key, _LONGEST_KEY)
        head = ": ".join(part for part in (place, key, self.message) if part)
        if self.found is not None:
            head += f"; found {shown(self.found)}"
        if self.allowed is not None:
            head += f"; allowed: {self.allowed}"
        head += "."
        return f"{head} {self.hint}" if self.hint else head


_LONGEST_KEY = 160


def printable(text: str) -> str:
    """Return a text as one line that no terminal obeys: what does not print is shown by its escape."""
    if text.isprintable():
        return text
    return "".join(mark if mark.isprintable() else mark.encode("unicode_escape").decode() for mark in text)


def nearest(name: str, known: Iterable[str]) -> str:
    """Return "Did you mean ...?" with the names in ``known`` that look like ``name``, or an empty string."""
    from difflib import get_close_matches

    matches = get_close_matches(name, list(known), n=3, cutoff=0.6)
    return f"Did you mean {' or '.join(matches)}?" if matches else ""


def shown(value: object, limit: int = 60) -> str:
    """Return a value as a sentence shows it, a text in quotes, cut after so many characters."""
    return shortened(repr(value) if isinstance(value, str) else str(value), limit)


def shortened(text: str, limit: int) -> str:
    """Return a text, cut after so many characters."""
    return text if len(text) <= limit else text[: limit - 3] + "..."
