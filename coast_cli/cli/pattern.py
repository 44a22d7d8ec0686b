"""``coast pattern``: where the notches of a tube are on its unrolled skin, and a drawing for the laser."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption
from coast_cli.cli.paths import WRITES

DRAWING = ".dxf"


def _to_write(paths: list[Path] | None) -> list[Path] | None:
    """Refuse files whose suffix says no format before any work is done for them."""
    from coast_cli.output.write import format_of

    for path in paths or ():
        if path.suffix.lower() != DRAWING:
            format_of(path)
    return paths


def pattern(
    config: ConfigArgument,
    *,
    tube: Annotated[list[str], typer.Option(metavar="NAME", help="a tube of the configuration; repeatable")],
    kerf: Annotated[
        float, typer.Option(metavar="MM", min=0.0, help="width that the laser burns; its path lies half of it inside")
    ] = 0.0,
    format: FormatOption = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="write a file: .txt, .json, .csv, .md or .tex; .dxf draws the laser's paths (R12, mm); repeatable",
            callback=_to_write,
        ),
        WRITES,
    ] = None,
) -> None:
    """Print each notch on the unrolled outer skin of tubes, from the clamp; -o FILE.dxf draws it for the laser."""
    from math import isfinite

    from coast_cli.design.pattern import notch_pattern, pattern_columns
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer, Columns
    from coast_cli.output.dxf import write_dxf
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config
    from coast_cli.units import MILLIMETRE

    if not isfinite(kerf):
        raise UsageError(f"--kerf {kerf}: allowed: a length in mm.")
    document = load_config(config)
    design = build(document)
    patterns = [notch_pattern(design.tube(name), kerf * MILLIMETRE) for name in tube]
    drawings = [path for path in output or () if path.suffix.lower() == DRAWING]
    pages = [path for path in output or () if path not in drawings]
    origin = provenance(document, options={"kerf_mm": kerf})
    answer = Answer("pattern", Columns(pattern_columns(patterns)), origin, design.notes)
    write_answer(answer, format, pages, beside={path: partial(write_dxf, patterns) for path in drawings})
