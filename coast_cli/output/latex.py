"""LaTeX tables: a plain tabular that needs no package, numbers to five digits, no column without a value."""

from __future__ import annotations

from typing import IO

from coast_cli.output.answer import Answer
from coast_cli.output.markdown import markdown_cell, shown_names

_MARKS = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    **{mark: f"\\{mark}" for mark in "&%$#_{}"},
}


def render(answer: Answer, stream: IO[str]) -> None:
    """Write the rows as a tabular, headings between rules; numbers stand right."""
    names = shown_names(answer)
    if not names:
        return
    columns = "".join("r" if any(isinstance(row[name], int | float) for row in answer.rows) else "l" for name in names)
    stream.write(f"\\begin{{tabular}}{{{columns}}}\n\\hline\n{' & '.join(map(_escaped, names))} \\\\\n\\hline\n")
    for row in answer.rows:
        stream.write(f"{' & '.join(_escaped(markdown_cell(row[name])) for name in names)} \\\\\n")
    stream.write("\\hline\n\\end{tabular}\n")


def _escaped(text: str) -> str:
    return "".join(_MARKS.get(mark, mark) for mark in " ".join(text.split()))
