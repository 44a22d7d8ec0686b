"""``coast plan``: what a recording could tell, before it is made."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, numbers
from coast_cli.cli.paths import READS
from coast_cli.cli.recording_options import ColumnsOption, RecordedPairOption


def plan(
    config: ConfigArgument,
    *,
    protocol: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="the planned drive: a recording without its response"), READS
    ] = None,
    drive: Annotated[
        str | None, typer.Option(metavar="LOW:TOP", help="or a load and release: stroke in mm (without tendon, N)")
    ] = None,
    x2: Annotated[str | None, typer.Option("--x2", metavar="MM,...", help="at each of these bending lengths")] = None,
    rate: Annotated[float, typer.Option(min=1e-6, help="speed of the drive, mm/s (or N/s)")] = 0.1,
    hold: Annotated[float, typer.Option(min=0.0, help="hold at the top, s")] = 0.0,
    response: Annotated[
        str, typer.Option(metavar="KIND", help="what the camera reads: curvature or bend")
    ] = "curvature",
    noise: Annotated[
        float | None, typer.Option(min=1e-9, help="noise of the response, 1/m or deg; default 0.25 1/m, or 0.5 deg")
    ] = None,
    tension_noise: Annotated[
        float | None, typer.Option(min=1e-9, metavar="N", help="tension is recorded too, with this noise")
    ] = None,
    size: Annotated[float, typer.Option(min=0.01, help="size of every effect, in noise levels of the response")] = 5.0,
    columns: ColumnsOption = None,
    pair: RecordedPairOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Say which effects a planned recording would show, and which it could not tell apart.

    Every effect is simulated at one size, and what refitted parameters or another effect could take up is taken off.
    """
    from coast_cli.diagnosis.joint.planning import plan as plan_of
    from coast_cli.diagnosis.joint.planning import sweep
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.load import load_config
    from coast_cli.units import MILLIMETRE

    if (protocol is None) == (drive is None):
        raise UsageError("give either --protocol FILE.csv or --drive LOW:TOP with --x2.")
    lengths = [] if x2 is None else numbers(x2, "--x2")
    document = load_config(config)
    if protocol is not None:
        from coast_cli.recordings.mapping import mapping_of

        if len(lengths) > 1:
            raise UsageError("--x2: one bending length goes with --protocol, for a file without that column.")
        length = lengths[0] if lengths else None
        found = plan_of(
            document,
            protocol,
            columns=mapping_of(columns),
            pair=pair,
            bending_length_mm=length,
            noise=noise,
            tension_noise=tension_noise,
            size=size,
        )
    else:
        unit = 1.0 if document.tendon is None else MILLIMETRE
        runs = sweep(
            document,
            _range(str(drive), unit),
            [one * MILLIMETRE for one in lengths],
            rate=rate * unit,
            hold=hold,
            response=response,
            pair=pair,
            records_tension=tension_noise is not None,
        )
        found = plan_of(document, runs, noise=noise, tension_noise=tension_noise, size=size)
    options = {"size": size, "noise": noise, "tension_noise": tension_noise, "drive": drive, "x2": x2}
    origin = provenance(document, options={name: value for name, value in options.items() if value is not None})
    write_answer(Answer("plan", found.rows, origin, found.notes), format, output or ())


def _range(text: str, unit: float) -> tuple[float, float]:
    """Return the ends of ``LOW:TOP`` in SI.

    Raises:
        UsageError: they are no numbers.
    """
    from coast_cli.diagnosis.joint.planning import DRIVES
    from coast_cli.errors import UsageError

    low, colon, top = text.partition(":")
    try:
        ends = float(low) * unit, float(top) * unit
    except ValueError:
        colon = ""
    if not colon:
        raise UsageError(f"--drive {text}: {DRIVES}.")
    return ends
