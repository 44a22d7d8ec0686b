"""Send an answer where the user wants it: to stdout in one format, and to files by their suffix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from coast_cli.errors import UsageError, printable
from coast_cli.output.answer import Answer
from coast_cli.output.atomic import Writer, write_files
from coast_cli.output.standard_streams import to_stderr, to_stdout
from coast_cli.output.view import VIEW, stdout_width

FORMATS = ("table", "json", "csv", "markdown", "latex")
SUFFIXES = {
    ".txt": "table",
    ".json": "json",
    ".csv": "csv",
    ".md": "markdown",
    ".tex": "latex",
    ".xml": "junit",
}


def write_answer(
    answer: Answer,
    format: str | None,
    outputs: Sequence[Path] = (),
    *,
    formats: Sequence[str] = FORMATS,
    beside: Mapping[Path, Writer] | None = None,
) -> None:
    """Write the answer to every file of ``outputs``, and to stdout where a format is named or no file is.

    Args:
        answer: what the command found.
        format: for stdout; None is "table", or nothing where there are ``outputs``.
        outputs: files; the suffix says the format. All of them appear, or none.
        formats: what this command can write.
        beside: more files that the command writes, which appear with the others or not at all.

    Raises:
        UsageError: an unknown format or suffix, or a file that cannot be written.
        NotConverged: a NaN or an infinity in the answer.
    """
    if format is not None and format not in formats:
        raise UsageError(f"--format {format}: not a format of `coast {answer.command}`; allowed: {', '.join(formats)}.")
    renders = {path: _renderer(format_of(path, formats)) for path in outputs}
    answer.check_finite()
    answer = VIEW.get().of(answer)
    beside = beside or {}
    write_files({path: partial(render, answer) for path, render in renders.items()} | dict(beside))
    for note in answer.notes:
        say(f"note: {note}")
    if format is not None or not (outputs or beside):
        to_stdout(partial(_on_stdout(format or "table"), answer))


def say(text: str) -> None:
    """Tell the user something that is not data, on stderr; nothing where quiet is asked for."""
    if not VIEW.get().quiet:
        to_stderr(f"coast: {printable(text)}")


def format_of(path: Path, formats: Sequence[str] = FORMATS) -> str:
    """Return the format that a file's suffix says.

    Raises:
        UsageError: it says none of ``formats``.
    """
    known = {suffix: name for suffix, name in SUFFIXES.items() if name in formats}
    if path.suffix.lower() not in known:
        hint = " A spreadsheet opens .csv." if path.suffix.lower() in {".xlsx", ".xls", ".ods"} else ""
        raise UsageError(f"-o {path}: the suffix does not say a format; allowed: {', '.join(known)}.{hint}")
    return known[path.suffix.lower()]


def _on_stdout(format: str) -> Any:  # noqa: ANN401
    """Return the renderer of a format, a table as wide as the terminal."""
    if format != "table":
        return _renderer(format)
    view = VIEW.get()
    return partial(_renderer(format), width=None if view.wide else stdout_width(), chosen=bool(view.show))


def _renderer(format: str) -> Any:  # noqa: ANN401
    return import_module(f"coast_cli.output.{format}").render
