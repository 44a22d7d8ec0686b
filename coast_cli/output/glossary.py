"""What every name that a user meets means: effects, configuration keys with their ranges, checks, columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

from coast_cli.output.answer import Row
from coast_cli.output.columns import COLUMNS

if TYPE_CHECKING:
    from coast_cli.effects.effect import Effect, RecordingKind


WHERE: Mapping[RecordingKind, str] = {"joint": "a joint", "shapes": "shapes"}


def look_up(name: str) -> list[Row]:
    """Return the entries of a name, each with the columns of ``coast explain``.

    A key is found by its last part too; an effect answers with its parameters, a table with its keys.
    """
    names = [full for full in glossary() if name in {full, full.rpartition(".")[2]}]
    found = [entry for full in names for entry in glossary()[full]]
    is_effect = any("effect of" in str(entry["kind"]) for entry in found)
    for full, below in glossary().items():
        if any(full.startswith((f"{table}.", f"{table}[].")) for table in (names if not is_effect else [name])):
            found += [entry for entry in below if entry not in found]
    return found


def everything() -> list[Row]:
    """Return every entry, effects first."""
    return [entry for entries in glossary().values() for entry in entries if entry["kind"] != "recording that decides"]


def effect_of(name: str) -> type[Effect] | None:
    """Return the effect of an id, or None where there is none."""
    from coast_cli.effects.catalogue import CATALOGUE

    return CATALOGUE.get(name)


def effect_rows() -> list[Row]:
    """Return every effect with the columns of ``coast effects``, in the order in which they act."""
    from coast_cli.effects.catalogue import CATALOGUE
    from coast_cli.effects.effect import STAGES

    found: list[Row] = [
        {
            "stage": effect.stage,
            "effect": effect.id,
            "of": "both" if len(effect.recordings) > 1 else WHERE[effect.recordings[0]],
            "component": effect.component,
            "kind": effect.kind,
            "title": effect.title,
        }
        for effect in CATALOGUE.values()
    ]
    order: tuple[str, ...] = STAGES
    return sorted(found, key=lambda row: order.index(str(row["stage"])))


def glossary() -> dict[str, list[Row]]:
    """Return all entries by full name."""
    from coast_cli.effects.catalogue import CATALOGUE

    return _glossary(tuple(CATALOGUE))


@cache
def _glossary(effects: tuple[str, ...]) -> dict[str, list[Row]]:
    """Return all entries with these effects, which a user's own may be among."""
    found: dict[str, list[Row]] = {}
    for entry in (*_effects(effects), *_keys(), *_columns()):
        found.setdefault(str(entry["name"]), []).append(entry)
    return found


def _entry(
    name: str,
    kind: str,
    meaning: str,
    *,
    allowed: str | None = None,
    typical: str | None = None,
    source: str | None = None,
) -> Row:
    return {"name": name, "kind": kind, "meaning": meaning, "allowed": allowed, "typical": typical, "source": source}


def _effects(known: tuple[str, ...]) -> Iterator[Row]:
    from coast_cli.effects.catalogue import OF_DEVICES, effects_of
    from coast_cli.effects.effect import declared

    catalogues = [(recording, where, effects_of(recording)) for recording, where in WHERE.items()]
    for recording, where, catalogue in (*catalogues, ("joint", "a transmission", OF_DEVICES)):
        for effect in (e for e in catalogue.values() if e.id in known or e in OF_DEVICES.values()):
            said = declared(effect, recording)
            meaning = f"{said.title} ({effect.component}): {said.equation}"
            yield _entry(effect.id, f"{effect.kind} effect of {where}", meaning, source=said.source)
            yield _entry(effect.id, "recording that decides", said.decided_by)
            for parameter in said.parameters:
                allowed = f"{parameter.low:g} to {parameter.high:g}"
                name = f"{effect.id}.{parameter.name}"
                yield _entry(
                    name, "parameter of an effect", f"of {said.title}", allowed=allowed, source=parameter.source
                )


def _keys() -> Iterator[Row]:
    from coast_cli.spec.schema import config_schema

    schema = config_schema()
    yield from _keys_below("", schema, schema["$defs"], _Reference())


class _Reference:
    """The reference input, which says what is typical and where that comes from."""

    def __init__(self) -> None:
        from coast_cli.output.report_inputs import Sources
        from coast_cli.spec.load import REFERENCE, load_config

        config = load_config(REFERENCE)
        self.document: Any = config.model_dump(exclude_unset=True)
        self.sources = Sources(config)

    def of(self, full: str) -> tuple[str | None, str | None]:
        """Return the value of a key and what the file says of it, or twice None where it has no such key."""
        here, path = self.document, list[str | int]()
        for part in full.replace("[]", ".[]").split("."):
            if part == "NAME" and isinstance(here, dict):
                step: str | int = next(iter(here), "")
            else:
                step = 0 if part == "[]" else part
            try:
                here = here[step]
            except (KeyError, IndexError, TypeError):
                return None, None
            path.append(step)
        if isinstance(here, dict | list | tuple):
            return None, None
        return str(here), self.sources.of(tuple(path)) or None


def _keys_below(prefix: str, table: dict[str, Any], shared: dict[str, Any], reference: _Reference) -> Iterator[Row]:
    for name, key in table.get("properties", {}).items():
        full = f"{prefix}{name}"
        kind = "check" if prefix == "checks." else "configuration key"
        typical, source = reference.of(full)
        meaning = key.get("description", "")
        yield _entry(full, kind, meaning, allowed=_allowed(key), typical=typical, source=source)
        named = next(iter(key.get("patternProperties", {}).values()), key.get("additionalProperties"))
        forms = [(form, "") for form in key.get("oneOf", ()) if all("$ref" in one for one in key["oneOf"])]
        for inner, mark in ((key, ""), *forms, (key.get("items"), "[]."), (named, ".NAME.")):
            link = inner.get("$ref") if isinstance(inner, dict) else None
            if link:
                yield from _keys_below(full + (mark or "."), shared[link.rpartition("/")[2]], shared, reference)


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
