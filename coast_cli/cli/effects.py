"""``coast effects``: the physics that a model may leave out, by the stage at which it acts."""

from __future__ import annotations

from coast_cli.cli.options import FormatOption, OutputOption


def effects(*, format: FormatOption = None, output: OutputOption = None) -> None:
    """List the effects that a diagnosis knows, by the stage at which they act; `coast explain EFFECT` has a page on each."""
    from coast_cli.output.answer import Answer
    from coast_cli.output.glossary import effect_rows
    from coast_cli.output.write import write_answer

    write_answer(Answer("effects", effect_rows()), format, output or ())
