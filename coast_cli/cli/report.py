"""``coast report``: everything that is known of a design, on one page to keep, print or send."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, PairOption, numbers
from coast_cli.cli.paths import READS, WRITES
from coast_cli.cli.recording_options import ColumnsOption, HoldOutOption


def report(
    config: ConfigArgument,
    recordings: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[RECORDING...]", help="recordings (CSV) to diagnose", show_default=False),
        READS,
    ] = None,
    *,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="the page, .html or .pdf; or the drawing of the pair alone, .svg"
        ),
        WRITES,
    ],
    pair: PairOption = None,
    kappa: Annotated[str, typer.Option(help="curvatures of the stroke table, 1/m: 20 or 20,30 or 0:40:5")] = "0:40:5",
    x2: Annotated[
        str | None,
        typer.Option(
            "--x2",
            metavar="MM,...",
            help="bending lengths of the stroke table, mm, as for --kappa; one alone is also that of recordings without "
            "such a column; default: 20,30,40, or half and all of shorter tubes",
        ),
    ] = None,
    samples: Annotated[
        int, typer.Option(min=0, max=1_000_000, help="random samples over the tolerances; 0 leaves them out")
    ] = 10_000,
    seed: Annotated[int, typer.Option(min=0, help="of the random numbers")] = 0,
    columns: ColumnsOption = None,
    hold_out: HoldOutOption = None,
) -> None:
    """Write one page: inputs and what is assumed, ranking, shapes, strokes, tolerances, checks, diagnosis.

    The page needs no network and no script, and prints well. A report is not a verdict: a failing check or a mismatch
    stands on the page and the exit code is 0; `coast check` and `coast diagnose --fail-on-mismatch` exit with 1. A PDF is
    printed by chromium, google-chrome or weasyprint.
    """
    from coast_cli.output.picture import can_draw
    from coast_cli.output.report import NO_PICTURES
    from coast_cli.output.report import report as write_report
    from coast_cli.output.write import say
    from coast_cli.recordings.mapping import mapping_of
    from coast_cli.recordings.read import read_recordings
    from coast_cli.spec.load import load_config
    from coast_cli.units import MILLIMETRE

    lengths = None if x2 is None else numbers(x2, "--x2")
    document = load_config(config)
    read = None
    if recordings:
        single = lengths[0] if lengths is not None and len(lengths) == 1 else None
        read = read_recordings(recordings, document, columns=mapping_of(columns), pair=pair, bending_length_mm=single)
    write_report(
        document,
        output,
        read,
        pair=pair,
        curvatures=numbers(kappa, "--kappa"),
        bending_lengths=None if lengths is None else [length * MILLIMETRE for length in lengths],
        samples=samples,
        seed=seed,
        hold_out=hold_out or (),
    )
    if not can_draw() and output.suffix.lower() != ".svg":
        say(f"note: {NO_PICTURES}")
