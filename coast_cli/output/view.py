"""What of an answer the user wants to see: which rows in which order, which columns, and how wide a table may be."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextvars import ContextVar
from dataclasses import dataclass, replace

from coast_cli.errors import UsageError, nearest
from coast_cli.output.answer import Answer, Cell, Row

NARROWEST = 20  # columns; a terminal that says fewer is written for as if it had these


@dataclass(frozen=True)
class View:
    """What is asked for.

    Attributes:
        wide: tables have every column, however wide they become.
        show: names of the columns to show, in this order; empty is all of them.
        sort: the column to sort by, with a minus before it from large to small; rows without a value come last.
        top: how many rows.
        quiet: no notes and no progress on stderr.
    """

    wide: bool = False
    show: tuple[str, ...] = ()
    sort: str | None = None
    top: int | None = None
    quiet: bool = False

    def of(self, answer: Answer) -> Answer:
        """Return an answer with the rows and columns asked for.

        Raises:
            UsageError: a column that the answer does not have.
        """
        rows: Sequence[Row] = answer.rows
        if self.sort is not None:
            rows = _sorted(answer, self.sort)
        if self.top is not None:
            rows = rows[: self.top]
        if self.show and rows:
            for name in self.show:
                _check(answer, name)
            rows = [{name: row[name] for name in self.show} for row in rows]
        return answer if rows is answer.rows else replace(answer, rows=rows)


EVERYTHING = View()
VIEW: ContextVar[View] = ContextVar("VIEW", default=EVERYTHING)


def stdout_width() -> int | None:
    """Return how wide a line on stdout may be, or None for a file or a pipe; COLUMNS says otherwise."""
    asked = os.environ.get("COLUMNS", "")
    if asked.isascii() and asked.isdigit() and int(asked) > 0:
        return max(int(asked), NARROWEST)
    try:
        width = os.get_terminal_size(sys.stdout.fileno()).columns
    except (OSError, ValueError):  # no terminal, or closed
        return None
    return max(width, NARROWEST) if width > 0 else None


def _sorted(answer: Answer, key: str) -> list[Row]:
    name = key.removeprefix("-")
    if not answer.rows:
        return []
    _check(answer, name)
    with_value = [row for row in answer.rows if row[name] is not None]
    without = [row for row in answer.rows if row[name] is None]
    return [*sorted(with_value, key=lambda row: _order(row[name]), reverse=key.startswith("-")), *without]


def _order(cell: Cell) -> tuple[bool, float, str]:
    """Sort numbers as numbers, before texts."""
    return (True, 0.0, cell) if isinstance(cell, str) else (False, float(cell or 0.0), "")


def _check(answer: Answer, name: str) -> None:
    known = list(answer.rows[0])
    if name not in known:
        hint = nearest(name, known)
        raise UsageError(
            f"coast {answer.command}: there is no column {name}; allowed: {', '.join(known)}. {hint}".rstrip()
        )
