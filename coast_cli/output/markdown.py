"""Markdown tables, as GitHub and pandoc read them: numbers to five digits, no column without a value."""

from __future__ import annotations

from typing import IO

from coast_cli.output.answer import Answer, Cell


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the rows as one pipe table; numbers stand right."""
    names = shown_names(answer)
    if not names:
        return
    right = [any(isinstance(row[name], int | float) for row in answer.rows) for name in names]
    stream.write(f"| {' | '.join(_escaped(name) for name in names)} |\n")
    stream.write(f"|{'|'.join('---:' if one else '---' for one in right)}|\n")
    for row in answer.rows:
        stream.write(f"| {' | '.join(_escaped(markdown_cell(row[name])) for name in names)} |\n")


def shown_names(answer: Answer) -> list[str]:
    """Return the columns that have a value in some row."""
    return [name for name in next(iter(answer.rows), {}) if any(row[name] is not None for row in answer.rows)]


def markdown_cell(value: Cell) -> str:
    """Return a value as it is printed in a page: yes or no, five digits, a dash for none."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _escaped(text: str) -> str:
    for mark in "\\|`*_<>[]&#":
        text = text.replace(mark, f"\\{mark}")
    return " ".join(text.split())
