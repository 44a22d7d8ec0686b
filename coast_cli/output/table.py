"""Tables for people: five digits, units in the headings, a row a line, no column without a value."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import IO

from coast_cli.output.answer import Answer, Cell

_GAP = "  "
_MOST_ROWS = 10_000  # more than anyone reads
_HEADING = 13  # characters of a line of a heading, where its words allow
_WORDS = re.compile(r"(?:per_m|n_m2)$|[^_]+_?|_")


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the answer as an aligned table, with a last line that names its inputs."""
    rows = answer.rows[:_MOST_ROWS]
    names = [name for name in next(iter(rows), {}) if any(row[name] is not None for row in rows)]
    columns = [_column(name, [row[name] for row in rows]) for name in names]
    tallest = max((len(heading) for heading, _ in columns), default=0)
    padded = [[" " * len(heading[0])] * (tallest - len(heading)) + heading for heading, _ in columns]
    for line in zip(*padded, strict=True):
        stream.write(_GAP.join(line).rstrip() + "\n")
    if columns:
        stream.write("─" * len(_GAP.join(heading[0] for heading, _ in columns)) + "\n")
    for cells in zip(*(cells for _, cells in columns), strict=True):
        stream.write(_GAP.join(cells).rstrip() + "\n")
    if len(answer.rows) > len(rows):
        stream.write(f"{len(answer.rows) - len(rows)} more rows: --format csv or json writes them all\n")
    for config in answer.provenance.get("configs", ()):
        stream.write(f"\n{config['file']}  sha256 {config['sha256'][:16]}\n")


def _column(name: str, values: Sequence[Cell]) -> tuple[list[str], list[str]]:
    """Return the lines of a column's heading and its cells, all of one width; numbers and yes or no stand right."""
    heading, cells = _heading(name), [_cell(value) for value in values]
    width = max(map(len, (*heading, *cells)))
    to_right = any(isinstance(value, int | float) for value in values)
    align = str.rjust if to_right else str.ljust
    return [align(line, width) for line in heading], [align(cell, width) for cell in cells]


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
    text = f"{value:.5g}" if isinstance(value, float) else str(value)
    return text if text.isprintable() else text.encode("unicode_escape").decode("ascii")
