"""JSON: one object with schema, provenance, notes and rows, a row a line."""

from __future__ import annotations

import json
from typing import IO

from coast_cli.output.answer import Answer


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the answer as JSON; it holds no NaN, since an answer is checked before."""
    head = {"schema": f"coast.{answer.command}/1", "provenance": answer.provenance, "notes": list(answer.notes)}
    stream.write(json.dumps(head, indent=2, allow_nan=False, ensure_ascii=False)[: -len("\n}")])
    stream.write(',\n  "rows": [')
    for number, row in enumerate(answer.rows):
        stream.write(",\n    " if number else "\n    ")
        stream.write(json.dumps(dict(row), allow_nan=False, ensure_ascii=False))
    stream.write("\n  ]\n}\n")
