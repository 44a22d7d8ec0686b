"""Pieces of an HTML page that needs nothing from outside: one style, sections, tables, pictures inside it, provenance.

Every function takes text as it is and escapes it; what it returns is HTML.
"""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any, Literal, NamedTuple

from coast_cli.output.picture import Picture, can_draw

_STYLE = """
html { font-size: 15px; }
body { font: 1rem/1.45 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; color: #1a1a1a; background: #fff;
  max-width: 64rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.3rem; margin: 2.4rem 0 .5rem; padding-bottom: .2rem; border-bottom: 2px solid #0072b2; }
h3 { font-size: 1.05rem; margin: 1.5rem 0 .4rem; } h1, h2, h3, p:has(+ .wide), p:has(+ figure) { break-after: avoid; }
p, ul { margin: .5rem 0; max-width: 50rem; } p, li { break-inside: avoid; } ul { padding-left: 1.2rem; }
nav { margin: 1rem 0; } nav a { margin-right: 1.1rem; white-space: nowrap; } a { color: #0072b2; }
.wide { overflow-x: auto; margin: .6rem 0 1rem; }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem 1rem .2rem 0; text-align: right; vertical-align: top; }
td { white-space: nowrap; } td.text { white-space: normal; overflow-wrap: anywhere; min-width: 9rem; }
.text, .key { text-align: left; } th { font-weight: 600; } th.key { white-space: nowrap; }
td:last-child, th:last-child { padding-right: .3rem; }
thead th { border-bottom: 1px solid #888; vertical-align: bottom; } .unit { font-weight: 400; color: #555; }
tbody { break-inside: avoid; } tbody tr + tr td { border-top: 1px solid #eee; } tr { break-inside: avoid; }
.group th { padding-top: .8rem; border-bottom: 1px solid #ccc; text-align: left; break-after: avoid; }
.group small { font-weight: 400; font-size: 1em; color: #555; margin-left: .6rem; }
.chosen td { background: #e8f2f9; } .fails td { background: #fbe9e0; font-weight: 600; }
.good { color: #00664a; font-weight: 600; } .bad { color: #a33f00; font-weight: 600; } .open { font-weight: 600; }
.beside { display: flex; flex-wrap: wrap; gap: 0 2.5rem; } .beside > section { min-width: 0; max-width: 100%; }
svg.drawing { display: block; width: 100%; max-height: 9rem; }
figure { margin: .8rem 0 1.2rem; break-inside: avoid; } figcaption { color: #555; font-size: .87rem; margin-top: .2rem; }
img { display: block; max-width: 100%; height: auto; }
code { font: .92em ui-monospace, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; } td.key code { overflow-wrap: normal; }
mark { background: #ffe9a8; color: inherit; padding: 0 .25em; border-radius: .2em; } .quiet { color: #666; }
blockquote { margin: .6rem 0; padding: .1rem 0 .1rem .9rem; border-left: 3px solid #ccc; color: #444; font-size: .87rem; }
footer { margin-top: 1.5rem; padding-top: .5rem; border-top: 1px solid #ccc; color: #555; font-size: .82rem; }
section:has(> footer), footer { break-inside: avoid; }
@media (prefers-color-scheme: dark) { @media screen {
  body { color: #e4e4e4; background: #14171a; } a { color: #6db6e8; } figure img { background: #fff; padding: .3rem; }
  .unit, .group small, figcaption, .quiet, blockquote, footer { color: #a8a8a8; } tbody tr + tr td { border-color: #2a2f34; }
  .chosen td { background: #17344a; } .fails td { background: #4a2413; } mark { background: #5c4a00; }
  .good { color: #4cc9a0; } .bad { color: #ff9b63; } h2 { border-color: #3a8fc4; }
} }
@page { size: A4; margin: 9mm 11mm; }
@media print {
  html { font-size: 6.7pt; } body { margin: 0; padding: 0; max-width: none; line-height: 1.26; print-color-adjust: exact; }
  nav { display: none; } .wide { overflow: visible; margin: .3rem 0 .5rem; } th, td { padding: .04rem .5rem .04rem 0; }
  h1 { font-size: 1.5rem; } h2 { font-size: 1.2rem; margin: .7rem 0 .2rem; } h3 { margin: .6rem 0 .2rem; }
  p, ul { margin: .25rem 0; max-width: none; } figure { margin: .3rem 0 .5rem; } figure img { max-height: 45mm; width: auto; }
  svg.drawing { max-height: 22mm; }
  h2 { column-span: all; } #diagnosis, #tolerances, #inputs, #provenance { columns: 2; column-gap: 7mm; }
  #tolerances > section:last-of-type { column-span: all; } #tolerances figure img { max-height: 50mm; width: auto; }
  .details figure img { max-height: 34mm; } #diagnosis figure img { max-height: 45mm; }
  td.text { min-width: 0; } #strokes .wide { display: none; }
  #strokes, #shapes { display: inline-block; width: 48%; vertical-align: top; margin-right: 1%; }
  #inputs td:nth-child(3), #inputs th:nth-child(3) { display: none; }
  thead { display: table-header-group; } a { color: inherit; text-decoration: none; }
}
""".strip()


_LONG = 60  # characters, with what marks them
_CODE = re.compile(r"`([^`]+)`")


class HtmlColumn(NamedTuple):
    """The head of a column, its unit on a line of its own, and what it holds.

    A number stands right; a ``text`` stands left and may go on in a next line, a ``key`` (a name) only if it is long.
    """

    name: str
    unit: str = ""
    holds: Literal["number", "text", "key"] = "number"


class Row(NamedTuple):
    """Cells of a row, each escaped unless it is ``Markup``; ``mark`` is a class of the style."""

    cells: Sequence[str]
    mark: str = ""


class Markup(str):
    """HTML that is put in as it is."""

    __slots__ = ()


class Group(NamedTuple):
    """Rows of a table under a heading of their own, with what is said beside it."""

    heading: str
    rows: Sequence[Row]
    said: str = ""


def page(title: str, body: Iterable[str]) -> str:
    """Return a whole document."""
    head = [
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title>",
        f"<style>\n{_STYLE}\n</style>",
        "</head>",
        "<body>",
    ]
    return "\n".join([*head, *body, "</body>", "</html>", ""])


def section(title: str, *content: str, level: int = 2, anchor: str = "") -> str:
    """Return content under a heading."""
    name = f' id="{escape(anchor)}"' if anchor else ""
    return f"<section{name}>\n<h{level}>{escape(title)}</h{level}>\n{joined(*content)}\n</section>"


def joined(*parts: str) -> str:
    """Return parts on lines of their own; those that are empty are left out."""
    return "\n".join(part for part in parts if part)


def paragraph(text: str) -> str:
    """Return a paragraph, or nothing where there is no text; what stands in backticks is code."""
    return f"<p>{words(text)}</p>" if text else ""


def words(text: str) -> str:
    """Return text inside a line; what stands in backticks is code."""
    return _CODE.sub(r"<code>\1</code>", escape(text))


def side_by_side(*parts: str) -> str:
    """Return parts beside one another where there is room; those that are empty are left out."""
    found = [part for part in parts if part]
    return f'<div class="beside">\n{joined(*found)}\n</div>' if found else ""


def bullets(texts: Iterable[str]) -> str:
    """Return a list, or nothing where there are no texts; what stands in backticks is code."""
    items = "\n".join(f"<li>{words(text)}</li>" for text in texts)
    return f"<ul>\n{items}\n</ul>" if items else ""


def table(columns: Sequence[HtmlColumn], rows: Iterable[Row]) -> str:
    """Return a table; a head is printed again on every page."""
    return grouped(columns, [Group("", list(rows))])


def grouped(columns: Sequence[HtmlColumn], groups: Iterable[Group]) -> str:
    """Return a table in parts, each under its heading."""
    head = "".join(f"<th{_side(column)}>{_head(column)}</th>" for column in columns)
    bodies = "\n".join(f"<tbody>\n{_group(columns, group)}\n</tbody>" for group in groups)
    return f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n{bodies}\n</table></div>'


def figure(picture: Picture, caption: str, format: str = "svg") -> str:
    """Return a picture with a caption, inside the page; nothing where matplotlib is not installed."""
    if not can_draw():
        return ""
    kind = {"svg": "image/svg+xml", "png": "image/png"}[format]
    data = b64encode(picture.render(format)).decode()
    width = round(96 * picture.size[0])
    image = f'<img alt="{escape(caption)}" width="{width}" src="data:{kind};base64,{data}">'
    return f"<figure>\n{image}\n<figcaption>{escape(caption)}</figcaption>\n</figure>"


def footer(provenance: Mapping[str, Any]) -> str:
    """Return versions, inputs with their digests, options and seed, a line each."""
    lines = [", ".join(f"{name} {version}" for name, version in provenance.get("versions", {}).items())]
    inputs = [file for name in ("configs", "recordings") for file in provenance.get(name, ())]
    lines += [f"{file['file']}  sha256 {file['sha256']}" for file in inputs]
    options = provenance.get("options", {}).items()
    lines += [f"{name} {_option(value)}" for name, value in options if value not in ([], None)]
    lines += [f"seed {provenance['seed']}"] if "seed" in provenance else []
    return "<footer>" + "<br>\n".join(f"<code>{escape(line)}</code>" for line in lines) + "</footer>"


def _option(value: Any) -> str:  # noqa: ANN401
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)


def _head(column: HtmlColumn) -> str:
    unit = f'<br><span class="unit">{escape(column.unit)}</span>' if column.unit else ""
    return escape(column.name) + unit


def _group(columns: Sequence[HtmlColumn], group: Group) -> str:
    lines = []
    if group.heading:
        said = f"<small>{escape(group.said)}</small>" if group.said else ""
        lines.append(f'<tr class="group"><th colspan="{len(columns)}">{escape(group.heading)}{said}</th></tr>')
    for row in group.rows:
        mark = f' class="{row.mark}"' if row.mark else ""
        cells = "".join(
            f"<td{_side(column, cell)}>{cell if isinstance(cell, Markup) else escape(cell)}</td>"
            for column, cell in zip(columns, row.cells, strict=True)
        )
        lines.append(f"<tr{mark}>{cells}</tr>")
    return "\n".join(lines)


def _side(column: HtmlColumn, cell: str = "") -> str:
    """Return the class of a cell; a word that is too long for its line may be broken."""
    kind = "text" if column.holds == "key" and len(cell) > _LONG else column.holds
    return "" if kind == "number" else f' class="{kind}"'
