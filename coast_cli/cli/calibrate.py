"""``coast calibrate``: fit the model's own parameters to recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption
from coast_cli.cli.paths import WRITES
from coast_cli.cli.recording_options import (
    BendingLengthOption,
    ColumnsOption,
    RecordedPairOption,
    RecordingsArgument,
)


def calibrate(
    config: ConfigArgument,
    recordings: RecordingsArgument,
    *,
    fit: Annotated[
        str | None,
        typer.Option(metavar="NAME,...", help="parameters; default: those with { value, min, max }, else the usual"),
    ] = None,
    fix: Annotated[
        list[str] | None,
        typer.Option("--fix", metavar="NAME=VALUE", help="hold a parameter at a value, in its unit; repeatable"),
    ] = None,
    weight: Annotated[
        list[str] | None,
        typer.Option("--weight", metavar="RUN=NUMBER", help="weight of a run's squares, else 1; repeatable"),
    ] = None,
    hold_out: Annotated[
        list[str] | None,
        typer.Option("--hold-out", metavar="RUN", help="a run that is not fitted, repeatable; `each`: all in turn"),
    ] = None,
    columns: ColumnsOption = None,
    pair: RecordedPairOption = None,
    x2: BendingLengthOption = None,
    format: FormatOption = None,
    output: Annotated[
        list[Path] | None,
        typer.Option("--output", "-o", metavar="FILE", help="write the configuration (.toml) or the rows; repeatable"),
        WRITES,
    ] = None,
) -> int:
    """Print fitted parameters with intervals of 90 %, and what the recordings cannot tell; -o writes the configuration.

    Parameters: youngs_modulus_gpa, notch_friction, deadband_mm, pulley_friction, wrap_angle_rad, tendon_youngs_modulus_gpa,
    tendon_length_mm; of a transmission ratio, zero_mm, load_ratio. Bounds are those of { value, min, max } in the
    configuration; bounds that are assumed are printed.
    """
    from coast_cli.diagnosis.joint.calibration import calibrate as calibration_of
    from coast_cli.diagnosis.model_file import calibrated_text
    from coast_cli.output.answer import Answer
    from coast_cli.output.atomic import write_files
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.recordings.mapping import mapping_of
    from coast_cli.recordings.read import read_recordings
    from coast_cli.spec.load import load_config

    document = load_config(config)
    read = read_recordings(recordings, document, columns=mapping_of(columns), pair=pair, bending_length_mm=x2)
    names = [name.strip() for name in fit.split(",")] if fit else []
    fixed, weights = _numbers("--fix", fix), _numbers("--weight", weight)
    calibration = calibration_of(document, read, names, hold_out or (), fixed=fixed, weights=weights)
    models = [path for path in output or () if path.suffix.lower() == ".toml"]
    if models:
        text = calibrated_text(document, calibration, read)
        write_files({path: lambda stream: stream.write(text) for path in models})
    options: dict[str, object] = {"fit": names, "hold_out": list(hold_out or ()), **({"fix": fixed} if fixed else {})}
    options |= {"weight": weights} if weights else {}
    origin = provenance(document, recordings=read.sources, options=options)
    answer = Answer("calibrate", calibration.rows(), origin, (*read.notes, *calibration.notes))
    tables = [path for path in output or () if path not in models]
    write_answer(answer, format or (None if tables else "table"), tables)
    return 0 if calibration.whole.converged else 4


def _numbers(option: str, given: list[str] | None) -> dict[str, float]:
    """Return numbers by name from ``NAME=NUMBER``; the last sign counts, as a run's name may have others.

    Raises:
        UsageError: one is none, or a name stands twice.
    """
    from coast_cli.errors import UsageError

    found: dict[str, float] = {}
    for text in given or ():
        name, sign, value = (part.strip() for part in text.rpartition("="))
        try:
            number = float(value)
        except ValueError:
            sign = ""
        if not (sign and name) or name in found:
            raise UsageError(f"{option} {text}: not understood; allowed: NAME=NUMBER, each name once.")
        found[name] = number
    return found
