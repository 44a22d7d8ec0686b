"""What an interrupted run had done, kept in a folder of the working folder, from which the same command goes on.

Nothing is written before an interrupt, and a run that ends takes the folder away. ``CsvStream`` is its like for runs that
write every row.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any

from coast_cli.design.work import WorkerLost
from coast_cli.errors import UsageError
from coast_cli.output.checkpoint import Arrays, Note, check_private, open_folder, read_note, remove_folder, write_note
from coast_cli.output.stream import CsvStream
from coast_cli.output.write import say
from coast_cli.signals import held


class Kept:
    """The state of a run after its last block.

    Args:
        name: of the run, e.g. ``tubes.explore``. identity: what it is made from; another identity has another folder.

    Attributes:
        path: of the folder.

    Raises:
        BadInput: what an earlier run left is damaged, or somebody else's.
    """

    def __init__(self, name: str, identity: str) -> None:
        self.path = Path(f"{name}.{sha256(identity.encode()).hexdigest()[:8]}.part")
        self.identity = identity
        self._note = Note()  # one object, so that no signal comes between its parts
        if self.path.exists() or self.path.is_symlink():
            check_private(self.path)
            self._note = read_note(self.path, identity) or Note()

    @property
    def blocks(self) -> int:
        """How many blocks are done."""
        return self._note.blocks

    @property
    def state(self) -> Arrays:
        """What the next block must know."""
        return self._note.state

    def write(self, _columns: Mapping[str, Any], state: Arrays) -> None:
        """Take the state after one more block."""
        self._note = Note(self.blocks + 1, dict(state))

    def keep(self) -> str:
        """Write the state to its folder, and return in words what is kept."""
        try:
            open_folder(self.path)
            write_note(self.path, self.identity, self._note)
        except (OSError, UsageError) as error:
            reason = f"{self.path}: {error.strerror}" if isinstance(error, OSError) else str(error).rstrip(".")
            return f"what is done cannot be kept ({reason})"
        return f"{self.path} keeps {self.blocks} blocks, and the same command goes on from there"

    def finish(self) -> None:
        """Take the folder away."""
        if self.path.exists():
            remove_folder(self.path)

    def close(self) -> None:
        """Nothing is open."""


@contextmanager
def kept_when_stopped(run: Kept | CsvStream) -> Iterator[None]:
    """Keep what is done, and say where, when a signal, a lost worker or a full disk ends the block."""
    try:
        yield
    except (KeyboardInterrupt, WorkerLost, UsageError):
        with held():
            if run.blocks:
                say(f"interrupted: {run.keep()}.")
        raise
