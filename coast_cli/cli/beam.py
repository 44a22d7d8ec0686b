"""``coast beam``: the shape of one tube under gravity."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, PlotOption


def beam(
    config: ConfigArgument,
    *,
    tube: Annotated[list[str], typer.Option(metavar="NAME", help="a tube of the configuration; repeatable")],
    method: Annotated[
        Literal["arc", "projected"], typer.Option(help="in arc length, or the paper's method on the projected length")
    ] = "arc",
    points: Annotated[
        int | None, typer.Option(min=2, max=1_000_000, help="evenly spaced points; default: the ends of each piece")
    ] = None,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Print the shape of tubes clamped along +x, sagging under their weight, gravity along -y."""
    from coast_cli.design.shape import shape_columns
    from coast_cli.output.answer import Answer, Columns
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config

    document = load_config(config)
    design = build(document)
    columns = shape_columns([design.tube(name) for name in tube], design.gravity, method=method, points=points)
    origin = provenance(document, options={"method": method, "points": points})
    if plot is not None:
        from coast_cli.output.design_plot import plot_shapes

        plot_shapes(columns).write(plot)
    write_answer(Answer("beam", Columns(columns), origin, (*design.notes, *design.uncorrected)), format, output or ())
