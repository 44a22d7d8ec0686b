"""Write numbers into a TOML text and keep the rest of it as its author wrote it, comments above all.

A library that keeps comments (tomlkit) would be another dependency of the core for three small edits: a value changes, a key
or a table is added, a tube is added. What is written is read back; where it does not say what it should, the plain text of
the document is returned instead, so that a comment may be lost but never a number.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from coast_cli.spec.positions import Path, Spans, spans

_BARE = re.compile(r"[A-Za-z0-9_-]+")


class _Edit(NamedTuple):
    """Text that takes the place of what stands from ``start`` to ``end``."""

    start: int
    end: int
    text: str


def written(document: Mapping[str, Any], text: str, notes: Mapping[Path, str] | None = None) -> str:
    """Return TOML that says ``document``, as an edit of ``text``, whose comments stay.

    Args:
        document: what it shall say, of the kinds that TOML has.
        text: the TOML that it was made from, or empty for one without comments.
        notes: what to say of a value that changed or is new, in a comment on its line, before what stood there.
    """
    import tomli_w

    wanted = _plain(document)
    if text:
        result = _edited(text, tomllib.loads(text), wanted, notes or {})
        if _says(result, wanted):
            return result
    return tomli_w.dumps(wanted)


def path_of(document: Mapping[str, Any], key: str) -> Path:
    """Return the path of a dotted key, in which an item of a list stands by its name or its number.

    Raises:
        KeyError: with the part that is not there and the names that are.
    """
    path: Path = ()
    here: Any = document
    for part in key.replace("[", ".").replace("]", "").split("."):
        if isinstance(here, list):
            number = _index(here, part)
            here, path = here[number], (*path, number)
        else:
            here, path = here.get(part) if isinstance(here, dict) else None, (*path, part)
    return path


def _index(items: Sequence[Any], part: str) -> int:
    names = [str(item["name"]) if isinstance(item, dict) and "name" in item else str(n) for n, item in enumerate(items)]
    if part in names:
        return names.index(part)
    if part.isdecimal() and int(part) < len(items):
        return int(part)
    raise KeyError(part, names)


def _says(text: str, document: Mapping[str, Any]) -> bool:
    try:
        return tomllib.loads(text) == document
    except ValueError:
        return False


def _edited(text: str, old: dict[str, Any], new: dict[str, Any], notes: Mapping[Path, str]) -> str:
    editor = _Editor(text, spans(text), notes)
    edits = sorted(editor.table((), old, new), key=lambda edit: edit.start)
    for edit in reversed(edits):
        text = text[: edit.start] + edit.text + text[edit.end :]
    return text if text.endswith("\n") else f"{text}\n"


class _Editor:
    """Finds the edits that make of one document another."""

    def __init__(self, text: str, found: Spans, notes: Mapping[Path, str]) -> None:
        self.text, self.found, self.notes = text, found, notes

    def table(self, path: Path, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[_Edit]:
        """Yield the edits of one table and of those below it."""
        for key, value in new.items():
            here = (*path, key)
            if key not in old:
                yield from self.added(here, value)
            elif isinstance(value, dict) and isinstance(old[key], dict):
                yield from self.table(here, old[key], value)
            elif _of_tables(value) and _of_tables(old[key]) and here not in self.found.values:
                yield from self.tables(here, old[key], value)
            elif value != old[key] and here in self.found.values:
                yield from self.replaced(here, old[key], value)

        for key in old.keys() - new.keys():
            yield from self.removed((*path, key))

    def removed(self, path: Path) -> Iterator[_Edit]:
        """Yield the edits that take away a key, or a table with those below it, by whole lines."""
        if path in self.found.values and path[:-1] not in self.found.values:
            yield self._without(self.found.keys[path], self.found.values[path][1])
        for table, end in self.found.tables.items():
            if table[: len(path)] == path:
                yield self._without(self.found.keys[table], end)

    def _without(self, start: int, end: int) -> _Edit:
        start = self.text.rfind("\n", 0, start) + 1
        return _Edit(start, min(self._line_end(end) + 1, len(self.text)), "")

    def tables(self, path: Path, old: Sequence[Any], new: Sequence[Any]) -> Iterator[_Edit]:
        """Yield the edits of an array of tables, new ones after the last."""
        for index, (before, after) in enumerate(zip(old, new, strict=False)):
            yield from self.table((*path, index), before, after)
        last = (*path, len(old) - 1)
        ends = [end for table, end in self.found.tables.items() if table[: len(last)] == last]
        for item in new[len(old) :] if ends else ():
            pairs = "".join(f"{_key(key)} = {_toml(value)}\n" for key, value in item.items())
            yield self._line_after(max(ends), f"\n[[{_dotted(path)}]]\n{pairs}")

    def replaced(self, path: Path, old: Any, new: Any) -> Iterator[_Edit]:  # noqa: ANN401
        """Yield the edits of a value and of the comment beside it."""
        start, end = self.found.values[path]
        yield _Edit(start, end, _toml(new))
        note = self.notes.get(path)
        if note is None:
            return
        eol = self._line_end(end)
        beside = next((comment for comment in self.found.comments if end <= comment[0] < eol), None)
        said = "" if beside is None else self.text[beside[0] + 1 : beside[1]].strip()
        was = f"; was {_toml(old)}" + (f": {said}" if said else "")
        if beside is not None:
            yield _Edit(*beside, f"# {note}{was}")
        else:
            yield _Edit(eol, eol, f"  # {note}{was}")

    def added(self, path: Path, value: Any) -> Iterator[_Edit]:  # noqa: ANN401
        """Yield the edits of a key that is new."""
        parent, note = path[:-1], self.notes.get(path)
        comment = f"  # {note}" if note else ""
        line = f"{_key(path[-1])} = {_toml(value)}{comment}\n"
        if parent in self.found.values:  # an inline table
            end = self.found.values[parent][1] - 1
            end = len(self.text[:end].rstrip())
            comma = "" if self.text[end - 1] == "{" else ","
            yield _Edit(end, end, f"{comma} {_key(path[-1])} = {_toml(value)}")
        elif isinstance(value, dict) and not any(isinstance(part, int) for part in path):
            yield _Edit(len(self.text), len(self.text), "".join(_sections(path, value)))
        elif parent in self.found.tables:
            yield self._line_after(self.found.tables[parent], line)
        elif parent:
            yield _Edit(len(self.text), len(self.text), f"\n[{_dotted(parent)}]\n{line}")
        else:
            yield _Edit(0, 0, line)

    def _line_after(self, offset: int, line: str) -> _Edit:
        end = self._line_end(offset)
        return _Edit(end, end, f"\n{line.rstrip()}")

    def _line_end(self, offset: int) -> int:
        end = self.text.find("\n", offset)
        end = len(self.text) if end < 0 else end
        return end - 1 if self.text[end - 1 : end] == "\r" else end


def _sections(path: Path, table: Mapping[str, Any]) -> Iterator[str]:
    """Yield the text of a new table with a header, and of the tables in it."""
    flat = {key: value for key, value in table.items() if not isinstance(value, dict)}
    if flat or not table:
        yield f"\n[{_dotted(path)}]\n" + "".join(f"{_key(key)} = {_toml(value)}\n" for key, value in flat.items())
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _sections((*path, key), value)


def _of_tables(value: Any) -> bool:  # noqa: ANN401
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _plain(value: Any) -> Any:  # noqa: ANN401
    """Return a value with lists for tuples and dicts for mappings, as TOML is read."""
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    return [_plain(inner) for inner in value] if isinstance(value, list | tuple) else value


def _toml(value: Any) -> str:  # noqa: ANN401
    """Return a value as TOML in one line."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    import tomli_w

    return tomli_w.dumps({"x": value}).removeprefix("x = ").rstrip("\n")


def _dotted(path: Path) -> str:
    return ".".join(_key(part) for part in path if isinstance(part, str))


def _key(part: str | int) -> str:
    import json

    return str(part) if _BARE.fullmatch(str(part)) else json.dumps(part)
