"""CSV: a header with the column names, then the same rows as JSON; no value is an empty cell."""

from __future__ import annotations

import csv
from typing import IO

from coast_cli.output.answer import Answer, Cell


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the rows as CSV with plain line feeds; numbers keep every digit."""
    if not answer.rows:
        return
    writer = csv.writer(stream, lineterminator="\n")
    names = list(answer.rows[0])
    writer.writerow(names)
    writer.writerows([_cell(row[name]) for name in names] for row in answer.rows)


def _cell(value: Cell) -> Cell:
    if isinstance(value, bool):
        return "true" if value else "false"
    return "" if value is None else value
