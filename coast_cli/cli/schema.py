"""``coast schema``: the JSON Schema of a configuration, for editors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.paths import WRITES


def schema(
    *,
    output: Annotated[
        list[Path] | None, typer.Option("--output", "-o", help="write it to a .json file"), WRITES
    ] = None,
) -> None:
    """Print the JSON Schema (draft 2020-12) of a configuration; editors complete and check TOML with it."""
    import json

    from coast_cli.output.atomic import write_files
    from coast_cli.output.standard_streams import to_stdout
    from coast_cli.spec.schema import config_schema

    text = json.dumps(config_schema(), indent=2) + "\n"
    if output:
        write_files({path: lambda stream: stream.write(text) for path in output})
    else:
        to_stdout(lambda stream: stream.write(text))
