"""``coast explain``: what an effect, a configuration key, a check or a column means."""

from __future__ import annotations

from typing import Annotated

import typer

from coast_cli.cli.options import FormatOption, OutputOption, PlotOption


def explain(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="an effect, a table, a key, a check or a column; default: all"),
    ] = None,
    *,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Say what a name means: effects by id, tables and keys dotted or not, checks, and columns of the answers.

    An effect has a page of its own; --plot draws its signature.
    """
    from coast_cli.errors import UsageError, nearest
    from coast_cli.output.answer import Answer
    from coast_cli.output.effect_page import plot_signature, write_effect
    from coast_cli.output.glossary import effect_of, everything, glossary, look_up
    from coast_cli.output.standard_streams import to_stdout
    from coast_cli.output.view import stdout_width
    from coast_cli.output.write import write_answer

    if name is None:
        write_answer(Answer("explain", everything()), format, output or ())
        return
    rows = look_up(name)
    if not rows:
        hint = nearest(name, glossary()) or "`coast explain` lists all names."
        raise UsageError(f"{name}: there is no effect, key, check or column of that name. {hint}")
    effect = effect_of(name)
    found = None
    if effect is not None and "joint" in effect.recordings and (plot is not None or format is None):
        from coast_cli.design.signature import signature

        found = signature(effect)
    if plot is not None:
        if found is None:
            raise UsageError(f"{name}: only an effect of joints has a signature to draw.")
        plot_signature(found).write(plot)
    if effect is not None and format is None and not output:
        to_stdout(lambda stream: write_effect(effect, found, stream, stdout_width()))
    else:
        write_answer(Answer("explain", rows), format, output or ())
