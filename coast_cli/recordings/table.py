"""A CSV file as columns of cells, found by numpy in one pass over its bytes; nothing here knows what a column means.

Separators are found with array operations, so that a million rows take about a second; a cell that is not a number is
looked for one by one only after the fast conversion has failed, to name its line and column.
"""

from __future__ import annotations

import csv
import hashlib
import io
import os
import re
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import BadInput

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]
    Cells = NDArray[np.bytes_]

LARGEST_FILE = 256 * 2**20
LARGEST_QUOTED = LARGEST_FILE // 4  # cell by cell, in ten times the memory
LARGEST_COLUMN, LONGEST_CELL = 2**29, 10_000  # bytes; a column is as wide as its widest cell
LARGEST_NUMBER = 1e15  # past any recorded quantity in any unit, and its powers are still numbers
NEWLINE, RETURN, QUOTE = b"\n", b"\r", b'"'
IN_NUMBERS = np.zeros(256, dtype=bool)
IN_NUMBERS[[*b"+-.0123456789eE \t\0"]] = True
MISSING = (b"", b"nan", b"NaN", b"NAN")
GROUPED = re.compile(r"[+-]?[0-9]{1,3}(\.[0-9]{3})+")  # beside decimal commas: thousands, or a decimal point?
GUARDED = re.compile(r"'(?=[=+\-@])")  # the mark that keeps our own CSV files from being formulas


@dataclass(frozen=True, eq=False)
class Table:
    """A header and its cells.

    Attributes:
        path: the file, as the user named it.
        digest: SHA-256 of its bytes.
        names: the header's names, stripped.
        header_line: line of the header.
        line: line of each row, [n].
        decimal: the decimal mark, "." or ",".
        cells: for each column, [n] byte strings, stripped of nothing.
    """

    path: str
    digest: str
    names: tuple[str, ...]
    header_line: int
    line: Integers
    decimal: str
    columns: tuple[Cells, ...]

    @cached_property
    def index(self) -> dict[str, int]:
        """The place of each column by its name."""
        return {name: place for place, name in enumerate(self.names)}

    def numbers(self, name: str, *, may_be_missing: bool = False) -> Floats:
        """Return a column as numbers, [n]; empty cells are NaN where they may be missing.

        Raises:
            BadInput: a cell is empty, not a number or beyond `LARGEST_NUMBER`; says file, line and column.
        """
        index = self.index[name]
        cells = self.columns[index]
        missing = np.isin(np.char.strip(cells), MISSING) if may_be_missing else np.zeros(len(cells), dtype=bool)
        width = cells.dtype.itemsize
        matrix = np.where(missing, b"0", cells).astype(cells.dtype).view(np.uint8).reshape(len(cells), width)
        if self.decimal == ",":
            self._refuse_grouped(index)
            matrix[matrix == ord(",")] = ord(".")
        if IN_NUMBERS[matrix].all():
            try:
                values = matrix.reshape(-1).view(cells.dtype).astype(np.float64)
            except ValueError:
                pass
            else:
                if (np.abs(values) <= LARGEST_NUMBER).all():
                    values[missing] = np.nan
                    return values
        raise self._first_bad_cell(index, missing)

    def texts(self, name: str) -> tuple[Integers, tuple[str, ...]]:
        """Return a text column as the row where each stretch of equal cells starts, and that cell's text."""
        cells = self.columns[self.index[name]]
        starts = np.concatenate(([0], 1 + np.flatnonzero(cells[1:] != cells[:-1])))
        return starts, tuple(GUARDED.sub("", cell.decode("utf-8").strip(), 1) for cell in cells[starts].tolist())

    def error(self, message: str, *, name: str | None = None, row: int | None = None, **facts: str | None) -> BadInput:
        """Return an error that says file, line and column of a cell, or of the header when ``row`` is None."""
        return BadInput(
            message,
            file=self.path,
            line=self.header_line if row is None else int(self.line[row]),
            column=None if name not in self.index else self.index[name] + 1,
            key=name,
            **facts,
        )

    def _refuse_grouped(self, index: int) -> None:
        """Refuse ``1.000`` beside decimal commas: it may be a thousand, or one."""
        cells = self.columns[index]
        for row in np.flatnonzero(np.char.count(cells, b".")).tolist():
            text = cells[row].decode("utf-8").strip()
            if GROUPED.fullmatch(text):
                allowed = "a number without points between thousands, as this file has decimal commas"
                raise self.error("a thousand or one", name=self.names[index], row=row, found=text, allowed=allowed)

    def _first_bad_cell(self, index: int, missing: NDArray[np.bool_]) -> BadInput:
        name = self.names[index]
        for row, cell in enumerate(self.columns[index].tolist()):
            text = cell.decode("utf-8").strip()
            plain = text.replace(",", ".") if self.decimal == "," else text
            if missing[row]:
                continue
            if not text:
                return self.error("an empty cell", name=name, row=row, allowed="a number")
            if not _is_number(plain):
                return self.error("not a number", name=name, row=row, found=text, allowed="a finite decimal number")
            if abs(float(plain)) > LARGEST_NUMBER:
                allowed = f"up to {LARGEST_NUMBER:g}"
                return self.error("too large for any recording", name=name, row=row, found=text, allowed=allowed)
        return self.error("a cell that is not a number", name=name)


def _is_number(text: str) -> bool:
    try:
        value = float(text)
    except ValueError:
        return False
    return bool(np.isfinite(value)) and "_" not in text and text.isascii()


def read_table(path: str | Path) -> Table:
    """Read a CSV file: UTF-8 with or without a byte order mark, any line ending, comma, semicolon or tab between cells.

    With semicolons a comma in a number is a decimal comma. Blank lines are skipped.

    Raises:
        BadInput: the file cannot be read, is too large, is not UTF-8, is empty, or a row has another number of cells.
    """
    data = _bytes_of(path)
    digest = hashlib.sha256(data).hexdigest()
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(NEWLINE, 0, error.start) + 1
        raise BadInput("not UTF-8 text", file=path, line=line, hint="Save it as a CSV file in UTF-8.") from None
    if RETURN in data:
        data = data.replace(b"\r\n", NEWLINE).replace(RETURN, NEWLINE)
    skipped = len(data) - len(data.lstrip(NEWLINE))
    head, _, body = data[skipped:].partition(NEWLINE)
    if not head.strip():
        raise BadInput("the file is empty", file=path, allowed="one header row and at least two rows of numbers")
    header_line = skipped + 1
    separator = max(",;\t", key=head.decode("utf-8").count)
    header = next(_read(csv.reader([head.decode("utf-8")], delimiter=separator), str(path)))
    names = tuple(name.strip() for name in header)
    if body and not body.endswith(NEWLINE):
        body += NEWLINE
    counts = Counter(names)
    twice = next((name for name in names if name and counts[name] > 1), None)
    if twice:
        raise BadInput("two columns have the same name", file=path, line=header_line, found=twice)
    split = _split_quoted if QUOTE in body else _split
    columns, lines = split(body, separator, len(names), str(path), header_line + 1)
    if len(lines) == 0:
        raise BadInput("a header and no rows", file=path, line=header_line, allowed="at least two rows of numbers")
    decimal = "," if separator == ";" and any(map(_has_decimal_comma, columns)) else "."
    table = Table(str(path), digest, names, header_line, lines, decimal, columns)
    return _without_unnamed(table)


def _bytes_of(path: str | Path) -> bytes:
    try:
        with Path(path).open("rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            data = b"" if size > LARGEST_FILE else stream.read((size or LARGEST_FILE) + 1)  # a pipe does not tell
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot be read ({getattr(error, 'strerror', None) or error})", file=path) from None
    _refuse_large(path, max(size, len(data)), LARGEST_FILE, "the file is too large to read at once")
    return data


def _refuse_large(path: str | Path, size: int, most: int, message: str) -> None:
    if size > most:
        raise BadInput(
            message,
            file=path,
            found=f"{size / 2**20:.0f} MB",
            allowed=f"at most {most // 2**20} MB",
            hint="Split it into files of whole runs, or keep every n-th row.",
        )


def _split(body: bytes, separator: str, count: int, path: str, first_line: int) -> tuple[tuple[Cells, ...], Integers]:
    """Return the cells of each column and the line of each row, for a body without quotes."""
    text = np.frombuffer(body, dtype=np.uint8)
    newlines = np.flatnonzero(text == ord("\n"))
    starts = np.concatenate(([0], newlines[:-1] + 1)).astype(np.int64)
    filled = newlines > starts
    lines = first_line + np.flatnonzero(filled)
    ends = np.flatnonzero((text == ord(separator)) | (text == ord("\n")))
    if not filled.all():
        ends = ends[np.isin(ends, newlines[~filled], assume_unique=True, invert=True)]
    per_row = np.diff(np.searchsorted(ends, newlines[filled]), prepend=-1)
    if (per_row != count).any():
        row = int(np.argmax(per_row != count))
        raise _ragged(path, int(lines[row]), int(per_row[row]), count)
    begins = starts[filled]
    columns = []
    for stops in ends.reshape(-1, count).T:
        _refuse_wide(stops - begins, lines, path)
        columns.append(_gather(text, begins, stops))
        begins = stops + 1
    return tuple(columns), lines


def _gather(text: NDArray[np.uint8], begins: Integers, ends: Integers) -> Cells:
    lengths = ends - begins
    width = max(int(lengths.max(initial=0)), 1)
    matrix = np.zeros((len(begins), width), dtype=np.uint8)
    for offset in range(width):
        matrix[:, offset] = np.where(offset < lengths, text[np.minimum(begins + offset, len(text) - 1)], 0)
    return matrix.view(f"S{width}").reshape(-1)


def _read(reader: Iterator[list[str]], path: str) -> Iterator[list[str]]:
    try:
        yield from reader
    except csv.Error as error:  # a quote that opens and does not close, for more text than a cell may have
        raise BadInput(f"not a CSV file: {error}", file=path) from None


def _split_quoted(
    body: bytes, separator: str, count: int, path: str, first_line: int
) -> tuple[tuple[Cells, ...], Integers]:
    """Return the same as `_split` for a body with quoted cells, row by row."""
    _refuse_large(path, len(body), LARGEST_QUOTED, "the file has quoted cells and is too large for that")
    rows: list[list[str]] = []
    lines: list[int] = []
    reader = csv.reader(io.StringIO(body.decode("utf-8"), newline=""), delimiter=separator)
    line = first_line
    for row in _read(reader, path):
        if row and len(row) != count:
            raise _ragged(path, line, len(row), count)
        if row:
            rows.append(row)
            lines.append(line)
        line = first_line + reader.line_num
    numbers = np.array(lines, dtype=np.int64)
    columns = []
    for column in zip(*rows, strict=True):
        cells = [cell.encode() for cell in column]
        _refuse_wide(np.array([len(cell) for cell in cells]), numbers, path)
        columns.append(np.array(cells, dtype=np.bytes_))
    return tuple(columns), numbers


def _refuse_wide(lengths: Integers, lines: Integers, path: str) -> None:
    widest = int(np.argmax(lengths)) if len(lengths) else 0
    most = min(LONGEST_CELL, LARGEST_COLUMN // max(len(lengths), 1))
    if len(lengths) and lengths[widest] > most:
        found, allowed = f"{lengths[widest]} characters", f"at most {most} in a table of {len(lengths)} rows"
        raise BadInput("a cell is too long", file=path, line=int(lines[widest]), found=found, allowed=allowed)


def _ragged(path: str, line: int, found: int, count: int) -> BadInput:
    return BadInput(
        "a row of another length than the header",
        file=path,
        line=line,
        found=f"{found} cells",
        allowed=f"{count} cells",
    )


def _has_decimal_comma(cells: Cells) -> bool:
    """Return whether a cell is a number but for a comma; one in a text says nothing."""
    if b"," not in cells.tobytes():
        return False
    matrix = cells.view(np.uint8).reshape(len(cells), -1)
    commas = matrix == ord(",")
    return bool((commas.any(axis=1) & (IN_NUMBERS[matrix] | commas).all(axis=1)).any())


def _without_unnamed(table: Table) -> Table:
    """Drop empty columns without a name, as a separator at the end of each row makes them."""
    keep = [bool(name) or bool((cells != b"").any()) for name, cells in zip(table.names, table.columns, strict=True)]
    if all(keep):
        return table
    names = tuple(name for name, kept in zip(table.names, keep, strict=True) if kept)
    columns = tuple(cells for cells, kept in zip(table.columns, keep, strict=True) if kept)
    return Table(table.path, table.digest, names, table.header_line, table.line, table.decimal, columns)


def segments(starts: Integers, count: int) -> list[tuple[int, int]]:
    """Return (start, stop) of each stretch that begins at ``starts`` in an array of ``count`` rows."""
    return list(pairwise([*starts.tolist(), count]))
