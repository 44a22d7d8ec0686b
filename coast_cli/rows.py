"""What results that are rows have in common in Python: a repr of one screen, a table in a notebook, a DataFrame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

_SHOWN = 10


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


def _shortened(text: str, most: int = 96) -> str:
    return text if len(text) <= most else f"{text[: most - 3]}..."
