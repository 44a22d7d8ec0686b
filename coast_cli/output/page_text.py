"""A page of the guide in a terminal that is narrower than the page: paragraphs filled anew, wide tables row by row."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby
from textwrap import wrap

_ITEM = re.compile(r"(\s*(?:[-*]|\d+\.)\s+)(.*)")
_ROW = re.compile(r"\S  +\S|─{4}")
_FENCE, _CUT = "```", "…"


def fitted(page: str, width: int | None, topic: str = "") -> str:
    """Return a page of Markdown with no line wider than ``width``; as it stands where that is None or all lines fit.

    Rows that a program printed are cut, since a broken row is read by nobody; the end of the page says where they are whole.
    """
    lines = page.splitlines()
    if width is None or max(map(len, lines), default=0) <= width:
        return page
    shown = list(_fitted(lines, width))
    if any(line.endswith(_CUT) for line in shown):
        whole = f"Rows that end in {_CUT} are cut: `coast guide {topic} > {topic}.md` has them whole."
        shown += ["", *_wrapped(whole, width, "", "")]
    return "".join(f"{line}\n" for line in shown)


def _fitted(lines: list[str], width: int) -> Iterator[str]:
    fenced = False
    kinds = []
    for line in lines:
        fenced ^= line.startswith(_FENCE)
        kinds.append(("shown" if fenced or line.startswith(_FENCE) else _kind(line), line))
    for kind, group in groupby(kinds, key=lambda one: one[0]):
        block = [line for _, line in group]
        if kind == "shown":
            yield from _broken(block, width)
        elif kind == "table":
            yield from _table(block, width)
        elif kind == "text":
            yield from _paragraphs(block, width)
        else:
            yield from block


def _kind(line: str) -> str:
    if not line.strip():
        return "blank"
    return "table" if line.startswith("|") else "text"


def _broken(block: list[str], width: int) -> Iterator[str]:
    """Cut rows of a table where they are too wide, and break other lines, their own spaces kept."""
    console = block[0].startswith(f"{_FENCE}console")
    for line in block:
        if len(line) <= width:
            yield line
        elif console and _ROW.search(line) and not line.startswith("$ "):
            yield line[: width - 1] + _CUT
        else:
            lead = line[: len(line) - len(line.lstrip())][: width // 2]
            yield from _wrapped(line.lstrip(), width, lead, f"{lead}  "[: width // 2], spaces=True)


def _table(block: list[str], width: int) -> Iterator[str]:
    """Return a table as it stands where it fits, else each row as its first cell and what each column says of it."""
    if max(map(len, block)) <= width:
        yield from block
        return
    head, *rows = ([cell.strip() for cell in line.strip().strip("|").split("|")] for line in block)
    for row in rows:
        if set("".join(row)) <= set("-: "):
            continue
        yield from _wrapped(row[0], width, "", "  ")
        for name, cell in zip(head[1:], row[1:], strict=False):
            if cell:
                yield from _wrapped(f"{name}: {cell}" if name else cell, width, "  ", "    ")


def _paragraphs(block: list[str], width: int) -> Iterator[str]:
    """Fill running text anew; a heading and each item of a list begin a line."""
    pieces: list[str] = []
    for line in block:
        starts = line.startswith("#") or _ITEM.fullmatch(line) or not pieces or pieces[-1].startswith("#")
        if starts:
            pieces.append(line)
        else:
            pieces[-1] += f" {line.strip()}"
    for piece in pieces:
        item = _ITEM.fullmatch(piece)
        mark, text = (item[1], item[2]) if item else ("", piece)
        yield from _wrapped(text, width, mark, " " * len(mark))


def _wrapped(text: str, width: int, first: str, others: str, *, spaces: bool = False) -> list[str]:
    return wrap(
        text,
        width,
        initial_indent=first,
        subsequent_indent=others,
        break_on_hyphens=False,
        drop_whitespace=True,
        replace_whitespace=not spaces,
        expand_tabs=False,
    )
