"""A long CSV written block by block: interrupted, it keeps what is done, and a rerun goes on from there.

Until it is whole its rows stand in a folder with ``.part`` at the end of its name, beside a note that says what they are
made from, how many of them count, and what the next block must know. The folder goes when the file has its name.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Mapping, Sequence
from hashlib import sha256
from io import StringIO
from pathlib import Path
from typing import IO, Any

from coast_cli.errors import BadInput, CoastError, UsageError
from coast_cli.output.atomic import destination, put_in_place
from coast_cli.output.checkpoint import Arrays, Note, check_private, open_folder, read_note, remove_folder, write_note
from coast_cli.output.csv import cell
from coast_cli.signals import held

_READ_BYTES = 2**20


class CsvStream:
    """A CSV file that grows by blocks.

    Args:
        path: of the finished file. identity: what it is made from, which the same command finds again.
        overwrite: whether a finished file, and what another command left unfinished, may be replaced.

    Attributes:
        blocks: how many are written already. state: what was saved with the last of them.

    Raises:
        UsageError: the file exists, another command left it unfinished, or it cannot be written.
        BadInput: what an earlier run left is damaged, or somebody else's.
    """

    def __init__(self, path: Path, identity: str, *, overwrite: bool) -> None:
        if path.suffix.lower() != ".csv":
            raise UsageError(f"{path}: pairs are streamed as CSV; allowed: a name that ends in .csv.")
        if path.exists() and not overwrite:
            raise UsageError(f"{path}: the file exists; give another name, or --overwrite.")
        self.path, self.identity = path, identity
        self._target = destination(path)
        self.part = self._target.with_name(f"{self._target.name}.part")
        self._rows, self._digest = self.part / "rows.csv", sha256()
        self.blocks, self.state = 0, dict[str, Any]()
        try:
            open_folder(self.part)
            self._stream = _opened(self._rows)
            self._lock()
            self._resume(overwrite=overwrite)
            self._save(self.blocks, self.state)
        except OSError as error:
            raise UsageError(f"{path}: cannot be written ({error.strerror or error}).") from None

    def _lock(self) -> None:
        """Keep other runs off the file until this one ends; what gives no locks (Windows) has to do without."""
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            taken = not os.path.samestat(os.fstat(self._stream.fileno()), self._rows.stat())
        except (BlockingIOError, FileNotFoundError):  # the other run may have finished the file in between
            taken = True
        if taken:
            self._stream.close()
            raise UsageError(f"{self.path}: another run is writing this file; wait for it, or give another name.")

    def _resume(self, *, overwrite: bool) -> None:
        """Go to where an earlier run was, or to the beginning."""
        try:
            note = self._found()
        except CoastError:
            if not overwrite:
                self._stream.close()
                raise
            note = Note()
            self._digest = sha256()
        self.blocks, self.state = note.blocks, dict(note.state)
        os.truncate(self._rows, note.size)
        self._stream.seek(note.size)

    def _found(self) -> Note:
        size, note = self._rows.stat().st_size, read_note(self.part, self.identity)
        if note is None and size == 0:
            return Note()
        if note is not None and size >= note.size:
            for place in range(0, note.size, _READ_BYTES):
                self._digest.update(self._stream.read(min(_READ_BYTES, note.size - place)))
            if self._digest.hexdigest() == note.rows:
                return note
        raise BadInput(
            "the rows are not those that were written",
            file=self.part,
            hint="Delete the folder to begin anew, or --overwrite.",
        )

    def _save(self, blocks: int, state: Arrays) -> None:
        """Write how much of the rows counts, and what the next block must know."""
        write_note(self.part, self.identity, Note(blocks, state, self._stream.tell(), self._digest.hexdigest()))

    def write(self, columns: Mapping[str, Any], state: Arrays) -> None:
        """Append a block of rows and save what goes with it.

        Raises:
            UsageError: the disk is full, or gone; what was written before stays.
        """
        text = StringIO()
        writer = csv.writer(text, lineterminator="\n")
        if columns:
            if self._stream.tell() == 0:
                writer.writerow(columns)
            writer.writerows(zip(*(_texts(column) for column in columns.values()), strict=True))
        block = text.getvalue().encode()
        try:
            self._stream.write(block)
            self._stream.flush()
            self._digest.update(block)
            with held():  # no signal between the note and the count
                self._save(self.blocks + 1, state)
                self.blocks += 1
        except (OSError, UsageError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise UsageError(
                f"{self.path}: cannot be written ({reason}); {self.part.name} keeps what is done, "
                "so make room and run the same command again."
            ) from None

    def keep(self) -> str:
        """Return in words what is kept already."""
        return f"{self.part} keeps {self.blocks} blocks, and the same command goes on from there"

    def finish(self) -> None:
        """Give the file its name."""
        self._stream.close()
        with held():
            put_in_place(self._rows, self._target)
            remove_folder(self.part)

    def close(self) -> None:
        """Leave the file as it is, to be gone on with later; without a block, leave none."""
        try:
            self._stream.close()
        except OSError:
            return  # the disk is full: what counts is on it already
        if self.blocks == 0 and self.part.exists():
            check_private(self.part)
            self._rows.unlink(missing_ok=True)
            remove_folder(self.part)


def _opened(rows: Path) -> IO[bytes]:
    """Open the rows to be read and gone on with; a link in their place is refused."""
    number = os.open(rows, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0), 0o666)
    return os.fdopen(number, "r+b")


def _texts(column: Any) -> Sequence[Any]:  # noqa: ANN401
    """Return a column as what stands in its cells."""
    values: list[Any] = column.tolist()
    return values if column.dtype.kind in "iuf" else [cell(value) for value in values]
