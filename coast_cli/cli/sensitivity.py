"""``coast sensitivity``: by how much every input moves every figure."""

from __future__ import annotations

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption


def sensitivity(config: ConfigArgument, *, format: FormatOption = None, output: OutputOption = None) -> None:
    """Print exact derivatives of tips, pre-curvature, rigidities and stroke by every input.

    Each row tells by how much a figure changes, in its own unit and in per cent, where one input changes by one
    micrometre, GPa, per cent or 1/m. Which inputs strokes cannot tell apart is said on stderr.
    """
    from coast_cli.design.sensitivity import sensitivity_rows
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config

    document = load_config(config)
    design = build(document)
    rows, notes = sensitivity_rows(design)
    origin = provenance(document, options={})
    write_answer(Answer("sensitivity", rows, origin, (*notes, *design.notes)), format, output or ())
