"""``coast tolerance``: what the errors of manufacture do to a pair."""

from __future__ import annotations

from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, PairOption, PlotOption

KINDS = ("figure", "check", "first", "index")


def tolerance(
    config: ConfigArgument,
    *,
    pair: PairOption = None,
    samples: Annotated[int, typer.Option(min=2, max=10_000_000, help="random samples of the pair")] = 10_000,
    seed: Annotated[int, typer.Option(min=0, help="of the random numbers")] = 0,
    only: Annotated[
        str | None, typer.Option(metavar="KIND,...", help="of figure, check, first and index; default: all")
    ] = None,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Sample one pair over its [tolerances].

    Rows give the distribution of every figure, the chance that each check holds, how often each pair of the bench
    ranks first, and Sobol indices: the input with the largest is the one to tighten first.
    """
    from coast_cli.design.tolerance import tolerance_rows
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
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
    rows, notes, columns = tolerance_rows(design, (outer, middle), samples=samples, seed=seed)
    origin = provenance(document, options={"pair": f"{outer}/{middle}", "samples": samples}, seed=seed)
    if plot is not None:
        from coast_cli.output.design_plot import plot_tolerance

        plot_tolerance(f"{outer}/{middle}", rows, columns).write(plot)
    write_answer(Answer("tolerance", [row for row in rows if row["kind"] in kinds], origin, notes), format, output or ())
