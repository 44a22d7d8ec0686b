"""A file of text as columns of cells, found by numpy in one pass over its bytes; nothing here knows what a column means.

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
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
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
GUARDED = re.compile(
    "'(?='*[=+\\-@\uff1d\uff0b\uff0d\uff20])"
)  # the mark that keeps our own CSV files from being formulas


@dataclass(frozen=True)
class Dialect:
    """How a file of text is laid out, where it is not a header and then rows.

    Attributes:
        skip: lines before the header.
        comment: what a line begins with that is no row, or None.
        names: of the columns, for a file without a header.
        units_row: whether the line after the header says units.
    """

    skip: int = 0
    comment: str | None = None
    names: tuple[str, ...] | None = None
    units_row: bool = False


@dataclass(frozen=True)
class CellOrigin:
    """What a column was made from: its name and its place (from 1) in the file; value = scale * number + offset."""

    name: str
    place: int | None
    scale: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Table:
    """A header and its cells.

    Attributes:
        path: the file, as the user named it.
        digest: SHA-256 of its bytes.
        names: the header's names, stripped.
        header_line: line of the header; 0 of a table that stands in memory.
        line: line of each row, [n].
        decimal: the decimal mark, "." or ",".
        columns: for each column, [n] byte strings, stripped of nothing, or [n] numbers.
        origins: what columns were made from, for those that a mapping made.
    """

    path: str
    digest: str
    names: tuple[str, ...]
    header_line: int
    line: Integers
    decimal: str
    columns: tuple[Cells | Floats, ...]
    origins: Mapping[str, CellOrigin] = field(default_factory=dict)

    @cached_property
    def index(self) -> dict[str, int]:
        """The place of each column by its name."""
        return {name: place for place, name in enumerate(self.names)}

    def numbers(self, name: str, *, may_be_missing: bool = False) -> Floats:
        """Return a column as numbers, [n]; empty cells are NaN where they may be missing.

        Raises:
            BadInput: a cell is empty, not a number or beyond `LARGEST_NUMBER`; says file, line and column.
        """
        values = self._parsed(name, may_be_missing=may_be_missing)
        origin = self.origins.get(name)
        if origin is None or (origin.scale, origin.offset) == (1.0, 0.0):
            return values
        return origin.scale * values + origin.offset

    def _parsed(self, name: str, *, may_be_missing: bool) -> Floats:
        index = self.index[name]
        if self.columns[index].dtype.kind == "f":
            return self._checked(name, self.columns[index].astype(np.float64), may_be_missing=may_be_missing)
        cells = self.columns[index].astype(np.bytes_, copy=False)
        missing = np.isin(np.char.strip(cells), MISSING) if may_be_missing else np.zeros(len(cells), dtype=bool)
        width = cells.dtype.itemsize
        matrix = np.where(missing, b"0", cells).astype(cells.dtype).view(np.uint8).reshape(len(cells), width)
        if self.decimal == ",":
            self._refuse_grouped(name, cells)
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

    def _checked(self, name: str, values: Floats, *, may_be_missing: bool) -> Floats:
        wrong = ~(np.abs(values) <= LARGEST_NUMBER) & ~(np.isnan(values) if may_be_missing else False)
        if wrong.any():
            row = int(np.argmax(wrong))
            allowed = f"a number up to {LARGEST_NUMBER:g}"
            raise self.error("not a number", name=name, row=row, found=f"{values[row]:g}", allowed=allowed)
        return values

    def texts(self, name: str) -> tuple[Integers, tuple[str, ...]]:
        """Return a text column as the row where each stretch of equal cells starts, and that cell's text."""
        cells = self.columns[self.index[name]]
        starts = np.concatenate(([0], 1 + np.flatnonzero(cells[1:] != cells[:-1])))
        return starts, tuple(_text(cell) for cell in cells[starts].tolist())

    def error(self, message: str, *, name: str | None = None, row: int | None = None, **facts: str | None) -> BadInput:
        """Return an error that says file, line and column of a cell, or of the header when ``row`` is None."""
        place = None if name not in self.index else self.index[name] + 1
        origin = None if name is None else self.origins.get(name)
        return BadInput(
            message,
            file=self.path,
            line=(self.header_line or None) if row is None else int(self.line[row]),
            column=place if origin is None else origin.place,
            key=name if origin is None else origin.name,
            **facts,
        )

    def only(self, rows: NDArray[np.bool_]) -> Table:
        """Return the table with the rows that are True, [n]."""
        return replace(self, line=self.line[rows], columns=tuple(cells[rows] for cells in self.columns))

    def _refuse_grouped(self, name: str, cells: Cells) -> None:
        """Refuse ``1.000`` beside decimal commas: it may be a thousand, or one."""
        for row in np.flatnonzero(np.char.count(cells, b".")).tolist():
            text = cells[row].decode("utf-8").strip()
            if GROUPED.fullmatch(text):
                allowed = "a number without points between thousands, as this file has decimal commas"
                raise self.error("a thousand or one", name=name, row=row, found=text, allowed=allowed)

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


def _text(cell: bytes | float) -> str:
    return GUARDED.sub("", cell.decode("utf-8").strip(), 1) if isinstance(cell, bytes) else f"{cell:g}"


def _is_number(text: str) -> bool:
    try:
        value = float(text)
    except ValueError:
        return False
    return bool(np.isfinite(value)) and "_" not in text and text.isascii()


def read_table(path: str | Path, dialect: Dialect = Dialect()) -> Table:  # it is frozen
    """Read a file of text: UTF-8 with or without a byte order mark, any line ending; comma, semicolon, tab or spaces.

    With semicolons, tabs or spaces between cells a comma in a number is a decimal comma. Blank lines are skipped.

    Raises:
        BadInput: the file cannot be read, is too large, is not UTF-8, is empty, or a row has another number of cells.
    """
    data = bytes_of(path)
    digest = hashlib.sha256(data).hexdigest()
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(NEWLINE, 0, error.start) + 1
        raise BadInput("not UTF-8 text", file=path, line=line, hint="Save it as a CSV file in UTF-8.") from None
    if RETURN in data:
        data = data.replace(b"\r\n", NEWLINE).replace(RETURN, NEWLINE)
    head, body, header_line = _header(data, dialect, path)
    separator = _separator(head.decode("utf-8"), dialect.names)
    if separator == " ":
        head, body = (_one_space(part) for part in (head, body))
    names = dialect.names
    if names is None:
        header = next(_read(csv.reader([head.decode("utf-8")], delimiter=separator), str(path)))
        names = tuple(name.strip() for name in header)
    if body and not body.endswith(NEWLINE):
        body += NEWLINE
    counts = Counter(names)
    twice = next((name for name in names if name and counts[name] > 1), None)
    if twice:
        raise BadInput("two columns have the same name", file=path, line=header_line, found=twice)
    split = _split_quoted if QUOTE in body else _split
    columns, lines = split(body, separator, len(names), str(path), header_line + (dialect.names is None))
    first = 1 if dialect.units_row else 0
    columns, lines = tuple(cells[first:] for cells in columns), lines[first:]
    if len(lines) == 0:
        raise BadInput("a header and no rows", file=path, line=header_line, allowed="at least two rows of numbers")
    decimal = "," if separator != "," and any(map(_has_decimal_comma, columns)) else "."
    table = Table(str(path), digest, names, header_line, lines, decimal, columns)
    return _without_unnamed(table)


def _header(data: bytes, dialect: Dialect, path: str | Path) -> tuple[bytes, bytes, int]:
    """Return the header, or the first row where there is none; the rows; and the line of the header, from 1."""
    at = 0
    for _ in range(dialect.skip):
        at = 1 + data.find(NEWLINE, at) or len(data)
    before = data[:at].count(NEWLINE)
    data = data[at:]
    if dialect.comment is not None:
        data = re.sub(rb"(?m)^[ \t]*" + re.escape(dialect.comment.strip().encode()) + rb"[^\n]*", b"", data)
    blank = len(data) - len(data.lstrip(NEWLINE))
    head, _, body = data[blank:].partition(NEWLINE)
    if not head.strip():
        raise BadInput("the file is empty", file=path, allowed="one header row and at least two rows of numbers")
    return head, body if dialect.names is None else data[blank:], before + blank + 1


def _separator(head: str, names: tuple[str, ...] | None) -> str:
    """Return what stands between the cells of a line: as often as names are given, else most often, spaces last."""
    if names is not None:  # the line is a row, in which commas may be decimal
        fits = (mark for mark in ";\t," if head.count(mark) == len(names) - 1)
        return next(fits, " " if len(head.split()) == len(names) else ",")
    best = max(",;\t", key=head.count)
    return " " if best not in head and " " in head.strip() else best


def _one_space(text: bytes) -> bytes:
    """Return a text with one space between the cells of a line and none around them."""
    return re.sub(rb"[ \t]+", b" ", text).replace(b"\n ", NEWLINE).replace(b" \n", NEWLINE).strip(b" ")


def bytes_of(path: str | Path) -> bytes:
    """Return the bytes of a file that is not too large to read at once.

    Raises:
        BadInput: it is too large, or cannot be read.
    """
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
    return replace(table, names=names, columns=columns)


def segments(starts: Integers, count: int) -> list[tuple[int, int]]:
    """Return (start, stop) of each stretch that begins at ``starts`` in an array of ``count`` rows."""
    return list(pairwise([*starts.tolist(), count]))
