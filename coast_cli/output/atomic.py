"""Files that appear whole or not at all: each is written in a folder of its own beside its place, then moved.

The folder is the user's alone (mode 700) and its file is new, so nobody can lead the writing elsewhere. A file that is
replaced keeps its mode and its owner. A link is followed where it belongs to the user or to the superuser.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from shutil import rmtree
from stat import S_IMODE
from tempfile import mkdtemp
from typing import IO, Any

from coast_cli.errors import UsageError
from coast_cli.signals import held

Writer = Callable[[IO[Any]], object]
_MOST_LINKS = 40  # one after another, as in Linux
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


def write_files(writers: Mapping[Path, Writer], *, binary: bool = False) -> None:
    """Write several files, all or none.

    Args:
        writers: for each path, a function that writes the file's content to the stream it is given.
        binary: give it a byte stream (a picture) instead of UTF-8 text with plain line feeds.

    Raises:
        UsageError: a path is a folder, a link of somebody else or another user's file, or cannot be written.
    """
    with ExitStack() as unfinished:
        moves = []
        for path, writer in writers.items():
            target = destination(path)
            with _naming(path):
                with held():
                    draft = _draft(target, unfinished)
                with _opened(draft, binary=binary) as stream:
                    writer(stream)
            moves.append((path, draft, target))
        with held():
            for path, draft, target in moves:
                if draft != target:
                    with _naming(path):
                        put_in_place(draft, target)


def destination(path: Path) -> Path:
    """Return where a file is to be written; asked before a run, it refuses one that cannot be, while nothing is lost.

    Raises:
        UsageError: naming the file.
    """
    with _naming(path):
        target = _followed(path)
        if target.is_dir():
            raise UsageError(f"{path}: this is a folder, not a file.")
        if not target.parent.is_dir():
            raise UsageError(f"{path}: cannot be written, as there is no folder {path.parent}.")
        if target.exists() and not os.access(target, os.W_OK):
            raise UsageError(f"{path}: cannot be written, as the file is read-only.")
        if target.is_file() and os.name == "posix" and os.geteuid() not in {0, target.stat().st_uid}:
            raise UsageError(f"{path}: cannot be replaced and keep its owner, as it belongs to another user.")
        if (target.is_file() or not target.exists()) and not os.access(target.parent, os.W_OK):
            raise UsageError(f"{path}: cannot be written, as its folder does not allow it.")
        return target


def put_in_place(draft: Path, target: Path) -> None:
    """Move a draft to its place; a file that is there already hands on its owner and its mode.

    Raises:
        OSError: it cannot be moved, or the owner cannot be kept.
    """
    if target.exists():
        old, new = target.stat(), draft.stat()
        if os.name == "posix" and (new.st_uid, new.st_gid) != (old.st_uid, old.st_gid):
            os.chown(draft, old.st_uid, old.st_gid, follow_symlinks=False)
        draft.chmod(S_IMODE(old.st_mode))
    draft.replace(target)


def check_suffix(option: str, path: Path, allowed: Collection[str]) -> None:
    """Refuse a file whose suffix does not say one of the formats, before any work is done for it.

    Raises:
        UsageError: naming the option.
    """
    if path.suffix.lower() not in allowed:
        raise UsageError(f"{option} {path}: the suffix does not say a format; allowed: {', '.join(allowed)}.")


def _draft(target: Path, unfinished: ExitStack) -> Path:
    """Return a new place beside the target, which goes with ``unfinished``; a device or a pipe is written in place."""
    if target.exists() and not target.is_file():
        return target
    folder = Path(mkdtemp(prefix=".coast-", dir=target.parent))
    unfinished.callback(rmtree, folder, ignore_errors=True)
    return folder / target.name


def _opened(draft: Path, *, binary: bool) -> IO[Any]:
    """Open a draft that must be new, or a device or pipe that is there."""
    stream = os.open(draft, os.O_WRONLY if draft.exists() else _NEW, 0o666)
    if binary:
        return os.fdopen(stream, "wb")
    return os.fdopen(stream, "w", encoding="utf-8", errors="backslashreplace", newline="\n")


def _followed(path: Path) -> Path:
    """Follow the links of a path, in its folders too, where they are the user's own or the superuser's."""
    place, ahead, links = Path.cwd(), list(path.parts)[::-1], 0
    while ahead:
        part = ahead.pop()
        step = place.parent if part == ".." else place / part
        if not step.is_symlink():
            place = step
            continue
        links += 1
        if links > _MOST_LINKS:
            raise UsageError(f"{path}: cannot be written, as its links lead in a circle.")
        if os.name == "posix" and step.lstat().st_uid not in {0, os.geteuid()}:
            raise UsageError(f"{path}: cannot be written, as the link {step} belongs to another user.")
        ahead += list(step.readlink().parts)[::-1]
    return place


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Say of which file an operating system's error is."""
    try:
        yield
    except OSError as error:
        raise UsageError(f"{path}: cannot be written ({error.strerror or error}).") from None
