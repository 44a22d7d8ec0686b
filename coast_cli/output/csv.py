"""CSV: a header with the column names, then the same rows as JSON; no value is an empty cell.

A text that a spreadsheet would take for a formula has an apostrophe before it, which our reader takes away again, and a
control character stands as its escape. Numbers are as they are.
"""

from __future__ import annotations

import csv
import re
from typing import IO

from coast_cli.errors import printable
from coast_cli.output.answer import Answer, Cell
from coast_cli.output.columns import COLUMNS

_FORMULA = re.compile("'*[=+\\-@\uff1d\uff0b\uff0d\uff20]")  # also full-width, as East Asian spreadsheets take them
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the rows as CSV with plain line feeds; numbers keep every digit. Without rows there is the header alone."""
    writer = csv.writer(stream, lineterminator="\n")
    names = list(answer.rows[0] if answer.rows else COLUMNS.get(answer.command, ()))
    if names:
        writer.writerow(names)
    writer.writerows([cell(row[name]) for name in names] for row in answer.rows)


def cell(value: Cell) -> Cell:
    """Return what stands in a cell of CSV for a value."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return guarded(value) if isinstance(value, str) else "" if value is None else value


def guarded(text: str) -> str:
    """Return a text as no spreadsheet runs it and no terminal obeys it."""
    plain = printable(text)
    return f"'{plain}" if _FORMULA.match(plain) and not _NUMBER.fullmatch(plain) else plain
