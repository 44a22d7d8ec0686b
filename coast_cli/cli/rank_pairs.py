"""``coast rank-pairs``: which outer and middle tube go into the robot together."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, PlotOption, numbers


def rank_pairs(
    config: ConfigArgument,
    *,
    rigidity: Annotated[Literal["mean", "series"], typer.Option(help="which rigidity the score takes")] = "mean",
    assembly: Annotated[
        Literal["separate", "coupled"], typer.Option(help="each tube's own sag, or the sag of the pair")
    ] = "separate",
    section: Annotated[
        Literal["sector", "chord"] | None, typer.Option(help="what a notch leaves, for every tube")
    ] = None,
    weights: Annotated[
        str, typer.Option(metavar="W,W,W", help="of pre-curvature, rigidity ratio and total rigidity")
    ] = "1,1,1",
    robust: Annotated[
        bool, typer.Option("--robust", help="rank by the chance of passing [checks] over [tolerances]")
    ] = False,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Rank every pair of an outer and a middle tube.

    The score joins total pre-curvature, |ln(rigidity ratio)| and total rigidity, each over its reference of [rank];
    smaller is better. A pair that cannot be assembled is listed last with its reason.
    """
    from dataclasses import asdict

    from coast_cli.design.rank import RankOptions, rank
    from coast_cli.output.answer import Answer, Columns
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.load import load_config

    options = RankOptions(rigidity, assembly, section, tuple(numbers(weights, "--weights")))
    document = load_config(config)
    if robust:
        from coast_cli.design.robust import SAMPLES, robust_rank

        ranking = robust_rank(document, options)
        origin = provenance(document, options=asdict(options) | {"robust": SAMPLES}, seed=0)
    else:
        ranking = rank(document, options)
        origin = provenance(document, options=asdict(options))
    if plot is not None:
        ranking.plot(plot)
    write_answer(Answer("rank-pairs", Columns(ranking.columns), origin, ranking.notes), format, output or ())
