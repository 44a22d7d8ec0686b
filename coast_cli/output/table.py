"""Tables for people: five digits, units in the headings, a row a line, no column without a value."""

from __future__ import annotations

import re
from typing import IO

from coast_cli.output.answer import Answer, Cell

_WIDEST = 10_000  # the terminal may wrap a line; the table never drops a column
_MOST_ROWS = 10_000  # more than anyone reads
_HEADING = 13  # characters of a line of a heading, where its words allow
_WORDS = re.compile(r"(?:per_m|n_m2)$|[^_]+_?|_")


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the answer as an aligned table, with a last line that names its inputs."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, padding=(0, 1, 0, 0))
    rows = answer.rows[:_MOST_ROWS]
    names = [name for name in next(iter(rows), {}) if any(row[name] is not None for row in rows)]
    for name in names:
        numeric = any(isinstance(row[name], int | float) for row in rows[:100])
        table.add_column("\n".join(_heading(name)), justify="right" if numeric else "left", vertical="bottom")
    for row in rows:
        table.add_row(*(Text(_cell(row[name]), style=_style(row[name])) for name in names))
    console = Console(file=stream, width=_WIDEST, highlight=False, soft_wrap=True)
    with console.capture() as capture:
        console.print(table)
    stream.writelines(f"{line.rstrip()}\n" for line in capture.get().splitlines())
    if len(answer.rows) > len(rows):
        stream.write(f"{len(answer.rows) - len(rows)} more rows: --format csv or json writes them all\n")
    for config in answer.provenance.get("configs", ()):
        stream.write(f"\n{config['file']}  sha256 {config['sha256'][:16]}\n")


def _heading(name: str) -> list[str]:
    """Break a long column name at its underscores, the unit kept in one piece."""
    lines = [""]
    for word in _WORDS.findall(name):
        if lines[-1] and len(lines[-1] + word.rstrip("_")) > _HEADING:
            lines.append("")
        lines[-1] += word
    return lines


def _cell(value: Cell) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _style(value: Cell) -> str:
    return "bold red" if value is False else ""
