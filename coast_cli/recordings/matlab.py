"""A MATLAB file (up to v7.2) as a table: vectors of one length are columns, under the names of their variables.

Fields of structures are named ``structure.field``, columns of a matrix ``matrix_1``, ``matrix_2``, ...; a single number
or text is the same in each row.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.errors import BadInput
from coast_cli.recordings.matlab_elements import Damaged, variables_of
from coast_cli.recordings.table import LARGEST_FILE, Table, bytes_of

if TYPE_CHECKING:
    from coast_cli.recordings.table import Cells, Floats

HDF5 = b"\x89HDF"
MOST_COLUMNS = 10_000


def read_mat(path: str) -> tuple[Table, tuple[str, ...]]:
    """Read a MATLAB file; return its table and notes on variables that are no columns.

    Raises:
        BadInput: it cannot be read, is of version 7.3, is no MATLAB file, or holds no two vectors of one length.
    """
    data = bytes_of(path)
    if data[:4] == HDF5 or b"MATLAB 7.3" in data[:128]:
        raise BadInput("a MATLAB file of version 7.3", file=path, allowed="up to 7.2", hint="Save it with -v7.")
    try:
        columns = _columns(variables_of(data, LARGEST_FILE))
    except Damaged as error:
        raise BadInput(f"not a MATLAB file that can be read: {error}", file=path, allowed="version 4 to 7.2") from None
    lengths = Counter(len(values) for values in columns.values() if len(values) > 1)
    if not lengths:
        raise BadInput(
            "no vector in the file",
            file=path,
            found=", ".join(columns) or "nothing",
            allowed="two vectors of one length",
        )
    count = max(lengths, key=lambda length: (lengths[length], length))
    kept: dict[str, Any] = {
        name: np.repeat(values, count) if len(values) == 1 else values
        for name, values in columns.items()
        if len(values) in (1, count)
    }
    spare = [name for name in columns if name not in kept]
    notes = (f"{path}: {', '.join(spare)} not used: of another length than {count} rows.",) if spare else ()
    digest = hashlib.sha256(data).hexdigest()
    line = np.arange(1, count + 1, dtype=np.int64)
    return Table(path, digest, tuple(kept), 1, line, ".", tuple(kept.values())), notes


def _columns(variables: Mapping[str, Any], above: str = "") -> dict[str, Cells | Floats]:
    found: dict[str, Cells | Floats] = {}
    for name, value in variables.items():
        if len(found) > MOST_COLUMNS:
            break
        if isinstance(value, Mapping):
            found.update(_columns(value, f"{above}{name}."))
        elif isinstance(value, str | list):
            texts = [value] if isinstance(value, str) else value
            found[above + name] = np.array([text.encode("utf-8", "replace") for text in texts], dtype=np.bytes_)
        else:
            found.update(_of_array(above + name, value))
    return found


def _of_array(name: str, values: Floats) -> dict[str, Cells | Floats]:
    """Return the columns of a matrix: one of a vector, several of others, none of an empty one."""
    if values.size == 0 or values.shape[1] > max(MOST_COLUMNS, values.shape[0] == 1 and values.shape[1]):
        return {}
    if 1 in values.shape:
        return {name: values.reshape(-1)}
    return {f"{name}_{index}": np.ascontiguousarray(column) for index, column in enumerate(values.T, start=1)}
