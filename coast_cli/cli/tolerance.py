"""``coast tolerance``: what the errors of manufacture do to a pair."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, PairOption, PlotOption

if TYPE_CHECKING:
    from coast_cli.mechanics.section import FloatArray

KINDS = ("figure", "check", "first", "index")


def tolerance(
    config: ConfigArgument,
    *,
    pair: PairOption = None,
    samples: Annotated[int, typer.Option(min=2, max=10_000_000, help="random samples of the pair")] = 10_000,
    seed: Annotated[int, typer.Option(min=0, help="of the random numbers")] = 0,
    jobs: Annotated[int, typer.Option(min=1, max=1024, help="processes on this machine")] = 1,
    only: Annotated[
        str | None, typer.Option(metavar="KIND,...", help="of figure, check, first and index; default: all")
    ] = None,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Sample one pair over its [tolerances].

    Rows give the distribution of every figure, the chance that each check holds, how often each pair of the bench
    ranks first, and Sobol indices: the input with the largest is the one to tighten first. The answer is the same bytes
    with any number of jobs. Interrupted, it keeps what is done in a folder of the working folder, which it names, and the same
    command goes on from there.
    """
    from coast_cli.design.samples import samples_in_block
    from coast_cli.design.tolerance import tolerance_rows
    from coast_cli.design.work import workers
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
    from coast_cli.output.kept import Kept, kept_when_stopped
    from coast_cli.output.progress import progress
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config

    document = load_config(config)
    design = build(document)
    outer, middle = design.pair(pair)
    if outer is None:
        raise UsageError(f"--pair {middle}: a tolerance run needs an outer and a middle tube; allowed: OUTER/MIDDLE.")
    kinds = KINDS if only is None else tuple(only.split(","))
    if not set(kinds) <= set(KINDS):
        raise UsageError(f"--only {only}: allowed: one or several of {', '.join(KINDS)}.")
    origin = provenance(document, options={"pair": f"{outer}/{middle}", "samples": samples}, seed=seed)
    done = Kept(f"{config.stem}.tolerance", repr(origin))
    blocks = -(-samples // samples_in_block((design.tube(outer), design.tube(middle))))
    with kept_when_stopped(done):
        with workers(jobs, None) as executor, progress("blocks", blocks, done.blocks) as advance:

            def keep(figures: Mapping[str, FloatArray]) -> None:
                done.write({}, figures)
                advance()

            rows, notes, columns = tolerance_rows(
                design, (outer, middle), samples=samples, seed=seed, executor=executor, beginning=done.state, keep=keep
            )
        if plot is not None:
            from coast_cli.output.design_plot import plot_tolerance

            plot_tolerance(f"{outer}/{middle}", rows, columns).write(plot)
        chosen = [row for row in rows if row["kind"] in kinds]
        write_answer(Answer("tolerance", chosen, origin, notes), format, output or ())
        done.finish()
