"""``coast recordings``: what is in recordings, and what they can and cannot decide."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from coast_cli.cli.options import FormatOption, OutputOption
from coast_cli.cli.paths import READS, WRITES
from coast_cli.cli.recording_options import (
    BendingLengthOption,
    ColumnsOption,
    FromOption,
    NoiseOption,
    RecordedPairOption,
    RecordingsArgument,
    ToOption,
)

if TYPE_CHECKING:
    from coast_cli.recordings.model import Recordings


def recordings(
    recordings: RecordingsArgument,
    *,
    config: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="configuration whose tubes the recordings name"), READS
    ] = None,
    columns: ColumnsOption = None,
    pair: RecordedPairOption = None,
    x2: BendingLengthOption = None,
    begin: FromOption = None,
    end: ToOption = None,
    noise: NoiseOption = None,
    suggest: Annotated[
        bool, typer.Option("--suggest", help="print a mapping for one file, to edit and give to --columns")
    ] = False,
    convert: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="write the recordings with our columns"), WRITES
    ] = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Print what each run holds: branches, ranges, noise; and say what the recordings can and cannot decide."""
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.recordings.mapping import mapping_of
    from coast_cli.recordings.read import read_recordings
    from coast_cli.recordings.summary import can_decide, summary_rows
    from coast_cli.recordings.window import between
    from coast_cli.spec.load import load_config

    if suggest:
        if len(recordings) > 1 or convert is not None or columns is not None:
            raise UsageError("--suggest looks at one file as it is; allowed: RECORDING --suggest.")
        _print_mapping(recordings[0])
        return
    documents = () if config is None else (load_config(config),)
    read = read_recordings(
        recordings,
        documents[0] if documents else None,
        columns=mapping_of(columns),
        pair=pair,
        bending_length_mm=x2,
    )
    read = between(read, begin, end)
    if convert is not None:
        _convert(read, convert)
        return
    origin = provenance(*documents, recordings=read.sources)
    answer = Answer("recordings", summary_rows(read, noise), origin, (*read.notes, *can_decide(read, noise)))
    write_answer(answer, format, output or ())


def _print_mapping(recording: Path) -> None:
    from coast_cli.output.standard_streams import to_stdout
    from coast_cli.recordings.suggest import suggest

    text = suggest(str(recording))
    to_stdout(lambda stream: stream.write(text))


def _convert(read: Recordings, path: Path) -> None:
    from functools import partial

    from coast_cli.output.atomic import check_suffix, write_files
    from coast_cli.output.write import say
    from coast_cli.recordings.convert import write_recordings

    check_suffix("--convert", path, (".csv",))
    write_files({path: partial(write_recordings, read)})
    for note in read.notes:
        say(f"note: {note}")
    say(f"wrote {path}: {len(read.run_names)} runs, as `coast recordings {path}` reads them")
