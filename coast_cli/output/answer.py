"""An answer: rows of named values with the provenance they came from, whatever the format they leave in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Any, overload

from coast_cli.errors import NotConverged

Cell = str | float | int | bool | None
Row = Mapping[str, Cell]


@dataclass(frozen=True)
class Answer:
    """What a command found.

    Attributes:
        command: its name; the JSON schema is ``coast.<command>/1``.
        rows: each with the same names in the same order; None is "no value".
        provenance: from ``coast_cli.output.provenance.provenance``.
        notes: what the user should know besides; they go to stderr and into JSON.
    """

    command: str
    rows: Sequence[Row]
    provenance: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def check_finite(self) -> None:
        """Refuse an answer with a NaN or an infinity in it.

        Raises:
            NotConverged: naming the row and the column.
        """
        for number, row in enumerate(self.rows, start=1):
            if not all(isfinite(value) for value in row.values() if isinstance(value, float)):
                name = next(name for name, value in row.items() if isinstance(value, float) and not isfinite(value))
                raise NotConverged(
                    f"{self.command}: {name} of row {number} is not a finite number ({row[name]}): "
                    "the input lies outside what the model can answer."
                )


class Columns(Sequence[Row]):
    """Rows over equally long columns, made one at a time, so that a million rows cost no more than their columns."""

    def __init__(self, columns: Mapping[str, Sequence[Any]]) -> None:
        self._columns = dict(columns)
        lengths = {len(column) for column in self._columns.values()}
        if len(lengths) > 1:
            raise ValueError(f"columns differ in length: {sorted(lengths)}")
        self._length = lengths.pop() if lengths else 0

    def __len__(self) -> int:
        return self._length

    @overload
    def __getitem__(self, index: int) -> Row: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Row]: ...
    def __getitem__(self, index: int | slice) -> Row | Sequence[Row]:
        if isinstance(index, slice):
            return Columns({name: column[index] for name, column in self._columns.items()})
        return {name: _plain(column[index]) for name, column in self._columns.items()}

    def __iter__(self) -> Iterator[Row]:
        return (self[index] for index in range(self._length))


def _plain(value: Any) -> Any:  # noqa: ANN401
    """Return a numpy scalar as the Python number it holds."""
    return value.item() if hasattr(value, "item") else value
