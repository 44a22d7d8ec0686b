"""``coast validate``: whether configurations can be used, each with all that is wrong with it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigsArgument
from coast_cli.cli.paths import WRITES

FORMATS = ("table", "json", "csv", "junit", "github")


def validate(
    configs: ConfigsArgument,
    *,
    format: Annotated[
        str | None, typer.Option("--format", "-f", metavar="FORMAT", help=", ".join(FORMATS) + ", to stdout")
    ] = None,
    output: Annotated[
        list[Path] | None,
        typer.Option("--output", "-o", metavar="FILE", help="write a file: .txt, .json, .csv or .xml (JUnit)"),
        WRITES,
    ] = None,
) -> int:
    """Check the text, keys, values and geometry of each configuration; exit 3 when one is wrong.

    Every mistake that can be told apart is a row with its line, as far as what stands before it can be read.
    """
    from coast_cli.errors import BadInput
    from coast_cli.output.answer import Answer, Row
    from coast_cli.output.provenance import provenance
    from coast_cli.output.standard_streams import to_stderr
    from coast_cli.output.write import write_answer
    from coast_cli.spec.mistakes import mistakes

    rows: list[Row] = []
    documents = []
    for config in configs:
        document, found = mistakes(config)
        if document is not None:
            documents.append(document)
            rows.append({"config": str(config), "valid": True, "line": None, "message": None})
        for error in found:
            to_stderr(f"coast: {error}")
            rows.append({"config": str(config), "valid": False, "line": error.line, "message": str(error)})
    write_answer(Answer("validate", rows, provenance(*documents)), format, output or (), formats=FORMATS)
    return 0 if all(row["valid"] for row in rows) else BadInput.exit_code
