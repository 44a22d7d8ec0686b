"""A MATLAB file (up to v7.2) as a table: vectors of one length are columns, under the names of their variables.

Fields of structures are named ``structure.field``, columns of a matrix ``matrix_1``, ``matrix_2``, ...; a single number
or text is the same in each row.
"""

from __future__ import annotations

import hashlib
import io
import zlib
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from coast_cli.errors import BadInput
from coast_cli.recordings.table import LARGEST_FILE, Table, bytes_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.table import Cells, Floats

COMPRESSED, HEADER, TAG = 15, 128, 8
HDF5 = b"\x89HDF"
MOST_COLUMNS = 10_000
DEEPEST = 8


def read_mat(path: str) -> tuple[Table, tuple[str, ...]]:
    """Read a MATLAB file; return its table and notes on variables that are no columns.

    Raises:
        BadInput: it cannot be read, is of version 7.3, is no MATLAB file, or holds no two vectors of one length.
    """
    data = bytes_of(path)
    if data[:4] == HDF5 or b"MATLAB 7.3" in data[:HEADER]:
        raise BadInput("a MATLAB file of version 7.3", file=path, allowed="up to 7.2", hint="Save it with -v7.")
    _check_size(data, path)
    columns = _columns(_variables(data, path))
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


def _variables(data: bytes, path: str) -> Mapping[str, Any]:
    from scipy.io import loadmat

    try:
        with np.errstate(all="ignore"):
            variables: Mapping[str, Any] = loadmat(io.BytesIO(data), simplify_cells=True)  # type: ignore[arg-type]
    except (MemoryError, RecursionError):
        raise BadInput("too large or too deep a MATLAB file", file=path) from None
    except Exception:  # noqa: BLE001  # scipy raises whatever a damaged file makes it stumble on
        raise BadInput("not a MATLAB file that can be read", file=path, allowed="version 4 to 7.2") from None
    return variables


def _check_size(data: bytes, path: str) -> None:
    """Refuse a file that unpacks to more than may be read at once."""
    at, size = HEADER, len(data)
    order: Literal["big", "little"] = "big" if data[126:128] == b"MI" else "little"
    while at + TAG <= len(data):
        kind, length = (int.from_bytes(data[at + part : at + part + 4], order) for part in (0, 4))
        if kind == COMPRESSED:
            size += _unpacked(data[at + TAG : at + TAG + length])
        if size > LARGEST_FILE:
            raise BadInput("the file unpacks to too much", file=path, allowed=f"at most {LARGEST_FILE // 2**20} MB")
        at += TAG + length


def _unpacked(packed: bytes) -> int:
    size, engine = 0, zlib.decompressobj()
    try:
        while packed and size <= LARGEST_FILE:
            size += len(engine.decompress(packed, 2**20))
            packed = engine.unconsumed_tail
    except zlib.error:
        return size
    return size


def _columns(variables: Mapping[str, Any], above: str = "", depth: int = 0) -> dict[str, Cells | Floats]:
    found: dict[str, Cells | Floats] = {}
    for name, value in variables.items():
        if name.startswith("__") or len(found) > MOST_COLUMNS:
            continue
        if isinstance(value, Mapping):
            if depth < DEEPEST:
                found.update(_columns(value, f"{above}{name}.", depth + 1))
        elif isinstance(value, str):
            found[above + name] = np.array([value.encode("utf-8", "replace")])
        else:
            found.update(_of_array(above + name, np.asarray(value)))
    return found


def _of_array(name: str, values: NDArray[Any]) -> dict[str, Cells | Floats]:
    """Return the columns of an array: one for a vector, several for a matrix, none for what holds no real numbers."""
    if values.size == 0:
        return {}
    if values.dtype.kind == "U" or (values.dtype.kind == "O" and all(isinstance(one, str) for one in values.flat)):
        return {name: np.array([str(one).encode("utf-8", "replace") for one in values.flat])}
    if values.dtype.kind not in "fiub":
        return {}
    numbers = values.astype(np.float64)
    if numbers.ndim < 2 or 1 in numbers.shape:
        return {name: numbers.reshape(-1)} if numbers.ndim <= 2 else {}
    if numbers.ndim > 2 or numbers.shape[1] > MOST_COLUMNS:
        return {}
    return {f"{name}_{index}": np.ascontiguousarray(column) for index, column in enumerate(numbers.T, start=1)}
