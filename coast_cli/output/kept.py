"""What an interrupted run had done, kept in a folder of the working folder, from which the same command goes on.

Nothing is written before an interrupt, and a run that ends takes the folder away. ``CsvStream`` is its like for runs that
write every row.
"""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from coast_cli.errors import UsageError
from coast_cli.output.checkpoint import Arrays, Note, check_private, open_folder, read_note, remove_folder, write_note


class Kept:
    """The state of a run after its last block.

    Args:
        name: of the run, e.g. ``tubes.explore``. identity: what it is made from; another identity has another folder.

    Attributes:
        path: of the folder. blocks: how many are done. state: what the next block must know.

    Raises:
        BadInput: what an earlier run left is damaged, or somebody else's.
    """

    def __init__(self, name: str, identity: str) -> None:
        self.path = Path(f"{name}.{sha256(identity.encode()).hexdigest()[:8]}.part")
        self.identity = identity
        self.blocks, self.state = 0, dict[str, Any]()
        if self.path.exists() or self.path.is_symlink():
            check_private(self.path)
            note = read_note(self.path, identity) or Note()
            self.blocks, self.state = note.blocks, dict(note.state)

    def write(self, _columns: Mapping[str, Any], state: Arrays) -> None:
        """Take the state after one more block."""
        self.blocks, self.state = self.blocks + 1, dict(state)

    def keep(self) -> str:
        """Write the state to its folder, and return in words what is kept."""
        try:
            open_folder(self.path)
            write_note(self.path, self.identity, Note(self.blocks, self.state))
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
