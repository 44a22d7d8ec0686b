"""Where each key of a TOML text stands. ``tomllib`` parses but forgets the places, so this scanner finds them again.

It runs on text that ``tomllib`` has accepted, so it checks nothing: it only walks headers, keys and values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

Path = tuple[str | int, ...]

_BARE_KEY_END = set(" \t.=]")
_SCALAR_END = set(",]}#\n\r")
_ESCAPES = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", "e": "\x1b", '"': '"', "\\": "\\"}


class Position(NamedTuple):
    """A place in a text; line and column count from 1."""

    line: int
    column: int


def key_positions(text: str) -> dict[Path, Position]:
    """Return the place of each key and of each array element of a valid TOML text.

    A path is the chain of keys and list indices as in the parsed document, e.g. ``("outer", "samples", 0, "name")``.
    A table named by several headers keeps the place of the first; a dotted key places each of its tables.
    """
    return _Scanner(text).scan()


def line_comments(text: str) -> dict[int, str]:
    """Return what the comment of each line of a valid TOML text says, by line; lines without one are left out."""
    scanner = _Scanner(text)
    scanner.scan()
    place = _places(text)
    return {place(start).line: text[start + 1 : end].strip() for start, end in scanner.comments}


@dataclass(frozen=True)
class Spans:
    """Offsets of what a TOML text holds, for who writes into it.

    Attributes:
        keys: of each key, or of the header of each table, its first character.
        values: of each value that follows an equals sign, from its first character to past its last.
        tables: of each table with a header, past its last value, or past its header where it has none.
        comments: from each mark to the end of its line.
    """

    keys: dict[Path, int]
    values: dict[Path, tuple[int, int]]
    tables: dict[Path, int]
    comments: list[tuple[int, int]]


def spans(text: str) -> Spans:
    """Return where the values, tables and comments of a valid TOML text are."""
    scanner = _Scanner(text)
    scanner.scan()
    return Spans(scanner.found, scanner.values, scanner.tables, scanner.comments)


class _Scanner:
    """A cursor over the text; each method reads one construct and leaves the cursor behind it."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.found: dict[Path, int] = {}
        self.last_index: dict[Path, int] = {}  # of each array of tables
        self.comments: list[tuple[int, int]] = []
        self.values: dict[Path, tuple[int, int]] = {}
        self.tables: dict[Path, int] = {}

    def scan(self) -> dict[Path, Position]:
        table: Path = ()
        while self._skip_blank():
            if self._peek() == "[":
                table = self._header()
            else:
                self._pair(table)
            self.tables[table] = self.at
        return self._positions()

    def _header(self) -> Path:
        start = self.at
        is_array = self.text.startswith("[[", self.at)
        self.at += 2 if is_array else 1
        keys = self._dotted_key()
        self._skip_spaces()
        self.at += 2 if is_array else 1
        path: Path = ()
        for position, (key, _) in enumerate(keys):
            path = (*path, key)
            self.found.setdefault(path, start)
            is_last = position == len(keys) - 1
            if is_last and is_array:
                self.last_index[path] = self.last_index.get(path, -1) + 1
            if path in self.last_index:
                path = (*path, self.last_index[path])
                self.found.setdefault(path, start)
        return path

    def _pair(self, table: Path) -> None:
        path = table
        for key, start in self._dotted_key():
            path = (*path, key)
            self.found.setdefault(path, start)
        self._skip_spaces()
        self.at += 1  # the equals sign
        self._skip_spaces()
        start = self.at
        self._value(path)
        self.values[path] = (start, start + len(self.text[start : self.at].rstrip()))

    def _value(self, path: Path) -> None:
        character = self._peek()
        if character in "\"'":
            self._string()
        elif character == "[":
            self._array(path)
        elif character == "{":
            self._inline_table(path)
        else:
            while self._peek() and self._peek() not in _SCALAR_END:
                self.at += 1

    def _array(self, path: Path) -> None:
        self.at += 1
        index = 0
        while self._skip_blank(",") and self._peek() != "]":
            self.found[(*path, index)] = self.at
            self._value((*path, index))
            index += 1
        self.at += 1

    def _inline_table(self, path: Path) -> None:
        self.at += 1
        while self._skip_blank(",") and self._peek() != "}":
            self._pair(path)
        self.at += 1

    def _dotted_key(self) -> list[tuple[str, int]]:
        keys = []
        while True:
            self._skip_spaces()
            start = self.at
            if self._peek() in "\"'":
                keys.append((self._string(), start))
            else:
                while self._peek() not in _BARE_KEY_END:
                    self.at += 1
                keys.append((self.text[start : self.at], start))
            self._skip_spaces()
            if self._peek() != ".":
                return keys
            self.at += 1

    def _string(self) -> str:
        quote = self._peek()
        triple = self.text.startswith(quote * 3, self.at)
        delimiter = quote * 3 if triple else quote
        self.at += len(delimiter)
        start = self.at
        while not self.text.startswith(delimiter, self.at):
            self.at += 2 if quote == '"' and self._peek() == "\\" else 1
        while triple and self.text.startswith(delimiter, self.at + 1):
            self.at += 1  # up to two quotes may stand right before the closing three
        raw = self.text[start : self.at]
        self.at += len(delimiter)
        return _unescape(raw) if quote == '"' else raw

    def _skip_blank(self, also: str = "") -> bool:
        """Skip spaces, line ends and comments (and the characters of ``also``); tell whether text is left."""
        skipped = " \t\r\n" + also
        while self._peek():
            if self._peek() == "#":
                end = self.text.find("\n", self.at)
                end = len(self.text) if end < 0 else end
                self.comments.append((self.at, end))
                self.at = end
            elif self._peek() in skipped:
                self.at += 1
            else:
                return True
        return False

    def _skip_spaces(self) -> None:
        while self._peek() and self._peek() in " \t":
            self.at += 1

    def _peek(self) -> str:
        return self.text[self.at : self.at + 1]

    def _positions(self) -> dict[Path, Position]:
        place = _places(self.text)
        return {path: place(offset) for path, offset in self.found.items()}


def _places(text: str) -> Callable[[int], Position]:
    """Return what tells line and column of an offset into the text."""
    from bisect import bisect_right

    starts = [0] + [index + 1 for index, character in enumerate(text) if character == "\n"]

    def place(offset: int) -> Position:
        line = bisect_right(starts, offset)
        return Position(line, offset - starts[line - 1] + 1)

    return place


def _unescape(raw: str) -> str:
    """Resolve the escapes of a one-line basic string (keys; the text of a value is never needed)."""
    if "\\" not in raw:
        return raw
    characters = []
    at = 0
    while at < len(raw):
        if raw[at] != "\\":
            characters.append(raw[at])
            at += 1
            continue
        kind = raw[at + 1]
        digits = {"x": 2, "u": 4, "U": 8}.get(kind, 0)
        code = raw[at + 2 : at + 2 + digits]
        characters.append(chr(int(code, 16)) if digits else _ESCAPES.get(kind, ""))
        at += 2 + digits
    return "".join(characters)
