"""What results have in common in Python: a repr of one screen, a table in a notebook, a DataFrame, a picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from pathlib import Path

_SHOWN = 10
_WIDTH = 96


class Drawing(Protocol):
    """A picture: it shows itself in a notebook, and goes into a file or onto a figure of matplotlib."""

    def write(self, path: str | Path) -> None:
        """Write it as .png, .svg or .pdf."""

    def render(self, format: str) -> bytes:
        """Return it as the bytes of a ``png``, ``svg`` or ``pdf``."""

    def figure(self) -> Any:  # noqa: ANN401
        """Return it on a new matplotlib Figure."""


class Drawn:
    """A result that draws itself, as its command does."""

    def plot(self, path: str | Path | None = None) -> Drawing:
        """Return the picture of the result; with a path (.png, .svg or .pdf) it is written there too.

        Raises:
            UsageError: matplotlib is not installed, or the suffix is no picture.
        """
        from importlib import import_module

        # What draws stands above all results, so it is looked up when it is asked for.
        picture: Drawing = import_module("coast_cli.output.plots").picture_of(self)
        if path is not None:
            picture.write(path)
        return picture


class Rows:
    """A result whose ``_table()`` says its rows; units are in the names of the columns."""

    def _table(self) -> Sequence[Mapping[str, Any]]:
        """Return the rows, each with the same names."""
        raise NotImplementedError

    def __repr__(self) -> str:
        """Return the first rows in a few lines."""
        return "\n".join(self._lines())

    def _repr_html_(self) -> str:
        """Return the first rows as a table, for a notebook."""
        from html import escape

        rows = self._table()
        names = list(rows[0]) if rows else []
        head = "".join(f"<th>{escape(name)}</th>" for name in names)
        body = "".join(
            "<tr>" + "".join(f"<td>{escape(_written(row[name]))}</td>" for name in names) + "</tr>"
            for row in rows[:_SHOWN]
        )
        return f"<p>{escape(self._title())}</p><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    def to_dataframe(self) -> Any:  # noqa: ANN401
        """Return the rows as a pandas DataFrame, units in the names of its columns.

        Raises:
            UsageError: pandas is not installed.
        """
        from importlib import import_module

        try:
            pandas = import_module("pandas")
        except ImportError:
            from coast_cli.errors import UsageError

            raise UsageError("to_dataframe needs pandas: pip install pandas.") from None
        return pandas.DataFrame(list(self._table()))

    def _title(self) -> str:
        return f"{type(self).__name__}: {len(self._table())} rows"

    def _lines(self) -> Iterator[str]:
        rows = self._table()
        yield self._title()
        for row in rows[:_SHOWN]:
            said = [f"{name} {_written(value)}" for name, value in row.items() if value is not None]
            yield "  " + _shortened(", ".join(said))
        if len(rows) > _SHOWN:
            yield f"  and {len(rows) - _SHOWN} more"


def _written(value: Any) -> str:  # noqa: ANN401
    return f"{value:.5g}" if isinstance(value, float) else "-" if value is None else str(value)


def _shortened(text: str, most: int = _WIDTH) -> str:
    return text if len(text) <= most else f"{text[: most - 3]}..."


def rows_of(columns: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Return columns of one length as rows."""
    plain = [column.tolist() if hasattr(column, "tolist") else column for column in columns.values()]
    return [dict(zip(columns, values, strict=True)) for values in zip(*plain, strict=True)]


def short_repr(self: object) -> str:
    """Return a dataclass in a few lines, for its ``__repr__``: of an array its shape and range, of a part its name."""
    from dataclasses import fields

    parts = ((one.name, getattr(self, one.name)) for one in fields(self))  # type: ignore[arg-type]
    lines = [f"  {name} = {_summary(value)}" for name, value in parts]
    return "\n".join([f"{type(self).__name__}:", *map(_shortened, lines)])


def _summary(value: Any) -> str:  # noqa: ANN401
    if hasattr(value, "shape") and hasattr(value, "dtype") and value.shape:
        return _array_summary(value)
    if hasattr(value, "item"):
        return _written(value.item())
    if isinstance(value, tuple | list):
        inside = ", ".join(_summary(item) for item in value[:_SHOWN])
        return f"({inside}{', ...' if len(value) > _SHOWN else ''})"
    if isinstance(getattr(value, "name", None), str):
        return str(value.name)
    first = (repr(value) if isinstance(value, str) else _written(value)).splitlines()
    return first[0] if first else ""


def _array_summary(values: Any) -> str:  # noqa: ANN401
    """Return the shape of an array and the range of its numbers."""
    size = " x ".join(str(length) for length in values.shape)
    if not values.size or values.dtype.kind not in "fiu":
        return f"array of {size}"
    known = values[abs(values) < float("inf")]
    if not known.size:
        return f"array of {size}, nothing finite"
    low, high = known.min().item(), known.max().item()
    return f"array of {size}, {_written(low)}" + ("" if low == high else f" to {_written(high)}")
