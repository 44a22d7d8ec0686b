"""Values that stand for those of a file while a command runs, written into its text before it is read.

So what refuses them, what hashes them and what sends the text to another process need not know of them.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from coast_cli.errors import UsageError, nearest
from coast_cli.spec.edit import path_of, written

_NONE: Mapping[str, tuple[str, ...]] = {}
_CHANGES: ContextVar[Mapping[str, tuple[str, ...]]] = ContextVar("CHANGES", default=_NONE)


@contextmanager
def changing(files: Sequence[Path], assignments: Sequence[str]) -> Iterator[None]:
    """Let each of ``files`` be read with ``KEY=VALUE`` put in place, until the block ends."""
    token = _CHANGES.set({str(file): tuple(assignments) for file in files})
    try:
        yield
    finally:
        _CHANGES.reset(token)


def changes_of(file: str) -> tuple[str, ...]:
    """Return the assignments that a file is read with."""
    return _CHANGES.get().get(file, ())


def changed(text: str, file: str) -> str:
    """Return the text of a file with its changes in place; a text that is no TOML is returned as it is, to be refused.

    Raises:
        UsageError: an assignment is none, or names a tube that is not there.
    """
    assignments = changes_of(file)
    if not assignments:
        return text
    try:
        document = tomllib.loads(text)
    except ValueError:
        return text
    notes = {}
    for assignment in assignments:
        notes[_put(document, assignment)] = "set for this run"
    return written(document, text, notes)


def _put(document: dict[str, Any], assignment: str) -> tuple[str | int, ...]:
    key, sign, value = (part.strip() for part in assignment.partition("="))
    if not (key and sign and value):
        raise UsageError(f"{assignment}: not understood; allowed: KEY=VALUE, such as joint.deadband_mm=1.1.")
    try:
        path = path_of(document, key)
    except KeyError as error:
        part, names = error.args
        raise UsageError(
            f"{key}: there is no {part}; allowed: {', '.join(names)}. {nearest(part, names)}".rstrip()
        ) from None
    here: Any = document
    for part in path[:-1]:
        here = here.setdefault(part, {}) if isinstance(here, dict) else here[int(part)]
        if not isinstance(here, dict | list):
            raise UsageError(f"{key}: {part} is a value, not a table.")
    here[path[-1]] = _value(value)
    return path


def _value(text: str) -> Any:  # noqa: ANN401
    """Return a value as TOML reads it; a word that is no TOML is itself."""
    try:
        (value,) = tomllib.loads(f"x = {text}").values()
    except ValueError:
        return text
    return value
