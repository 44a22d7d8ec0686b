"""A long CSV written block by block: interrupted, it keeps what is done, and a rerun goes on from there.

Until it is whole the file has ``.part`` at its end, with a ``.part.npz`` beside it that says what it is made from, how
many blocks and bytes of it count, and what the next block must know. Both end in the finished file.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from coast_cli.errors import UsageError
from coast_cli.output.atomic import write_files

_NOTE = "note"


class CsvStream:
    """A CSV file that grows by blocks.

    Args:
        path: of the finished file. identity: what it is made from, which the same command finds again.
        overwrite: whether a finished file, and what another command left unfinished, may be replaced.

    Attributes:
        blocks: how many are written already. state: what was saved with the last of them.

    Raises:
        UsageError: the file exists, another command left it unfinished, or it cannot be written.
    """

    def __init__(self, path: Path, identity: str, *, overwrite: bool) -> None:
        if path.suffix.lower() != ".csv":
            raise UsageError(f"{path}: pairs are streamed as CSV; allowed: a name that ends in .csv.")
        if path.exists() and not overwrite:
            raise UsageError(f"{path}: the file exists; give another name, or --overwrite.")
        self.path, self.identity = path, identity
        self.part, self.note = (path.with_name(f"{path.name}.part{suffix}") for suffix in ("", ".npz"))
        self.blocks, self.state = 0, dict[str, Any]()
        try:
            self._stream: IO[str] = self.part.open("a", encoding="utf-8", newline="")
            self._lock()
            size = self._resume(overwrite=overwrite)
            os.truncate(self.part, size)
            self._stream.seek(size)
            self._save(self.state)
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
            taken = not os.path.samestat(os.fstat(self._stream.fileno()), self.part.stat())
        except (BlockingIOError, FileNotFoundError):  # the other run may have finished the file in between
            taken = True
        if taken:
            self._stream.close()
            raise UsageError(f"{self.path}: another run is writing this file; wait for it, or give another name.")

    def _resume(self, *, overwrite: bool) -> int:
        """Return how many bytes of an earlier run count."""
        size = self.part.stat().st_size
        try:
            with np.load(self.note, allow_pickle=False) as saved:
                state = dict(saved)
            note = json.loads(str(state.pop(_NOTE)))
        except (OSError, ValueError, KeyError, BadZipFile):
            note = {}
        if note.get("identity") == self.identity:
            if size < note["bytes"]:
                return 0
            self.blocks, self.state = note["blocks"], state
            return int(note["bytes"])
        if size and not overwrite:
            self._stream.close()
            raise UsageError(
                f"{self.path}: {self.part.name} holds what another command left unfinished; run that again, "
                "give another name, or --overwrite."
            )
        return 0

    def _save(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Write what the file is made from, how much of it counts, and what the next block must know."""
        note = json.dumps({"identity": self.identity, "blocks": self.blocks, "bytes": self._stream.tell()})
        saved: dict[str, Any] = {_NOTE: np.array(note), **state}
        write_files({self.note: lambda stream: np.savez(stream, **saved)}, binary=True)

    def write(self, columns: Mapping[str, Any], state: Mapping[str, NDArray[Any]]) -> None:
        """Append a block of rows and save what goes with it.

        Raises:
            UsageError: the disk is full, or gone; what was written before stays.
        """
        writer = csv.writer(self._stream, lineterminator="\n")
        try:
            if columns:
                if self._stream.tell() == 0:
                    writer.writerow(columns)
                writer.writerows(zip(*(_texts(column) for column in columns.values()), strict=True))
            self._stream.flush()
            self.blocks += 1
            self._save(state)
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
        self.part.replace(self.path)
        self.note.unlink(missing_ok=True)

    def close(self) -> None:
        """Leave the file as it is, to be gone on with later; without a block, leave none."""
        try:
            self._stream.close()
        except OSError:
            return  # the disk is full: what counts is on it already
        if self.blocks == 0:
            self.part.unlink(missing_ok=True)
            self.note.unlink(missing_ok=True)


def _texts(column: Any) -> Sequence[Any]:  # noqa: ANN401
    """Return a column as Python values, truth as JSON has it."""
    values: list[Any] = column.tolist()
    return ["true" if value else "false" for value in values] if column.dtype == bool else values
