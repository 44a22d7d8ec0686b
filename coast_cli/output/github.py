"""GitHub annotations of checks: one workflow command a failed limit, at its line of the configuration."""

from __future__ import annotations

from typing import IO

from coast_cli.output.answer import Answer
from coast_cli.output.junit import failed, reason_of


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the failed rows of ``coast check`` or ``coast validate`` as ``::error``, or one ``::notice`` where there are none."""
    title = f"coast {answer.command}"
    wrong = [row for row in answer.rows if failed(row)]
    for row in wrong:
        place = f"file={_property(str(row['config']))},line={row['line'] or 1},title={title}"
        stream.write(f"::error {place}::{_data(reason_of(row))}\n")
    if not wrong:
        held = "limits hold" if answer.command == "check" else "configurations can be used"
        stream.write(f"::notice title={title}::{len(answer.rows)} {held}\n")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
