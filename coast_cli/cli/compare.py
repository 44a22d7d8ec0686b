"""``coast compare``: the errors of models on recordings they were not fitted to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption
from coast_cli.cli.paths import READS, WRITES
from coast_cli.cli.recording_options import (
    BendingLengthOption,
    ColumnsOption,
    FromOption,
    NoiseOption,
    PlotOption,
    RecordedPairOption,
    RecordingsArgument,
    ToOption,
)


def compare(
    config: ConfigArgument,
    recordings: RecordingsArgument,
    *,
    model: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FILE.toml",
            help="a model with corrections, as --save-model wrote it; repeatable: several stand in one table",
        ),
        READS,
    ] = None,
    columns: ColumnsOption = None,
    pair: RecordedPairOption = None,
    x2: BendingLengthOption = None,
    begin: FromOption = None,
    end: ToOption = None,
    noise: NoiseOption = None,
    residuals: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="write what is recorded, predicted and left in each row, with its time"),
        WRITES,
    ] = None,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Print the errors of a model on recordings, in curvature and at the tip, run by run and pooled.

    With several models each row says which model it is of.
    """
    from functools import partial

    from coast_cli.diagnosis.compare import compare_models
    from coast_cli.diagnosis.unnamed.seen import notes_on_range
    from coast_cli.output.answer import Answer
    from coast_cli.output.atomic import Writer, check_suffix
    from coast_cli.output.provenance import provenance
    from coast_cli.output.residuals import write_residuals
    from coast_cli.output.write import write_answer
    from coast_cli.recordings.mapping import mapping_of
    from coast_cli.recordings.read import read_recordings
    from coast_cli.recordings.window import between
    from coast_cli.spec.load import load_config

    if residuals is not None:
        check_suffix("--residuals", residuals, (".csv",))
    document = load_config(config)
    read = read_recordings(recordings, document, columns=mapping_of(columns), pair=pair, bending_length_mm=x2)
    read = between(read, begin, end)
    models = [(str(path), load_config(path)) for path in model or ()]
    models = models or [(str(config), document)]
    comparison = compare_models(models, read, noise)
    notes = (*read.notes, *(note for _, one in models for note in notes_on_range(one, read)))
    if plot is not None:
        from coast_cli.output.comparison_plot import plot_comparison

        picture, left_out = plot_comparison(comparison)
        picture.write(plot)
        notes += left_out
    beside: dict[Path, Writer] = {} if residuals is None else {residuals: partial(write_residuals, comparison)}
    origin = provenance(document, *(one for _, one in models if one is not document), recordings=read.sources)
    shown = format or (None if output else "table")
    write_answer(Answer("compare", comparison.rows(), origin, notes), shown, output or (), beside=beside)
