"""GitHub annotations of checks: one workflow command a failed limit, at its line of the configuration."""

from __future__ import annotations

from typing import IO

from coast_cli.output.answer import Answer
from coast_cli.output.junit import sentence


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the failed rows of ``coast check`` as ``::error`` commands, or one ``::notice`` where all passed."""
    failed = [row for row in answer.rows if not row["passed"]]
    for row in failed:
        place = f"file={_property(str(row['config']))},line={row['line'] or 1},title=coast check"
        stream.write(f"::error {place}::{_data(sentence(row))}\n")
    if not failed:
        stream.write(f"::notice title=coast check::{len(answer.rows)} limits hold\n")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
