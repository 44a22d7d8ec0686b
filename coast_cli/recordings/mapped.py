"""A file with its columns under our names: the table of a recording, whatever its author called what.

Nothing is converted here: a column keeps the cells of the file, and the table remembers what it was made from, so that
an error in a cell still says the file's own line, column and name.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import nearest
from coast_cli.recordings.columns import Column, key_of, known_names, parse
from coast_cli.recordings.table import CellOrigin, Table, read_table
from coast_cli.units import unit_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.mapping import ColumnMapping, Source
    from coast_cli.recordings.table import Cells, Floats

JOINS = "_"


def read_mapped(path: str | Table, mapping: ColumnMapping) -> tuple[Table, tuple[str, ...], tuple[str, ...]]:
    """Read a file of text or a ``.mat`` file, or take a table that is read, its columns under our names.

    Returns:
        The table; names of columns that a whole mapping leaves out; notes.

    Raises:
        BadInput: the file cannot be read, or the mapping does not go with it.
    """
    notes: tuple[str, ...] = ()
    if isinstance(path, Table):
        table = path
    elif Path(path).suffix.lower() == ".mat":
        from coast_cli.recordings.matlab import read_mat

        table, notes = read_mat(path)
    else:
        table = read_table(path, mapping.dialect)
    table, kept = _only_where(table, mapping)
    if not mapping.columns:
        return table, (), (*notes, *kept)
    made, origins, places = _made(table, mapping)
    used = {source for ours in mapping.columns.values() for source in ours.names} | set(mapping.where)
    ignored = tuple(name for name in table.names if name not in used)
    if mapping.is_whole:
        mapped = replace(table, names=tuple(made), columns=tuple(made.values()), origins=origins)
        return mapped, ignored, (*notes, *kept)
    replaced = {key_of(column) for column in map(_ours, mapping.columns)}
    for index, name in enumerate(table.names):
        column = parse(name)
        if name not in used and name not in made and not (isinstance(column, Column) and key_of(column) in replaced):
            made[name] = table.columns[index]
            origins[name] = CellOrigin(name, places[name])
    return replace(table, names=tuple(made), columns=tuple(made.values()), origins=origins), (), (*notes, *kept)


def short_name(text: str, most: int = 60) -> str:
    """Return a text as far as a sentence has room for it."""
    return text if len(text) <= most else f"{text[:most]}..."


def _ours(name: str) -> Column:
    column = parse(name)
    if not isinstance(column, Column):
        raise TypeError(name)
    return column


def _made(
    table: Table, mapping: ColumnMapping
) -> tuple[dict[str, Cells | Floats], dict[str, CellOrigin], dict[str, int]]:
    """Return our columns and what each was made from, and the place of every column of the file."""
    places = {name: index for index, name in enumerate(table.names, start=1)}
    made: dict[str, Cells | Floats] = {}
    origins: dict[str, CellOrigin] = {}
    for ours, source in mapping.columns.items():
        column = _checked(table, mapping, ours, source)
        if source.names:
            cells = (
                table.columns[places[source.names[0]] - 1] if len(source.names) == 1 else _joined(table, source.names)
            )
        else:
            cells = _repeated(table, mapping, ours, source, is_text=column.is_text)
        made[ours] = cells
        title = " ".join(source.names) or f"{ours} of the mapping"
        place = places[source.names[0]] if source.names else None
        origins[ours] = CellOrigin(title, place, source.scale, source.offset)
    return made, origins, places


def _checked(table: Table, mapping: ColumnMapping, ours: str, source: Source) -> Column:
    key = ("columns", ours)
    column = parse(ours)
    if not isinstance(column, Column):
        swapped = (
            f"Ours comes first: {short_name(source.names[0])}={short_name(ours)}."
            if source.names and parse(source.names[0])
            else None
        )
        allowed = "such as stroke_mm, curvature_per_m, run"
        mapping.refuse(
            key,
            "the mapping names no column of ours" if mapping.origin is None else "no column of ours",
            found=ours,
            allowed=allowed,
            hint=nearest(ours, known_names()) or swapped,
            recording=table.path,
        )
    for name in source.names:
        if name not in table.names:
            mapping.refuse(
                key,
                f"{ours} = {short_name(name)} names a column that the file does not have",
                found=", ".join(table.names),
                hint=nearest(name, table.names) or None,
                recording=table.path,
            )
    if len(source.names) > 1 and not column.is_text:
        allowed = "one column; run may be made of several"
        mapping.refuse(key, "a number made of several columns", found=", ".join(source.names), allowed=allowed)
    if column.is_text and (source.scale, source.offset) != (1.0, 0.0):
        mapping.refuse(key, "a text has no scale", allowed="a column, a list of columns, a constant or the file's name")
    if isinstance(source.constant, str) and not column.is_text:
        mapping.refuse(key, "not a number", found=source.constant, allowed="a number")
    if source.names and not column.is_text and not source.has_scale:
        _check_unit(table, mapping, ours, source.names[0])
    return column


def _check_unit(table: Table, mapping: ColumnMapping, ours: str, theirs: str) -> None:
    """Refuse a column whose name says a unit that is not that of ours."""
    mine, unit = unit_of(ours), unit_of(theirs)
    if mine is None or unit is None or mine == unit:
        return
    (what, suffix, factor), (other, other_suffix, other_factor) = mine, unit
    key = ("columns", ours)
    if what != other:
        hint = f'A conversion is said with a scale: {ours} = {{ from = "{short_name(theirs)}", scale = 1 }}.'
        message = f"{short_name(theirs)} is {other} ({other_suffix[1:]}), and {ours} is {what} ({suffix[1:]})"
        mapping.refuse(key, message, hint=hint, recording=table.path)
    stem = ours.removesuffix(suffix)
    hint = f"Write {stem}{other_suffix} = {short_name(theirs)}, or scale = {other_factor / factor:g}."
    mapping.refuse(key, f"{short_name(theirs)} is in another unit than {ours}", hint=hint, recording=table.path)


def _repeated(table: Table, mapping: ColumnMapping, ours: str, source: Source, *, is_text: bool) -> Cells | Floats:
    """Return a constant, or the part of the file's name that is taken, in each row."""
    count = len(table.line)
    value = source.constant
    if source.pattern is not None:
        stem = Path(table.path).stem
        value = part_of(stem, source.pattern)
        if value is None:
            key, allowed = ("columns", ours, "file"), f"a name such as {source.pattern}"
            mapping.refuse(key, "the file's name is another", found=stem, allowed=allowed, recording=table.path)
    if is_text:
        text = value if isinstance(value, str) else f"{value:g}"
        return np.full(count, text.strip().encode())
    try:
        number = float(value)  # type: ignore[arg-type]
    except ValueError:
        key = ("columns", ours, "file")
        mapping.refuse(key, "that part of the file's name is no number", found=value, recording=table.path)
    return np.full(count, number)


def part_of(name: str, pattern: str) -> str | None:
    """Return what ``{}`` stands for in a name, where ``*`` stands for anything, as little as does; None if it differs."""
    begins, at, taken = 0, 0, ""
    pieces = pattern.replace("{}", "*\0*").split("*")
    waits_for_part = False
    for index, piece in enumerate(pieces):
        if piece == "\0":
            waits_for_part, begins = True, at
            continue
        if index == 0:
            found = 0 if name.startswith(piece) else -1
        elif index == len(pieces) - 1:
            found = len(name) - len(piece) if name.endswith(piece) and len(name) - len(piece) >= at else -1
        else:
            found = name.find(piece, at)
        if found < 0:
            return None
        if waits_for_part:
            taken, waits_for_part = name[begins:found], False
        at = found + len(piece)
    return taken or None


def _joined(table: Table, names: tuple[str, ...]) -> Cells:
    """Return a column that joins the texts of several."""
    count = len(table.line)
    parts = [table.texts(name) for name in names]
    starts = np.unique(np.concatenate([begins for begins, _ in parts]))
    which = [np.searchsorted(begins, starts, side="right") - 1 for begins, _ in parts]
    cells = [
        JOINS.join(texts[row] for (_, texts), row in zip(parts, rows, strict=True)).encode()
        for rows in zip(*(one.tolist() for one in which), strict=True)
    ]
    return np.repeat(np.array(cells, dtype=np.bytes_), np.diff(np.append(starts, count)))


def _only_where(table: Table, mapping: ColumnMapping) -> tuple[Table, tuple[str, ...]]:
    keep: NDArray[np.bool_] = np.ones(len(table.line), dtype=bool)
    for name, wanted in mapping.where.items():
        key = ("rows", "where", name)
        if name not in table.names:
            hint = nearest(name, table.names) or None
            found = ", ".join(table.names)
            mapping.refuse(
                key, "names a column that the file does not have", found=found, hint=hint, recording=table.path
            )
        if wanted.values:
            starts, texts = table.texts(name)
            same = [any(_is_same(text, value) for value in wanted.values) for text in texts]
            keep &= np.repeat(same, np.diff(np.append(starts, len(keep))))
        else:
            values = table.numbers(name, may_be_missing=True)
            keep &= (values >= wanted.low) & (values <= wanted.high)
    if keep.all():
        return table, ()
    if not keep.any():
        mapping.refuse(("rows", "where"), "no row is left", recording=table.path)
    return table.only(keep), (f"{table.path}: {int((~keep).sum())} of {len(keep)} rows are left out by where.",)


def _is_same(text: str, value: str | float) -> bool:
    if isinstance(value, str):
        return text == value
    try:
        return float(text) == value
    except ValueError:
        return False
