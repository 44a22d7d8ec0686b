"""What the columns of a recording mean: from a header's names to quantities, units and the kind of the recording."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from coast_cli.errors import nearest
from coast_cli.units import ANGLE, CURVATURE, FORCE, LENGTH, MOMENT, TIME

if TYPE_CHECKING:
    from collections.abc import Mapping

    from coast_cli.recordings.model import ResponseKind
    from coast_cli.recordings.table import Table

QUANTITIES: dict[str, Mapping[str, float]] = {  # by what a column's name begins with; `load` is both of its kinds
    "time": TIME,
    "bending_length": LENGTH,
    "stroke": LENGTH,
    "tension": FORCE,
    "curvature": CURVATURE,
    "bend": ANGLE,
    "position": LENGTH,
    "force": FORCE,
    "load": FORCE | MOMENT,
    "x": LENGTH,
    "y": LENGTH,
}
TEXTS = ("run", "outer", "middle", "tube", "natural")
RESPONSES: tuple[ResponseKind, ...] = ("notch", "curvature", "bend", "position", "force")
DRIVES = ("stroke", "tension")
JOINT = {"run", "time", "outer", "middle", "bending_length", "load", "load_moment", *DRIVES, *RESPONSES}
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

    @property
    def is_text(self) -> bool:
        """Whether its cells are names, not numbers."""
        return self.quantity in TEXTS


@dataclass(frozen=True)
class ColumnLayout:
    """The columns that are used, by quantity; ``notches`` from the clamp; ``notes`` on those that are not."""

    kind: Kind
    columns: Mapping[str, Column]
    notches: tuple[Column, ...]
    notes: tuple[str, ...]


def known_names() -> list[str]:
    """Return every name a column may have, ``notch_1_deg`` standing for all notches."""
    names = [quantity + suffix for quantity, suffixes in QUANTITIES.items() for suffix in suffixes]
    return [*TEXTS, *names, *("notch_1" + suffix for suffix in ANGLE)]


def find_layout(table: Table) -> ColumnLayout:
    """Say which column of a table is which quantity.

    Raises:
        BadInput: a name twice, a unit that is not known, a needed column missing, notches not numbered from 1.
    """
    found, wrong, unknown = _recognise(table)
    kind = _kind(table, found, wrong)
    used = JOINT if kind == "joint" else SHAPE
    _refuse_wrong_units(table, {column.quantity for column in found}, wrong, kind)
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
        allowed = "curvature_per_m, bend_deg or notch_1_deg ... notch_n_deg; position_mm or force_n of other devices"
        raise table.error("no response column", allowed=allowed)
    if kind == "joint" and not {"stroke", "tension"} & set(columns):
        raise table.error("no drive column", allowed="stroke_mm or tension_n")
    return ColumnLayout(kind, columns, notches, tuple(notes))


def _recognise(table: Table) -> tuple[list[Column], list[tuple[str, str, str]], list[str]]:
    """Return recognised columns, (name, quantity, rest) of names with a unit that is not known, and unknown names."""
    found: list[Column] = []
    wrong: list[tuple[str, str, str]] = []
    unknown: list[str] = []
    for name in table.names:
        column = parse(name)
        if isinstance(column, Column):
            found.append(column)
        elif column:
            wrong.append((name, *column))
        else:
            unknown.append(name)
    return found, wrong, unknown


def key_of(column: Column) -> tuple[str, int]:
    """Return what no two columns of a recording may both be: the quantity, and the notch it belongs to."""
    return column.quantity, column.notch


def parse(name: str) -> Column | tuple[str, str] | None:
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
            what = "load_moment" if quantity == "load" and rest in MOMENT else quantity
            return Column(name, what, suffixes[rest]) if rest in suffixes else (quantity, rest)
    return None


def _kind(table: Table, found: list[Column], wrong: list[tuple[str, str, str]]) -> Kind:
    for quantities in ({column.quantity for column in found}, {quantity for _, quantity, _ in wrong}):
        if quantities & {*DRIVES, *RESPONSES}:
            return "joint"
        if quantities & {"x", "y"}:
            return "shape"
    raise table.error(
        "neither a joint recording nor a shape",
        found=", ".join(table.names),
        allowed="a drive and a response (stroke_mm, curvature_per_m), or x_mm and y_mm",
        hint="Foreign names come in by a mapping of columns: stroke_mm=X1,curvature_per_m=kappa, or FILE.toml; "
        "`coast guide foreign` shows how.",
    )


def _refuse_wrong_units(table: Table, found: set[str], wrong: list[tuple[str, str, str]], kind: Kind) -> None:
    """Refuse a unit that is not known where the column is needed; elsewhere the column is not used, and that is said."""
    needed = [DRIVES, RESPONSES, ("bending_length",)] if kind == "joint" else [("x",), ("y",)]
    missing = {name for group in needed if not found & set(group) for name in group}
    for name, quantity, rest in wrong:
        if quantity in missing:
            suffixes = ANGLE if quantity == "notch" else QUANTITIES[quantity]
            raise table.error(
                f"{quantity} {'with a unit that is not known' if rest.strip('_') else 'without a unit'}",
                name=name,
                allowed=" ".join(quantity + suffix for suffix in suffixes),
            )
    if kind == "shape":
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
