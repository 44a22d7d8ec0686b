"""What an interrupted run had done, kept in a file of the working folder, from which the same command goes on.

Nothing is written before an interrupt, and a run that ends takes the file away. ``CsvStream`` is its like for runs that
write every row.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from coast_cli.errors import UsageError
from coast_cli.output.atomic import write_files

_NOTE = "note"


class Kept:
    """The state of a run after its last block.

    Args:
        name: of the run, e.g. ``tubes.explore``. identity: what it is made from; another identity has another file.

    Attributes:
        path: of the file. blocks: how many are done. state: what the next block must know.
    """

    def __init__(self, name: str, identity: str) -> None:
        self.path = Path(f"{name}.{sha256(identity.encode()).hexdigest()[:8]}.part.npz")
        self.identity = identity
        self.blocks, self.state = 0, dict[str, Any]()
        try:
            with np.load(self.path, allow_pickle=False) as saved:
                state = dict(saved)
            note = json.loads(str(state.pop(_NOTE)))
        except (OSError, ValueError, KeyError, BadZipFile):
            return
        if note.get("identity") == identity:
            self.blocks, self.state = note["blocks"], state

    def write(self, _columns: Mapping[str, Any], state: Mapping[str, NDArray[Any]]) -> None:
        """Take the state after one more block."""
        self.blocks, self.state = self.blocks + 1, dict(state)

    def keep(self) -> str:
        """Write the state to its file, and return in words what is kept."""
        note = json.dumps({"identity": self.identity, "blocks": self.blocks})
        saved: dict[str, Any] = {_NOTE: np.array(note), **self.state}
        try:
            write_files({self.path: lambda stream: np.savez(stream, **saved)}, binary=True)
        except UsageError as error:
            return f"what is done cannot be kept ({str(error).removeprefix('-o ').rstrip('.')})"
        return f"{self.path} keeps {self.blocks} blocks, and the same command goes on from there"

    def finish(self) -> None:
        """Take the file away."""
        self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Nothing is open."""
