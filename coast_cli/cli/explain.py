"""``coast explain``: what an effect, a configuration key, a check or a column means."""

from __future__ import annotations

from typing import Annotated

import typer

from coast_cli.cli.options import FormatOption, OutputOption


def explain(
    name: Annotated[str, typer.Argument(metavar="NAME", help="an effect, a key, a check or a column")],
    *,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Say what a name means: effects by id, configuration keys dotted or not, checks, and columns of the answers."""
    from coast_cli.errors import UsageError, nearest
    from coast_cli.output.answer import Answer
    from coast_cli.output.glossary import glossary, look_up
    from coast_cli.output.write import write_answer

    rows = look_up(name)
    if not rows:
        hint = nearest(name, glossary()) or "Run `coast schema` for the keys of a configuration."
        raise UsageError(f"{name}: there is no effect, key, check or column of that name. {hint}")
    write_answer(Answer("explain", rows), format, output or ())
