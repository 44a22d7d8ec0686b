"""``coast compare``: the errors of one model on recordings it was not fitted to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption
from coast_cli.cli.paths import READS
from coast_cli.cli.recording_options import (
    BendingLengthOption,
    ColumnsOption,
    NoiseOption,
    PlotOption,
    RecordedPairOption,
    RecordingsArgument,
)


def compare(
    config: ConfigArgument,
    recordings: RecordingsArgument,
    *,
    model: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="a model with corrections, as --save-model wrote it"), READS
    ] = None,
    columns: ColumnsOption = None,
    pair: RecordedPairOption = None,
    x2: BendingLengthOption = None,
    noise: NoiseOption = None,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Print the errors of a model on recordings, in curvature and at the tip, run by run and pooled."""
    from coast_cli.diagnosis.compare import compare as errors_of
    from coast_cli.diagnosis.unnamed.seen import notes_on_range
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.recordings.mapping import mapping_of
    from coast_cli.recordings.read import read_recordings
    from coast_cli.spec.load import load_config

    document = load_config(config)
    read = read_recordings(recordings, document, columns=mapping_of(columns), pair=pair, bending_length_mm=x2)
    documents = (document,) if model is None else (document, load_config(model))
    comparison = errors_of(documents[-1], read, noise)
    notes = (*read.notes, *notes_on_range(documents[-1], read))
    if plot is not None:
        from coast_cli.output.comparison_plot import plot_comparison

        picture, left_out = plot_comparison(comparison)
        picture.write(plot)
        notes += left_out
    origin = provenance(*documents, recordings=read.sources)
    write_answer(Answer("compare", comparison.rows(), origin, notes), format, output or ())
