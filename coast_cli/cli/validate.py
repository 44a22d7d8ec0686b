"""``coast validate``: whether configurations can be used, each with the first thing wrong with it."""

from __future__ import annotations

from coast_cli.cli.options import ConfigsArgument, FormatOption, OutputOption


def validate(configs: ConfigsArgument, *, format: FormatOption = None, output: OutputOption = None) -> int:
    """Check the text, keys, values and geometry of each configuration; exit 3 when one is wrong."""
    from coast_cli.errors import BadInput
    from coast_cli.output.answer import Answer, Row
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import say, write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config

    rows: list[Row] = []
    documents = []
    for config in configs:
        try:
            document = load_config(config)
            design = build(document)
            if document.joint is not None and design.joint_pair is not None:
                design.joint()
            documents.append(document)
            rows.append({"config": str(config), "valid": True, "line": None, "message": None})
        except BadInput as error:
            say(str(error))
            rows.append({"config": str(config), "valid": False, "line": error.line, "message": str(error)})
    write_answer(Answer("validate", rows, provenance(*documents)), format, output or ())
    return 0 if all(row["valid"] for row in rows) else BadInput.exit_code
