"""What the columns of a recording mean: from a header's names to quantities, units and the kind of the recording."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from coast_cli.errors import nearest
from coast_cli.units import ANGLE, CURVATURE, FORCE, LENGTH, TIME

if TYPE_CHECKING:
    from collections.abc import Mapping

    from coast_cli.recordings.table import Table

QUANTITIES: dict[str, Mapping[str, float]] = {
    "time": TIME,
    "bending_length": LENGTH,
    "stroke": LENGTH,
    "tension": FORCE,
    "curvature": CURVATURE,
    "bend": ANGLE,
    "x": LENGTH,
    "y": LENGTH,
}
TEXTS = ("run", "outer", "middle", "tube", "natural")
RESPONSES = ("notch", "curvature", "bend")
JOINT = {"run", "time", "outer", "middle", "bending_length", "stroke", "tension", "curvature", "bend", "notch"}
SHAPE = {"run", "outer", "middle", "tube", "natural", "x", "y"}
NOTCH = re.compile(r"notch_(\d{1,6})(?:_(.*))?")
MOST_NAMED = 20  # unknown columns that are named one by one
Kind = Literal["joint", "shape"]


@dataclass(frozen=True)
class Column:
    """A column of the file: its name there, what it is, its factor to SI, and the notch it belongs to."""

    name: str
    quantity: str
    factor: float = 1.0
    notch: int = 0


@dataclass(frozen=True)
class Layout:
    """The columns that are used, by quantity; ``notches`` from the clamp; ``notes`` on those that are not."""

    kind: Kind
    columns: Mapping[str, Column]
    notches: tuple[Column, ...]
    notes: tuple[str, ...]


def known_names() -> list[str]:
    """Return every name a column may have, ``notch_1_deg`` standing for all notches."""
    names = [quantity + suffix for quantity, suffixes in QUANTITIES.items() for suffix in suffixes]
    return [*TEXTS, *names, *("notch_1" + suffix for suffix in ANGLE)]


def find_layout(table: Table, renamed: Mapping[str, str] | None = None) -> Layout:
    """Say which column of a table is which quantity.

    Args:
        table: the file.
        renamed: our name -> the file's own name, from ``--columns``.

    Raises:
        BadInput: a name twice, a unit that is not known, a needed column missing, notches not numbered from 1.
    """
    found, wrong, unknown = _recognise(table, renamed or {})
    kind = _kind(table, found, wrong)
    used = JOINT if kind == "joint" else SHAPE
    _refuse_wrong_units(table, {column.quantity for column in found}, wrong, used)
    unknown += [column.name for column in found if column.quantity not in used] + [name for name, _, _ in wrong]
    columns = _once_each(table, [column for column in found if column.quantity in used and not column.notch])
    notches = _notches(table, [column for column in found if column.notch]) if kind == "joint" else ()
    strangers = [name for name in unknown if name]
    notes = [
        f"{table.path}: column {name!r} is not known and not used. {nearest(name, known_names())}".rstrip()
        for name in strangers[:MOST_NAMED]
    ]
    if len(strangers) > MOST_NAMED:
        notes.append(f"{table.path}: {len(strangers) - MOST_NAMED} more columns are not known and not used.")
    present = [name for name in RESPONSES if name in columns or (name == "notch" and notches)]
    spare = [columns.pop(name).name for name in present[1:]]
    if spare:
        notes.append(f"{table.path}: the response is read from {present[0]}; {', '.join(spare)} is not used.")
    if kind == "joint" and not present:
        raise table.error("no response column", allowed="curvature_per_m, bend_deg or notch_1_deg ... notch_n_deg")
    if kind == "joint" and not {"stroke", "tension"} & set(columns):
        raise table.error("no drive column", allowed="stroke_mm or tension_n")
    return Layout(kind, columns, notches, tuple(notes))


def _recognise(table: Table, renamed: Mapping[str, str]) -> tuple[list[Column], list[tuple[str, str, str]], list[str]]:
    """Return recognised columns, (name, quantity, rest) of names with a unit that is not known, and unknown names."""
    given = _renamed_columns(table, renamed)
    found: list[Column] = []
    wrong: list[tuple[str, str, str]] = []
    unknown: list[str] = []
    replaced = {column.quantity if not column.notch else (column.quantity, column.notch) for column in given}
    taken = {column.name for column in given}
    for name in table.names:
        if name in taken:
            continue
        column = _parse(name)
        if isinstance(column, Column):
            key = column.quantity if not column.notch else (column.quantity, column.notch)
            (unknown.append(name) if key in replaced else found.append(column))
        elif column:
            wrong.append((name, *column))
        else:
            unknown.append(name)
    return given + found, wrong, unknown


def _renamed_columns(table: Table, renamed: Mapping[str, str]) -> list[Column]:
    columns = []
    for ours, theirs in renamed.items():
        column = _parse(ours)
        if not isinstance(column, Column):
            raise table.error(
                "--columns names no column of ours",
                found=ours,
                allowed="such as stroke_mm=X1",
                hint=nearest(ours, known_names())
                or (f"Ours comes first: {theirs}={ours}." if _parse(theirs) else None),
            )
        if theirs in table.names:
            columns.append(Column(theirs, column.quantity, column.factor, column.notch))
        elif ours not in table.names:
            raise table.error(
                f"--columns {ours}={theirs} names a column that the file does not have",
                found=", ".join(table.names),
                hint=nearest(theirs, table.names) or None,
            )
    return columns


def _parse(name: str) -> Column | tuple[str, str] | None:
    """Return the column, (quantity, rest) when only its unit is not known, or None."""
    lower = name.lower()
    if lower in TEXTS:
        return Column(name, lower)
    if match := NOTCH.fullmatch(lower):
        number, unit = int(match[1]), f"_{match[2] or ''}"
        return Column(name, "notch", ANGLE[unit], number) if unit in ANGLE and number else ("notch", unit)
    for quantity, suffixes in QUANTITIES.items():
        if lower == quantity:
            return quantity, ""
        if lower.startswith(quantity + "_"):
            rest = lower[len(quantity) :]
            return Column(name, quantity, suffixes[rest]) if rest in suffixes else (quantity, rest)
    return None


def _kind(table: Table, found: list[Column], wrong: list[tuple[str, str, str]]) -> Kind:
    for quantities in ({column.quantity for column in found}, {quantity for _, quantity, _ in wrong}):
        if quantities & {"stroke", "tension", "curvature", "bend", "notch"}:
            return "joint"
        if quantities & {"x", "y"}:
            return "shape"
    raise table.error(
        "neither a joint recording nor a shape",
        found=", ".join(table.names),
        allowed="a drive and a response (stroke_mm, curvature_per_m), or x_mm and y_mm",
        hint="Foreign names come in with --columns stroke_mm=X1,curvature_per_m=kappa.",
    )


def _refuse_wrong_units(table: Table, found: set[str], wrong: list[tuple[str, str, str]], used: set[str]) -> None:
    for name, quantity, rest in wrong:
        if quantity in used and quantity not in found:
            suffixes = ANGLE if quantity == "notch" else QUANTITIES[quantity]
            raise table.error(
                f"{quantity} {'with a unit that is not known' if rest.strip('_') else 'without a unit'}",
                name=name,
                allowed=" ".join(quantity + suffix for suffix in suffixes),
            )
    if "x" in used:
        for quantity in ("x", "y"):
            if quantity not in found:
                raise table.error("a column is missing", found=", ".join(table.names), allowed=f"{quantity}_mm")


def _once_each(table: Table, columns: list[Column]) -> dict[str, Column]:
    result: dict[str, Column] = {}
    for column in columns:
        if column.quantity in result:
            raise table.error(
                f"{column.quantity} stands in two columns",
                found=f"{result[column.quantity].name}, {column.name}",
                allowed="one of them",
            )
        result[column.quantity] = column
    return result


def _notches(table: Table, columns: list[Column]) -> tuple[Column, ...]:
    ordered = tuple(sorted(columns, key=lambda column: column.notch))
    numbers = [column.notch for column in ordered]
    if numbers != list(range(1, len(numbers) + 1)):
        raise table.error(
            "notch columns must count from 1 at the clamp, each once",
            found=", ".join(map(str, numbers)),
            allowed=f"1 to {len(numbers)}",
        )
    return ordered
