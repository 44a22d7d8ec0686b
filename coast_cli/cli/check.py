"""``coast check``: designs held to their limits, for a terminal or a CI system."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigsArgument
from coast_cli.cli.paths import WRITES

FORMATS = ("table", "json", "csv", "junit", "github")


def check(
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
    """Hold the joint's pair of each configuration to its [checks]; exit 1 when a limit does not hold."""
    from coast_cli.design.checks import check_design
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config

    documents = [load_config(config) for config in configs]
    designs = [build(document) for document in documents]
    rows = [row for design in designs for row in check_design(design)]
    notes = tuple(note for design in designs for note in (*design.notes, *design.uncorrected_joint))
    answer = Answer("check", rows, provenance(*documents), notes)
    write_answer(answer, format, output or (), formats=FORMATS)
    return 0 if all(row["passed"] for row in rows) else 1
