"""``coast explore``: the best pairs of a whole design space."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, PlotOption
from coast_cli.cli.paths import WRITES


def explore(
    config: ConfigArgument,
    *,
    every: Annotated[
        Path | None, typer.Option("--all", metavar="FILE.csv", help="stream every pair here; a rerun resumes"), WRITES
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace the file of --all")] = False,
    jobs: Annotated[int, typer.Option(min=1, max=1024, help="processes on this machine")] = 1,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="of a dask scheduler, tcp://HOST:PORT, instead of --jobs")
    ] = None,
    top: Annotated[int | None, typer.Option(min=1, help="print only so many of the front, by score")] = None,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Pair every outer with every middle tube of the [explore] ranges and print the Pareto front.

    The front is refined by new pairs round it. Only pairs that pass [checks] are on it. The answer is the same bytes
    with any number of jobs, and on a cluster. Interrupted, it keeps what is done: in the file of --all, else in a
    folder of the working folder, which it names. The same command goes on from there.
    """
    from contextlib import closing

    from coast_cli.design.exploration import Beginning, steps
    from coast_cli.design.exploration import explore as run
    from coast_cli.design.work import workers
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
    from coast_cli.output.kept import Kept, kept_when_stopped
    from coast_cli.output.progress import progress
    from coast_cli.output.provenance import provenance
    from coast_cli.output.stream import CsvStream
    from coast_cli.output.write import write_answer
    from coast_cli.spec.load import load_config

    if cluster is not None and jobs > 1:
        raise UsageError("give either --jobs or --cluster.")
    document = load_config(config)
    total = steps(document)
    origin = provenance(document, seed=None if document.explore is None else document.explore.seed)
    stream: CsvStream | Kept = Kept(f"{config.stem}.explore", repr(origin))
    if every is not None:
        stream = CsvStream(every, repr(origin), overwrite=overwrite)
    with closing(stream), kept_when_stopped(stream):
        beginning = Beginning(stream.blocks, stream.state)
        with workers(jobs, cluster) as executor, progress("blocks", total, beginning.blocks) as advance:
            found = run(
                document,
                executor=executor,
                beginning=beginning,
                save=stream.write,
                advance=advance,
                every=every is not None,
            )
        if plot is not None:
            found.plot(plot)
        write_answer(Answer("explore", found.rows[:top], origin, found.notes), format, output or ())
        stream.finish()
