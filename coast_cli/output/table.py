"""Tables for people: five digits, units in the headings, a row a line, no column without a value.

Where a width is given no line is wider: long texts are folded, columns that find no room are left out and named, and where
hardly any fits each row becomes a block of its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import IO

from coast_cli.output.answer import Answer, Cell, Row
from coast_cli.output.columns import IMPORTANT
from coast_cli.output.layout import GAP, LaidColumn, choose, fits, fold, pad, widths

_MOST_ROWS = 10_000  # more than anyone reads
_HEADING = 13  # characters of a line of a heading, where its words allow
_WORDS = re.compile(r"(?:per_m|n_m2)$|[^_]+_?|_")
_INDENT = "  "


def render(answer: Answer, stream: IO[str], *, width: int | None = None, chosen: bool = False) -> None:
    """Write the answer as an aligned table, with a last line that names its inputs.

    Args:
        answer: what to write. stream: where.
        width: columns of the terminal; None is as wide as it comes.
        chosen: the user chose these columns, so none is left out.
    """
    rows = answer.rows[:_MOST_ROWS]
    names = [name for name in next(iter(rows), {}) if any(row[name] is not None for row in rows)]
    columns = [_column(name, [row[name] for row in rows]) for name in names]
    shown = columns
    if width is not None and not fits(columns, width):
        shown = columns if chosen else choose(columns, IMPORTANT.get(answer.command, ()), width)
    if width is not None and (len(shown) < min(2, len(columns)) or not fits(shown, width)):
        _write(stream, _blocks(rows, names, width))
        shown = columns
    elif columns:
        _write(stream, _side_by_side(shown, width, "─" if _can_show(stream, "─") else "-"))
    _write(stream, _below(answer, len(rows), [one.name for one in columns if one not in shown], width))


def _side_by_side(columns: Sequence[LaidColumn], width: int | None, rule: str) -> Iterator[str]:
    """Yield the lines of a table: headings that end on one line, a rule, the rows."""
    room = widths(columns, width)
    tallest = max(len(column.heading) for column in columns)
    for number in range(tallest):
        lines = ([""] * (tallest - len(column.heading)) + column.heading for column in columns)
        yield _line([line[number] for line in lines], columns, room)
    yield rule * (sum(room) + GAP * (len(room) - 1))
    for cells in zip(*(column.cells for column in columns), strict=True):
        folded = [[cell] if width is None else fold(cell, size) for cell, size in zip(cells, room, strict=True)]
        for parts in zip_longest(*folded, fillvalue=""):
            yield _line(parts, columns, room)


def _line(cells: Sequence[str], columns: Sequence[LaidColumn], room: Sequence[int]) -> str:
    padded = [pad(c, size, to_right=one.to_right) for c, one, size in zip(cells, columns, room, strict=True)]
    return (" " * GAP).join(padded)


def _blocks(rows: Sequence[Row], names: Sequence[str], width: int) -> Iterator[str]:
    """Yield one record a block, a name and its value a line."""
    longest = max(map(len, names))
    beside = longest + GAP + width // 4 <= width
    for number, row in enumerate(rows):
        if number:
            yield ""
        for name in names:
            if row[name] is None:
                continue
            if beside:
                first, *more = fold(_cell(row[name]), width - longest - GAP)
                yield pad(name, longest + GAP, to_right=False) + first
                yield from (" " * (longest + GAP) + line for line in more)
            else:
                yield from fold(name, width)
                yield from (_INDENT + line for line in fold(_cell(row[name]), width - len(_INDENT)))


def _below(answer: Answer, written: int, left_out: Sequence[str], width: int | None) -> Iterator[str]:
    """Yield what stands under a table: what it leaves out, and what it was made from."""
    if len(answer.rows) > written:
        yield from _folded(f"{len(answer.rows) - written} more rows: --format csv or json writes them all", width)
    if left_out:
        yield ""
        yield from _folded(f"not shown: {', '.join(left_out)} (--wide shows all, --show NAME,NAME those named)", width)
    for config in answer.provenance.get("configs", ()):
        yield ""
        changes = f" with {', '.join(config['set'])}" if "set" in config else ""
        yield from _folded(f"{config['file']}{changes}  sha256 {config['sha256'][:16]}", width)


def _folded(text: str, width: int | None) -> list[str]:
    return [text] if width is None else fold(text, width)


def _write(stream: IO[str], lines: Iterator[str]) -> None:
    stream.writelines(f"{line.rstrip(' ')}\n" for line in lines)


def _can_show(stream: IO[str], mark: str) -> bool:
    try:
        mark.encode(getattr(stream, "encoding", None) or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def _column(name: str, values: Sequence[Cell]) -> LaidColumn:
    """Return a column; numbers and yes or no stand right."""
    to_right = any(isinstance(value, int | float) for value in values)
    return LaidColumn(name, _heading(name), [_cell(value) for value in values], to_right)


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
