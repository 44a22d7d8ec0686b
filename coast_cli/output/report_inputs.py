"""The inputs of a configuration as a table, each with what its file says of where it comes from.

A source is the comment on the line of a key, or the lines of comment right above it. What the file leaves to a default of
the program is listed too, since that is assumed as well.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from typing import Any

from pydantic import BaseModel

from coast_cli.output.html import Group, HtmlColumn, Markup, Row, grouped, joined, paragraph, words
from coast_cli.spec.config import Config, dotted
from coast_cli.spec.positions import Path, line_comments
from coast_cli.spec.tubes import Role, bench_tubes
from coast_cli.spec.values import Calibrated

# Limits and ranges have sections or commands of their own; how sure a fit was is no input.
_NO_INPUTS = ("version", "checks", "explore", "tolerances", "fitted")
_ASSUMED = re.compile(r"\bassumed\b", re.IGNORECASE)


@dataclass(frozen=True)
class Input:
    """One key with its value; ``source`` is what the file says of it, ``given`` whether the file has it at all."""

    path: Path
    value: Any
    meaning: str
    source: str
    given: bool = True

    @property
    def counts(self) -> bool:
        """Whether it is a number or a default, and not a name."""
        return not (self.given and isinstance(self.value, str))

    @property
    def assumed(self) -> bool:
        """Whether the file says so, of all or of a part."""
        return bool(_ASSUMED.search(self.source))


class Sources:
    """What the comments of a configuration's file say of its keys."""

    def __init__(self, config: Config) -> None:
        origin = config.origin
        self._positions = origin.positions
        self._comments = line_comments(origin.text)
        lines = enumerate(origin.text.splitlines(), start=1)
        self._whole = {line for line, text in lines if line in self._comments and text.lstrip().startswith("#")}
        self._head = 0
        while self._head + 1 in self._whole:
            self._head += 1

    @property
    def head(self) -> list[str]:
        """The lines of comment that the file begins with."""
        return [self._comments[line] for line in range(1, self._head + 1)]

    def given(self, path: Path) -> bool:
        """Return whether the file has the key."""
        return path in self._positions

    def of(self, path: Path) -> str:
        """Return the comment of a key or table, empty where there is none."""
        if path not in self._positions:
            return ""
        line = self._positions[path].line
        if line in self._comments:
            return self._comments[line]
        above: list[str] = []
        while line - 1 in self._whole and line - 1 > self._head:
            line -= 1
            above.insert(0, self._comments[line])
        return " ".join(above)


def inputs_of(config: Config) -> list[Input]:
    """Return every input of a configuration in the order of its format, defaults that tubes take among them."""
    sources = Sources(config)
    found = [
        Input(path, value, meaning, sources.of(path), sources.given(path))
        for path, value, meaning in _leaves(config, ())
        if path[0] not in _NO_INPUTS and path[-1] != "name"
    ]
    return [*found, *_tube_defaults(config)]


def said_of(found: list[Input]) -> str:
    """Return how many inputs are assumed, are defaults or have no source, in words."""
    numbers = [one for one in found if one.counts]
    assumed = sum(one.assumed for one in numbers)
    defaults = sum(not one.given for one in numbers)
    silent = sum(one.given and not one.source for one in numbers)
    return (
        f"{assumed} of {len(numbers)} marked as assumed in the file, {defaults} left to defaults of the program, "
        f"{silent} without a stated source"
    )


def inputs_section(config: Config) -> str:
    """Return what the file says at its head, how many inputs are assumed, and all of them by table."""
    found, sources = inputs_of(config), Sources(config)
    groups: dict[Path, list[Input]] = {}
    for one in found:
        groups.setdefault(_table(one.path), []).append(one)
    columns = [
        HtmlColumn("input", holds="key"),
        HtmlColumn("value"),
        HtmlColumn("meaning", holds="text"),
        HtmlColumn("source", holds="text"),
    ]
    parts = [
        Group(_title(path), _rows(config, path, rows), sources.of(path))
        for path, rows in sorted(groups.items(), key=lambda item: _order(item[0]))
    ]
    head = "<br>\n".join(escape(line) for line in sources.head)
    quoted = f"<p>The file says of its sources:</p>\n<blockquote>{head}</blockquote>" if head else ""
    advice = (
        "By how much each of them moves the results, `coast sensitivity` says; `coast tolerance` what their errors do."
    )
    return joined(paragraph(f"Inputs: {said_of(found)}. {advice}"), quoted, grouped(columns, parts))


def _leaves(document: BaseModel, path: Path) -> Iterator[tuple[Path, Any, str]]:
    """Yield (path, value, meaning) of every key that holds no further table."""
    for name, field in type(document).model_fields.items():
        value = getattr(document, name)
        if value is not None:
            yield from _below((*path, name), value, field.description or "")


def _below(path: Path, value: Any, meaning: str) -> Iterator[tuple[Path, Any, str]]:  # noqa: ANN401
    if isinstance(value, Calibrated):
        yield path, value, meaning
    elif isinstance(value, BaseModel):
        yield from _leaves(value, path)
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _below((*path, key), inner, "fitted parameter of an effect" if path[0] == "corrections" else "")
    elif isinstance(value, tuple) and value and isinstance(value[0], BaseModel):
        for index, inner in enumerate(value):
            yield from _leaves(inner, (*path, index))
    else:
        yield path, value, meaning


def _tube_defaults(config: Config) -> Iterator[Input]:
    """Yield what tubes take where neither their sample nor their stock says it."""
    roles: tuple[Role, ...] = ("outer", "middle")
    for role in roles:
        stock = getattr(config, role)
        for name in ("section", "end_effect", "natural_curvature_per_m"):
            for sample, tube in zip(stock.samples if stock else (), bench_tubes(config, role), strict=True):
                if getattr(sample, name) is None and getattr(stock, name) is None:
                    meaning = type(stock).model_fields[name].description or ""
                    yield Input((role, name), getattr(tube, name), meaning, "", given=False)
                    break


def _table(path: Path) -> Path:
    """Return the table that a key is listed under: a stock's own, its samples', a material's."""
    nested = path[0] in {"materials", "corrections"} or path[1:2] == ("samples",)
    return path[:2] if nested else path[:1]


def _order(table: Path) -> tuple[int, Path]:
    """Return what sorts tables as the format has them, samples after their stock."""
    return list(Config.model_fields).index(str(table[0])), table


def _title(table: Path) -> str:
    if table[1:] == ("samples",):
        return f"{table[0]} tubes"
    return dotted(table) + (" stock" if table[0] in {"outer", "middle"} else "")


def _rows(config: Config, table: Path, inputs: list[Input]) -> list[Row]:
    """Return the rows of a table; what a key means is said once."""
    rows, said = [], set[str | int]()
    for one in inputs:
        name = dotted(one.path[len(table) :])
        if table[1:] == ("samples",):
            sample = getattr(config, str(table[0])).samples[int(one.path[2])]
            name = f"{sample.name}.{dotted(one.path[3:])}"
        meaning = "" if one.path[-1] in said else one.meaning
        said.add(one.path[-1])
        rows.append(Row([Markup(f"<code>{escape(name)}</code>"), _value(one.value), meaning, Markup(_source(one))]))
    return rows


def _source(one: Input) -> str:
    if not one.given:
        return "<mark>default</mark> of the program"
    if not one.source:
        return '<span class="quiet">not said</span>' if one.counts else ""
    return _ASSUMED.sub(lambda match: f"<mark>{match[0]}</mark>", words(one.source))


def _value(value: Any) -> str:  # noqa: ANN401
    if isinstance(value, Calibrated):
        return f"{value.value:.6g} ({value.min:.6g} to {value.max:.6g})"
    if isinstance(value, tuple):
        return f"{len(value)} values, {min(value):.6g} to {max(value):.6g}"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
