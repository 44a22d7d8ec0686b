"""What every name that a user meets means: effects, configuration keys with their ranges, checks, columns."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from coast_cli.output.answer import Row
from coast_cli.output.columns import COLUMNS


def look_up(name: str) -> list[Row]:
    """Return the entries of a name, each with the columns of ``coast explain``.

    A key is found by its last part too, and an effect answers with its parameters.
    """
    names = [full for full in glossary() if name in {full, full.rpartition(".")[2]}]
    found = [entry for full in names for entry in glossary()[full]]
    if any("effect of" in str(entry["kind"]) for entry in found):
        found += [entry for full, below in glossary().items() if full.startswith(f"{name}.") for entry in below]
    return found


@cache
def glossary() -> dict[str, list[Row]]:
    """Return all entries by full name."""
    found: dict[str, list[Row]] = {}
    for entry in (*_effects(), *_keys(), *_columns()):
        found.setdefault(str(entry["name"]), []).append(entry)
    return found


def _entry(name: str, kind: str, meaning: str, allowed: str | None = None, source: str | None = None) -> Row:
    return {"name": name, "kind": kind, "meaning": meaning, "allowed": allowed, "source": source}


def _effects() -> Iterator[Row]:
    from coast_cli.effects.catalogue import CATALOGUE
    from coast_cli.effects.shapes.catalogue import SHAPE_CATALOGUE

    for where, catalogue in (("a joint", CATALOGUE), ("shapes", SHAPE_CATALOGUE)):
        for effect in catalogue.values():
            meaning = f"{effect.title} ({effect.component}): {effect.equation}"
            yield _entry(effect.id, f"{effect.kind} effect of {where}", meaning, source=effect.source)
            yield _entry(effect.id, "recording that decides", effect.decided_by)
            for parameter in effect.parameters:
                allowed = f"{parameter.low:g} to {parameter.high:g}"
                name = f"{effect.id}.{parameter.name}"
                yield _entry(name, "parameter of an effect", f"of {effect.title}", allowed, parameter.source)


def _keys() -> Iterator[Row]:
    from coast_cli.spec.schema import config_schema

    schema = config_schema()
    yield from _keys_below("", schema, schema["$defs"])


def _keys_below(prefix: str, table: dict[str, Any], shared: dict[str, Any]) -> Iterator[Row]:
    for name, key in table.get("properties", {}).items():
        full = f"{prefix}{name}"
        kind = "check" if prefix == "checks." else "configuration key"
        yield _entry(full, kind, key.get("description", ""), _allowed(key))
        for inner, mark in ((key, ""), (key.get("items"), "[]."), (key.get("additionalProperties"), ".NAME.")):
            reference = inner.get("$ref") if isinstance(inner, dict) else None
            if reference:
                yield from _keys_below(full + (mark or "."), shared[reference.rpartition("/")[2]], shared)


def _allowed(key: dict[str, Any]) -> str | None:
    """Return the range or choices of a key in words, or None where its schema has none."""
    for branch in (key, *key.get("oneOf", ()), *key.get("anyOf", ())):
        if "enum" in branch:
            return " or ".join(map(str, branch["enum"]))
        low = branch.get("minimum", branch.get("exclusiveMinimum"))
        if low is not None and "maximum" in branch:
            word = "above" if "exclusiveMinimum" in branch else "from"
            return f"{word} {low:g} to {branch['maximum']:g}"
    return None


def _columns() -> Iterator[Row]:
    for command, columns in COLUMNS.items():
        for name, meaning in columns.items():
            yield _entry(name, f"column of coast {command}", meaning)
