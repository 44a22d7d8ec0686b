"""A table that stands in memory: arrays by the names of their columns, or a DataFrame, read as a file of the same cells is.

Nothing is imported for a DataFrame: whatever says its ``columns`` and gives each by its name is one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeGuard, runtime_checkable

import numpy as np

from coast_cli.errors import BadInput
from coast_cli.recordings.table import Table

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from coast_cli.recordings.table import Cells, Floats


@runtime_checkable
class Frame(Protocol):
    """A DataFrame, of whatever library."""

    @property
    def columns(self) -> Any:  # noqa: ANN401  # an index of names
        """Names of the columns."""

    def __getitem__(self, name: Any, /) -> Any:  # noqa: ANN401
        """Return a column by its name."""


ArrayTable = Mapping[str, Any] | Frame  # of numbers, texts, or one of either for the whole column
RecordingSource = str | Path | ArrayTable


def is_table(source: object) -> TypeGuard[ArrayTable]:
    """Return whether a source stands in memory, and is no file."""
    return isinstance(source, Mapping | Frame)


def as_sources(given: RecordingSource | Sequence[RecordingSource]) -> list[RecordingSource]:
    """Return one or several sources as a list."""
    return [given] if isinstance(given, str | Path | Mapping | Frame) else list(given)


def name_of(source: RecordingSource, index: int, count: int) -> str:
    """Return what errors and answers call a source: a file by its path, a table by what it is."""
    if not is_table(source):
        return str(source)
    what = "arrays" if isinstance(source, Mapping) else "DataFrame"
    return f"<{what}>" if count == 1 else f"<{what} {index + 1}>"


def table_of(source: ArrayTable, name: str) -> Table:
    """Return columns of one length as a table; its lines are the rows, counted from 1.

    A number alone, or a text, stands for the whole column.

    Raises:
        BadInput: no columns or no rows, columns of several lengths, or one that is not a row of numbers or texts.
    """
    names = [str(column) for column in (source if isinstance(source, Mapping) else source.columns)]
    twice = next((column for column in names if names.count(column) > 1), None)
    if twice is not None:
        raise BadInput("two columns have the same name", file=name, found=twice)
    raw = {column: _cells(source[key], column, name) for column, key in zip(names, _keys(source), strict=True)}
    lengths = {column: len(cells) for column, cells in raw.items() if cells.ndim}
    count = max(lengths.values(), default=0)
    if count == 0:
        raise BadInput("no rows", file=name, allowed="columns by name, of two rows or more")
    for column, length in lengths.items():
        if length != count:
            raise BadInput("a column of another length", file=name, key=column, found=length, allowed=str(count))
    columns = tuple(_repeated(cells, count) for cells in raw.values())
    digest = hashlib.sha256()
    for column, cells in zip(names, columns, strict=True):
        digest.update(column.encode())
        digest.update(cells.tobytes())
    lines = np.arange(1, count + 1, dtype=np.int64)
    return Table(name, digest.hexdigest(), tuple(names), 0, lines, ".", columns)


def _keys(source: ArrayTable) -> Iterable[Any]:
    return source if isinstance(source, Mapping) else source.columns


def _cells(values: Any, column: str, name: str) -> Cells | Floats:  # noqa: ANN401
    """Return a column as numbers, or as the texts that a file would hold; what is missing is an empty text."""
    array: NDArray[Any] = np.asarray(values)
    if array.ndim > 1:
        raise BadInput("not one row of values", file=name, key=column, found=f"shape {array.shape}", allowed="(n,)")
    if array.dtype.kind in "fiu":
        return array.astype(np.float64)
    if array.dtype.kind not in "UOST":
        allowed = "numbers, or texts"
        raise BadInput("neither numbers nor texts", file=name, key=column, found=str(array.dtype), allowed=allowed)
    texts = [_text(value).encode() for value in array.ravel().tolist()]
    cells: Cells = np.array(texts, dtype=np.bytes_).reshape(array.shape)
    return cells


def _repeated(cells: Cells | Floats, count: int) -> Cells | Floats:
    """Return a column; what stands alone is in every row."""
    if cells.ndim:
        return cells
    alone: Any = np.full(count, cells.item(), dtype=cells.dtype)
    return alone  # type: ignore[no-any-return]


def _text(value: object) -> str:
    """Return a value as a file would hold it; what is missing, by whatever mark, is empty."""
    missing = value is None or str(value) in {"nan", "<NA>", "NaT"}
    return "" if missing else value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
