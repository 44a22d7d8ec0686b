"""``coast init``: a commented configuration to start from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from coast_cli.cli.paths import Writes


def _files(given: Mapping[str, Any]) -> list[Path]:
    return [] if str(given["file"]) == "-" else [given["file"]]


def init(
    file: Annotated[Path, typer.Argument(help="where to write it; - for stdout"), Writes(_files)] = Path("tubes.toml"),
    *,
    force: Annotated[bool, typer.Option("--force", help="replace a file that is there")] = False,
) -> None:
    """Write the commented reference configuration; every command runs on it as it is."""
    from coast_cli.errors import UsageError
    from coast_cli.output.atomic import write_files
    from coast_cli.output.standard_streams import to_stdout
    from coast_cli.output.write import say
    from coast_cli.spec.load import REFERENCE, read_text

    text = read_text(REFERENCE)
    if str(file) == "-":
        to_stdout(lambda stream: stream.write(text))
        return
    if file.is_file() and not force:
        raise UsageError(f"{file}: there is such a file already; name another, or give --force to replace it.")
    write_files({file: lambda stream: stream.write(text)})
    say(f"wrote {file}; next: coast rank-pairs {file}")
