"""What a mapping says of other people's files: which of their columns is which of ours, in what unit, and which rows.

A mapping is either ``stroke_mm=X1,curvature_per_m=kappa``, which renames, or a TOML file with ``[columns]`` and
``[rows]``, which says all there is to say: a column that it does not name is ignored.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from coast_cli.errors import UsageError, nearest
from coast_cli.recordings.table import Dialect

if TYPE_CHECKING:
    from coast_cli.spec.config import Origin
    from coast_cli.spec.positions import Path as Key

Value = str | float
LARGEST_SKIP = 1_000_000
LARGEST_FACTOR = 1e12
SOURCE_KEYS = ("from", "constant", "file", "scale", "offset")
SOURCE_FORMS = (
    '"THEIRS", ["THEIRS", ...], { from = "THEIRS", scale = 1, offset = 0 }, { constant = 1 } or { file = "*_{}" }'
)
ROW_KEYS = ("skip", "comment", "units_row", "names", "where")


@dataclass(frozen=True)
class Source:
    """What one column of ours is made from: columns of the file, a constant, or a part of the file's name.

    Attributes:
        names: columns of the file; several make a text together, joined by an underscore.
        constant: the same text or number in each row.
        pattern: of the file's name without its suffix: ``*`` stands for anything, ``{}`` for the part that is taken.
        scale, offset: value = scale * number + offset, in the unit of our column's name.
        has_scale: whether the mapping says a scale, so that the units of the two names need not agree.
    """

    names: tuple[str, ...] = ()
    constant: Value | None = None
    pattern: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    has_scale: bool = False


@dataclass(frozen=True)
class Filter:
    """Which rows stay: a number from ``low`` to ``high``, or one of ``values``."""

    low: float = float("-inf")
    high: float = float("inf")
    values: tuple[Value, ...] = ()


@dataclass(frozen=True)
class ColumnMapping:
    """A whole mapping.

    Attributes:
        columns: our column -> what it is made from.
        where: their column (or ours) -> which rows stay.
        dialect: how the file is laid out.
        is_whole: whether columns that are not named are ignored; else they are recognised by their own names.
        origin: the file with the places of its keys; None for ``OURS=THEIRS,...``.
    """

    columns: Mapping[str, Source] = field(default_factory=dict)
    where: Mapping[str, Filter] = field(default_factory=dict)
    dialect: Dialect = field(default_factory=Dialect)
    is_whole: bool = False
    origin: Origin | None = None

    def refuse(
        self,
        key: Key,
        message: str,
        *,
        found: object = None,
        allowed: str | None = None,
        hint: str | None = None,
        recording: str = "",
    ) -> NoReturn:
        """Raise what is wrong with a key of the mapping, said of ``recording`` where a file shows it.

        Raises:
            BadInput: placed at the key in the mapping file where there is one, else in the recording.
        """
        from coast_cli.errors import BadInput

        if self.origin is None:
            raise BadInput(message, file=recording or None, key=str(key[-1]), found=found, allowed=allowed, hint=hint)
        raise self.origin.refuse(
            key, f"{recording}: {message}" if recording else message, found=found, allowed=allowed, hint=hint
        )


def as_mapping(columns: Mapping[str, str] | ColumnMapping | None) -> ColumnMapping:
    """Return a mapping from what ``read_recordings`` takes: None, our name -> theirs, or a mapping itself."""
    if isinstance(columns, ColumnMapping):
        return columns
    return ColumnMapping({ours: Source((theirs,)) for ours, theirs in (columns or {}).items()})


def mapping_of(text: str | None) -> ColumnMapping:
    """Return the mapping that a text asks for: ``OURS=THEIRS,...``, or the name of a TOML file.

    Raises:
        UsageError: neither. BadInput: the file says something that a mapping cannot.
    """
    if text is None:
        return ColumnMapping()
    if "=" not in text or (text.endswith(".toml") and Path(text).is_file()):
        if not text.endswith(".toml"):
            _refuse_text(text, text)
        return load_mapping(text)
    renamed: dict[str, str] = {}
    for part in text.split(","):
        ours, equals, theirs = (piece.strip() for piece in part.partition("="))
        if not (ours and equals and theirs) or ours in renamed:
            _refuse_text(text, part)
        renamed[ours] = theirs
    return as_mapping(renamed)


def _refuse_text(text: str, part: str) -> NoReturn:
    allowed = "FILE.toml, or OURS=THEIRS, each of our names once, such as stroke_mm=X1,curvature_per_m=kappa"
    raise UsageError(f"columns {text}: not understood at {part!r}; allowed: {allowed}.")


def load_mapping(path: str | Path) -> ColumnMapping:
    """Read a mapping file: which column of other people's files is which of ours; ``path`` is text or a Path.

    Raises:
        BadInput: with file, line and column of the first thing that is wrong.

    Example:
        >>> coast.load_mapping("no-such.toml")
        Traceback (most recent call last):
        coast_cli.errors.BadInput: no-such.toml: there is no such file.
    """
    from coast_cli.spec.config import Origin
    from coast_cli.spec.load import not_toml, read_text
    from coast_cli.spec.positions import key_positions

    text = read_text(path)
    try:
        document = tomllib.loads(text)
    except ValueError as error:
        raise not_toml(error, text, str(path)) from None
    except RecursionError:
        from coast_cli.errors import BadInput

        raise BadInput("nested too deeply", file=path) from None
    return _Reader(Origin(str(path), key_positions(text), text)).mapping(document)


@dataclass(frozen=True)
class _Reader:
    """Turns a parsed document into a mapping; every refusal is placed at its key."""

    origin: Origin

    def mapping(self, document: Mapping[str, Any]) -> ColumnMapping:
        self._known(document, ("columns", "rows"), ())
        columns = self._table(document, ("columns",))
        rows = self._table(document, ("rows",))
        self._known(rows, ROW_KEYS, ("rows",))
        if not columns:
            raise self.origin.refuse(("columns",), "nothing is mapped", allowed="OURS = THEIRS under [columns]")
        where = self._table(rows, ("rows", "where"))
        return ColumnMapping(
            {ours: self._source(("columns", ours), value) for ours, value in columns.items()},
            {name: self._filter(("rows", "where", name), value) for name, value in where.items()},
            self._dialect(rows),
            is_whole=True,
            origin=self.origin,
        )

    def _table(self, holder: Mapping[str, Any], key: Key) -> Mapping[str, Any]:
        value = holder.get(str(key[-1]), {})
        if not isinstance(value, Mapping):
            raise self.origin.refuse(key, "not a table", found=_shown(value), allowed="a table")
        return value

    def _known(self, table: Mapping[str, Any], known: tuple[str, ...], key: Key) -> None:
        for name in table:
            if name not in known:
                hint = nearest(name, known) or None
                raise self.origin.refuse((*key, name), "there is no such key", allowed=", ".join(known), hint=hint)

    def _source(self, key: Key, value: Any) -> Source:  # noqa: ANN401
        if isinstance(value, str | list):
            return Source(self._names(key, value))
        if not isinstance(value, Mapping):
            hint = f"A constant is {{ constant = {value} }}." if isinstance(value, int | float) else None
            raise self.origin.refuse(key, "not a column", found=_shown(value), allowed=SOURCE_FORMS, hint=hint)
        self._known(value, SOURCE_KEYS, key)
        if len({"from", "constant", "file"} & set(value)) != 1:
            raise self.origin.refuse(key, "made from nothing, or from several", allowed=SOURCE_FORMS)
        scale = self._number((*key, "scale"), value.get("scale", 1.0))
        offset = self._number((*key, "offset"), value.get("offset", 0.0))
        if scale == 0.0:
            raise self.origin.refuse((*key, "scale"), "a scale of zero leaves nothing", found=scale, allowed="not 0")
        names = self._names((*key, "from"), value["from"]) if "from" in value else ()
        pattern = self._text((*key, "file"), value["file"]) if "file" in value else None
        if pattern is not None and pattern.count("{}") != 1:
            raise self.origin.refuse(
                (*key, "file"), "takes one part of the file's name", found=pattern, allowed="{} once"
            )
        constant = self._value((*key, "constant"), value["constant"]) if "constant" in value else None
        return Source(names, constant, pattern, scale, offset, "scale" in value)

    def _filter(self, key: Key, value: Any) -> Filter:  # noqa: ANN401
        if isinstance(value, Mapping):
            self._known(value, ("min", "max"), key)
            low, high = value.get("min", float("-inf")), value.get("max", float("inf"))
            bounds = [
                self._number((*key, name), bound) for name, bound in (("min", low), ("max", high)) if name in value
            ]
            if not bounds or low > high:
                raise self.origin.refuse(key, "keeps no row", allowed="{ min = 1, max = 2 }, or one of them")
            return Filter(float(low), float(high))
        values = value if isinstance(value, list) else [value]
        if not values:
            raise self.origin.refuse(key, "keeps no row", allowed="a value, a list of values, or { min = 1, max = 2 }")
        return Filter(values=tuple(self._value(key, one) for one in values))

    def _dialect(self, rows: Mapping[str, Any]) -> Dialect:
        skip, comment, units_row = rows.get("skip", 0), rows.get("comment"), rows.get("units_row", False)
        if isinstance(skip, bool) or not isinstance(skip, int) or not 0 <= skip <= LARGEST_SKIP:
            allowed = f"a whole number from 0 to {LARGEST_SKIP}: lines before the header"
            raise self.origin.refuse(("rows", "skip"), "not a number of lines", found=_shown(skip), allowed=allowed)
        if comment is not None and not self._text(("rows", "comment"), comment).strip():
            raise self.origin.refuse(("rows", "comment"), "an empty mark", allowed='a mark such as "%"')
        if not isinstance(units_row, bool):
            found = _shown(units_row)
            raise self.origin.refuse(
                ("rows", "units_row"), "neither true nor false", found=found, allowed="true or false"
            )
        names = self._names(("rows", "names"), rows["names"]) if "names" in rows else None
        if names and len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise self.origin.refuse(("rows", "names"), "a name stands twice", found=twice)
        return Dialect(skip, comment, names, units_row=units_row)

    def _names(self, key: Key, value: Any) -> tuple[str, ...]:  # noqa: ANN401
        names = [value] if isinstance(value, str) else value
        if (
            not isinstance(names, list)
            or not names
            or not all(isinstance(name, str) and name.strip() for name in names)
        ):
            raise self.origin.refuse(key, "not a name", found=_shown(value), allowed="a name, or a list of names")
        return tuple(name.strip() for name in names)

    def _text(self, key: Key, value: Any) -> str:  # noqa: ANN401
        if not isinstance(value, str) or not value:
            raise self.origin.refuse(key, "not a text", found=_shown(value), allowed="a text")
        return value

    def _number(self, key: Key, value: Any) -> float:  # noqa: ANN401
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST_FACTOR:
            allowed = f"a number up to {LARGEST_FACTOR:g}"
            raise self.origin.refuse(key, "not such a number", found=_shown(value), allowed=allowed)
        return float(value)

    def _value(self, key: Key, value: Any) -> Value:  # noqa: ANN401
        if isinstance(value, str):
            return value.strip()
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            raise self.origin.refuse(
                key, "neither a number nor a text", found=_shown(value), allowed="a number or a text"
            )
        return self._number(key, value)


def _shown(value: object) -> object:
    return "a table" if isinstance(value, Mapping) else "a list" if isinstance(value, list) else value
