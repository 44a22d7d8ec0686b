"""Files that appear whole or not at all: each is written beside its place under another name, then moved."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

from coast_cli.errors import UsageError

Writer = Callable[[IO[Any]], object]


def write_files(writers: Mapping[Path, Writer], *, binary: bool = False) -> None:
    """Write several files, all or none.

    Args:
        writers: for each path, a function that writes the file's content to the stream it is given.
        binary: give it a byte stream (a picture) instead of UTF-8 text with plain line feeds.

    Raises:
        UsageError: a path is a folder, or its folder is not there or cannot be written.
    """
    with ExitStack() as unfinished:
        moves = []
        for path, writer in writers.items():
            target = path.resolve()  # a link stays a link
            in_place = target.exists() and not target.is_file() and not target.is_dir()  # /dev/null, a pipe
            draft = target if in_place else target.with_name(f".{target.name}.{os.getpid()}.part")
            if target.is_dir():
                raise UsageError(f"-o {path}: this is a folder, not a file.")
            if not in_place:
                unfinished.callback(draft.unlink, missing_ok=True)
            try:
                with draft.open("wb") if binary else draft.open("w", encoding="utf-8", newline="\n") as stream:
                    writer(stream)
            except OSError as error:
                raise UsageError(f"-o {path}: cannot be written ({error.strerror or error}).") from None
            moves.append((draft, target))
        for draft, target in moves:
            if draft != target:
                draft.replace(target)


def check_suffix(option: str, path: Path, allowed: Collection[str]) -> None:
    """Refuse a file whose suffix does not say one of the formats, before any work is done for it.

    Raises:
        UsageError: naming the option.
    """
    if path.suffix.lower() not in allowed:
        raise UsageError(f"{option} {path}: the suffix does not say a format; allowed: {', '.join(allowed)}.")
    if path.is_dir():
        raise UsageError(f"{option} {path}: this is a folder, not a file.")


def check_folder(path: Path) -> None:
    """Refuse a file whose folder is not there or takes no new file, before any work is done for it.

    Raises:
        UsageError: naming the file.
    """
    folder = path.resolve().parent
    if not folder.is_dir():
        raise UsageError(f"{path}: cannot be written, as there is no folder {path.parent}.")
    if not os.access(folder, os.W_OK) and not path.exists():
        raise UsageError(f"{path}: cannot be written, as its folder does not allow it.")
