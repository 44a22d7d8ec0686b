"""What a command reads and what it writes, said where its options are declared, and compared before it runs.

Two paths are one file where device and inode agree, whatever links lead there; of files that do not exist yet the resolved
paths are compared. A file that is read is never written, and no file is written twice.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from stat import S_ISREG
from typing import Any, get_type_hints

from typer.models import ArgumentInfo, OptionInfo

from coast_cli.errors import BadInput

Key = tuple[int, int] | str


@dataclass(frozen=True)
class Reads:
    """Marks a parameter that names files to read; ``otherwise`` is the one that is read where none is named."""

    otherwise: Path | None = None


@dataclass(frozen=True)
class Writes:
    """Marks a parameter that names files to write; ``files`` finds them where the parameter is not their path."""

    files: Callable[[Mapping[str, Any]], list[Path]] | None = None


READS, WRITES = Reads(), Writes()


@dataclass(frozen=True)
class _Named:
    """A file as the user named it, and by which argument or option."""

    path: Path
    by: str

    def __str__(self) -> str:
        return f"{self.by} {self.path}"


def kept_apart(command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command that refuses to write what it reads, or one file twice, before it does anything.

    Raises:
        BadInput: naming both.
    """

    @wraps(command)
    def run(**given: Any) -> Any:  # noqa: ANN401
        reads, writes = _files(command, given)
        _refuse_shared(reads, writes)
        _refuse_unwritable(writes)
        return command(**given)

    return run


def _files(command: Callable[..., Any], given: Mapping[str, Any]) -> tuple[list[_Named], list[_Named]]:
    """Return the files that the command reads, and those that it writes."""
    reads, writes = list[_Named](), list[_Named]()
    for name, hint in get_type_hints(command, include_extras=True).items():
        marks = getattr(hint, "__metadata__", ())
        mark = next((mark for mark in marks if isinstance(mark, Reads | Writes)), None)
        if mark is None:
            continue
        paths = list(_paths(given.get(name)))
        if isinstance(mark, Reads) and not paths and mark.otherwise is not None:
            paths = [mark.otherwise]
        if isinstance(mark, Writes) and paths and mark.files is not None:
            paths = mark.files(given)
        named = [_Named(path, _called(name, marks)) for path in paths]
        (reads if isinstance(mark, Reads) else writes).extend(named)
    return reads, writes


def _paths(value: Any) -> Iterator[Path]:  # noqa: ANN401
    """Yield the paths of a parameter, which has one, several or none."""
    for item in value if isinstance(value, list | tuple) else [value]:
        if item is not None:
            yield Path(item)


def _called(name: str, marks: tuple[object, ...]) -> str:
    """Return what the user calls a parameter: CONFIG, or -o."""
    for mark in marks:
        if isinstance(mark, ArgumentInfo):
            return (mark.metavar or name.upper()).strip("[].")
        if isinstance(mark, OptionInfo):  # the first name is where a default would stand outside Annotated
            names = [text for text in map(str, (mark.default, *(mark.param_decls or ()))) if text.startswith("-")]
            return min(names, key=len, default=f"--{name.replace('_', '-')}")
    return name


def _refuse_shared(reads: list[_Named], writes: list[_Named]) -> None:
    known = {key: named for named in reads if (key := _existing(named.path)) is not None}
    inputs = set(known)
    shown = _stdout()
    if shown in known:
        raise BadInput(f"stdout would be written to {known[shown]}, which is read", hint="Lead it to another file.")
    for named in writes:
        key = _existing(named.path) or os.path.normcase(os.path.realpath(named.path))
        if key in inputs:
            hint = "Give the output another name."
            raise BadInput(f"{named} would be written over {known[key]}, which is read", hint=hint)
        if key in known or key == shown:
            raise BadInput(f"{named} and {known.get(key, 'stdout')} are one file", hint="Give each a name of its own.")
        known[key] = named


def _refuse_unwritable(writes: list[_Named]) -> None:
    from coast_cli.output.atomic import destination

    for named in writes:
        destination(named.path)


def _existing(path: Path) -> Key | None:
    """Return device and inode of a regular file, or None; devices and pipes may be shared."""
    try:
        found = path.stat()
    except (OSError, ValueError):  # not there, a loop of links, or no name at all
        return None
    return (found.st_dev, found.st_ino) if S_ISREG(found.st_mode) else None


def _stdout() -> Key | None:
    """Return device and inode of the file that stdout is led to, or None."""
    try:
        found = os.fstat(sys.stdout.fileno())
    except (OSError, ValueError):  # closed, or replaced by what is no file
        return None
    return (found.st_dev, found.st_ino) if S_ISREG(found.st_mode) else None
