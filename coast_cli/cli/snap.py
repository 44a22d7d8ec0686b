"""``coast snap``: which pairs would jump, by what, at which stroke and how far."""

from __future__ import annotations

from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption


def snap(
    config: ConfigArgument,
    *,
    x2: Annotated[
        float | None, typer.Option("--x2", help="bending length, mm; else that of checks.max_stroke_mm")
    ] = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Forecast for every pair whether it jumps while the tendon pulls it, by what, at which stroke and how far.

    Forecasts from the energy of ideal segments: no robot has confirmed them.
    """
    from coast_cli.design.snapping import FORECAST, snap_rows
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config
    from coast_cli.units import MILLIMETRE

    document = load_config(config)
    design = build(document)
    longest = min((tube.length for tube in (*design.outer, *design.middle)), default=0.0) / MILLIMETRE
    if x2 is not None and not 0.0 < x2 <= longest:
        raise UsageError(f"--x2 {x2:g}: allowed: above 0 and at most the notched length, {longest:g} mm.")
    rows = snap_rows(design, None if x2 is None else x2 * MILLIMETRE)
    write_answer(Answer("snap", rows, provenance(document), (*design.notes, FORECAST)), format, output or ())
