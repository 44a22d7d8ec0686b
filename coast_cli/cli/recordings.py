"""``coast recordings``: what is in recordings, and what they can and cannot decide."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import FormatOption, OutputOption
from coast_cli.cli.paths import READS
from coast_cli.cli.recording_options import (
    BendingLengthOption,
    ColumnsOption,
    NoiseOption,
    RecordedPairOption,
    RecordingsArgument,
)


def recordings(
    recordings: RecordingsArgument,
    *,
    config: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="configuration whose tubes the recordings name"), READS
    ] = None,
    columns: ColumnsOption = None,
    pair: RecordedPairOption = None,
    x2: BendingLengthOption = None,
    noise: NoiseOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Print what each run holds: branches, ranges, noise; and say what the recordings can and cannot decide."""
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.recordings.mapping import mapping_of
    from coast_cli.recordings.read import read_recordings
    from coast_cli.recordings.summary import can_decide, summary_rows
    from coast_cli.spec.load import load_config

    documents = () if config is None else (load_config(config),)
    read = read_recordings(
        recordings,
        documents[0] if documents else None,
        columns=mapping_of(columns),
        pair=pair,
        bending_length_mm=x2,
    )
    origin = provenance(*documents, recordings=read.sources)
    answer = Answer("recordings", summary_rows(read, noise), origin, (*read.notes, *can_decide(read, noise)))
    write_answer(answer, format, output or ())
