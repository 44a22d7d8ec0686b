"""What an unfinished run has done, in a folder that is the user's alone: a later run reads it, and goes on from there.

Its note is one line of JSON, then the arrays as they lie in memory, then a digest, keyed by what was asked, of all before
it. Reading takes as much memory as the file has bytes, and no note is believed whose digest is another.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import blake2b, sha256
from math import prod
from pathlib import Path
from stat import S_IMODE, S_ISDIR
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.errors import BadInput, UsageError
from coast_cli.output.atomic import write_files

Arrays = Mapping[str, NDArray[Any]]
VERSION = 1  # of the note
LARGEST_NOTE = 2 * 2**30
_NAME = "note"
_DIGEST_BYTES = 32
_OTHERS_MAY_WRITE = 0o022
_HINT = "Delete the folder to begin anew."


@dataclass(frozen=True)
class Note:
    """How far a run is.

    Attributes:
        blocks: that are done. state: what the next block must know.
        size, rows: bytes of the rows that count, and their digest; none where no rows are kept.
    """

    blocks: int = 0
    state: Arrays = field(default_factory=dict)
    size: int = 0
    rows: str = ""


def open_folder(folder: Path) -> bool:
    """Make the folder, or take the one that is there; return whether it was made.

    Raises:
        BadInput: what is there is no folder of this user's, or others may write to it.
    """
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        check_private(folder)
        return False
    return True


def check_private(folder: Path) -> None:
    """Refuse a folder that somebody else could have filled.

    Raises:
        BadInput: saying what to delete.
    """
    found = folder.lstat()
    if not S_ISDIR(found.st_mode):
        raise BadInput("is no folder that an unfinished run left", file=folder, hint="Delete it, or give another name.")
    if os.name == "posix" and (found.st_uid != os.geteuid() or _is_open(folder, S_IMODE(found.st_mode))):
        raise BadInput(
            "an unfinished run is not believed where other users could have written", file=folder, hint=_HINT
        )


def remove_folder(folder: Path) -> None:
    """Take away the note and the folder, where nothing else is in it."""
    (folder / _NAME).unlink(missing_ok=True)
    folder.rmdir()


def write_note(folder: Path, asked: str, note: Note) -> None:
    """Write how far a run is, in place of what was written before.

    Args:
        folder: from ``open_folder``. asked: what the run was asked for, in full.

    Raises:
        UsageError: it cannot be written, or is larger than any note.
    """
    arrays = {name: np.asarray(array) for name, array in note.state.items()}
    size = sum(array.nbytes for array in arrays.values())
    if size > LARGEST_NOTE - 2**20:
        raise UsageError(f"{folder}: the state of {size / 2**30:.1f} GB is too large to be kept.")
    head = {
        "coast_note": VERSION,
        "asked": sha256(asked.encode()).hexdigest(),
        "blocks": note.blocks,
        "size": note.size,
        "rows": note.rows,
        "arrays": [[name, array.dtype.str, array.shape] for name, array in arrays.items()],
    }

    def write(stream: IO[bytes]) -> None:
        digest = _keyed(asked)
        for part in (json.dumps(head).encode() + b"\n", *(array.tobytes() for array in arrays.values())):
            digest.update(part)
            stream.write(part)
        stream.write(digest.digest())

    write_files({folder / _NAME: write}, binary=True)


def read_note(folder: Path, asked: str) -> Note | None:
    """Return how far an earlier run was that was asked for the same, or None where there is no note.

    Raises:
        BadInput: the note is damaged, too large, or of another version; saying what to delete.
        UsageError: it is of a run that was asked for something else.
    """
    data = _bytes_of(folder)
    if data is None:
        return None
    line, newline, _ = data[: 2**20].partition(b"\n")
    try:
        head = json.loads(line)
        version, other = head["coast_note"], head["asked"]
    except (ValueError, TypeError, KeyError, RecursionError):
        raise _damaged(folder) from None
    if version != VERSION:
        raise BadInput("the note is of another version of coast", file=folder, hint=_HINT)
    if other != sha256(asked.encode()).hexdigest():
        raise UsageError(
            f"{folder} holds what another command left unfinished; run that again, give another "
            "name, or delete the folder."
        )
    digest = _keyed(asked)
    digest.update(memoryview(data)[:-_DIGEST_BYTES])
    if digest.digest() != data[-_DIGEST_BYTES:]:
        raise _damaged(folder)
    state = dict(_arrays(head["arrays"], data, len(line) + len(newline)))
    return Note(head["blocks"], state, head["size"], head["rows"])


def _bytes_of(folder: Path) -> bytes | None:
    try:
        number = os.open(folder / _NAME, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0))
    except FileNotFoundError:
        return None
    except OSError:  # a link, or not to be read
        raise _damaged(folder) from None
    with os.fdopen(number, "rb") as stream:
        size = os.fstat(number).st_size
        if size > LARGEST_NOTE:
            raise BadInput("the note is larger than any", file=folder, hint=_HINT)
        return stream.read(size)


def _arrays(listed: list[tuple[str, str, list[int]]], data: bytes, place: int) -> Iterator[tuple[str, NDArray[Any]]]:
    for name, kind, shape in listed:
        count = prod(shape)
        yield name, np.frombuffer(data, np.dtype(kind), count, place).reshape(shape)
        place += count * np.dtype(kind).itemsize


def _keyed(asked: str) -> blake2b:
    return blake2b(key=sha256(asked.encode()).digest(), digest_size=_DIGEST_BYTES)


def _is_open(folder: Path, mode: int) -> bool:
    """Return whether others may write to a folder; where the file system keeps no modes, it cannot say."""
    if not mode & _OTHERS_MAY_WRITE:
        return False
    folder.chmod(0o700)
    keeps_modes = not folder.stat().st_mode & _OTHERS_MAY_WRITE
    folder.chmod(mode)
    return keeps_modes


def _damaged(folder: Path) -> BadInput:
    return BadInput("what an unfinished run left is damaged", file=folder, hint=_HINT)
