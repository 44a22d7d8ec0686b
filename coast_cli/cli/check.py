"""``coast check``: designs held to their limits, for a terminal or a CI system."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigsArgument, PairOption
from coast_cli.cli.paths import WRITES

FORMATS = ("table", "json", "csv", "junit", "github")


def check(
    configs: ConfigsArgument,
    *,
    pair: PairOption = None,
    format: Annotated[
        str | None, typer.Option("--format", "-f", metavar="FORMAT", help=", ".join(FORMATS) + ", to stdout")
    ] = None,
    output: Annotated[
        list[Path] | None,
        typer.Option("--output", "-o", metavar="FILE", help="write a file: .txt, .json, .csv or .xml (JUnit)"),
        WRITES,
    ] = None,
) -> int:
    """Hold a pair of each configuration to its [checks]; exit 1 when a limit does not hold.

    A configuration that cannot be checked is a row with its reason, and the others are checked all the same; the exit code
    is then 3 for a wrong input, or 4 where a solver did not converge.
    """
    from coast_cli.design.checks import check_design, limits_told, refused
    from coast_cli.design.loading import acting_on_load
    from coast_cli.errors import BadInput, NotConverged
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import say, write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config

    documents, rows, codes, notes = [], [], {0}, list[str]()
    for config in configs:
        try:
            document = load_config(config)
            design = build(document)
            found = check_design(design, pair)
        except (BadInput, NotConverged) as error:
            say(str(error))
            codes.add(error.exit_code)
            rows.append(refused(str(config), error))
            continue
        documents.append(document)
        rows += found
        codes.add(0 if all(row["passed"] for row in found) else 1)
        notes += [*design.notes, *design.uncorrected_joint, *limits_told(document)]
        notes += acting_on_load(design.effects)[1]
    origin = provenance(*documents, options=None if pair is None else {"pair": pair})
    write_answer(Answer("check", rows, origin, tuple(notes)), format, output or (), formats=FORMATS)
    return BadInput.exit_code if BadInput.exit_code in codes else max(codes)
