"""The variables of a MATLAB file, versions 4 to 7.2: real arrays, texts, structures and lists of texts; the rest is left out.

Written against MATLAB's "MAT-File Format" (R2023). ``scipy.io`` reads the same and more, but a damaged file can crash
the whole program in it; here every length is checked against the bytes that are there.
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

Variables = dict[str, Any]  # arrays of real numbers [rows, columns], texts, lists of texts, and structures of them

HEADER, TAG = 128, 8
MATRIX, COMPRESSED = 14, 15
NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
CELL, STRUCTURE, CHARACTERS, NUMERIC = 1, 2, 4, range(6, 16)
IS_COMPLEX, IS_LOGICAL = 0x0800, 0x0200
OLD_NUMBERS = ("f8", "f4", "i4", "i2", "u2", "u1")
DEEPEST = 8
MOST_FIELDS = 10_000


class Damaged(ValueError):
    """The bytes are no MATLAB file, or do not hold what they say; the message is one clause."""


def variables_of(data: bytes, most_bytes: int) -> Variables:
    """Return the variables of a file by name.

    Args:
        data: the file. most_bytes: that its compressed parts may unpack to, together.

    Raises:
        Damaged: it is none, it ends too early, or it unpacks to more.
    """
    if len(data) < HEADER or 0 in data[:4]:
        return _old(data)
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None:
        raise Damaged("no MATLAB file")
    found: Variables = {}
    left = most_bytes
    for kind, part in _elements(memoryview(data)[HEADER:], order):
        content = part
        if kind == COMPRESSED:
            unpacked = _unpacked(part, left)
            left -= len(unpacked)
            kind, content = next(_elements(memoryview(unpacked), order), (0, part))  # noqa: PLW2901
        if kind == MATRIX and len(content):
            name, value = _matrix(content, order, 0)
            if value is not None:
                found[name] = value
    return found


def _unpacked(packed: memoryview, most: int) -> bytes:
    engine = zlib.decompressobj()
    try:
        text = engine.decompress(packed, max(most, 1))
    except zlib.error:
        raise Damaged("a compressed part is damaged") from None
    if engine.unconsumed_tail:
        raise Damaged("the file unpacks to too much")
    return text


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Yield (type, content) of the elements that follow one another; small ones share eight bytes with their tag."""
    at = 0
    while at + TAG <= len(data):
        kind, length = (int(value) for value in np.frombuffer(data[at : at + TAG], f"{order}u4"))
        if kind >> 16:
            kind, length, start, step = kind & 0xFFFF, kind >> 16, at + 4, TAG
            if length > 4:
                raise Damaged("a small element is too long")
        else:
            start, step = at + TAG, TAG + (length if kind == COMPRESSED else -(-length // 8) * 8)
        if start + length > len(data):
            raise Damaged("the file ends too early")
        yield kind, data[start : start + length]
        at += step


def _matrix(data: memoryview, order: str, depth: int) -> tuple[str, Any]:
    """Return (name, value) of a matrix; None for what holds no real numbers and no text."""
    parts = _elements(data, order)
    flags = _numbers(*_next(parts), order)
    size = _numbers(*_next(parts), order).astype(np.int64)
    name = _text(*_next(parts), order)
    if not len(flags) or not 2 <= len(size) <= 32 or (size < 0).any():
        raise Damaged("a matrix without a size")
    kind = int(flags[0]) & 0xFF
    count = 1
    for extent in size.tolist():
        count *= extent
    if kind in NUMERIC and not int(flags[0]) & IS_COMPLEX and len(size) == 2:
        values = _numbers(*_next(parts), order)
        if len(values) != count:
            raise Damaged("a matrix of another size than it says")
        return name, values.astype(np.float64).reshape(tuple(size.tolist()), order="F")
    if kind == CHARACTERS and size[0] <= 1:
        return name, _text(*_next(parts), order) if count else ""
    if depth >= DEEPEST:
        return name, None
    if kind == CELL and 0 < count <= MOST_FIELDS:
        cells = [_matrix(content, order, depth + 1)[1] for _, content in parts if len(content)]
        return name, cells if len(cells) == count and all(isinstance(cell, str) for cell in cells) else None
    if kind == STRUCTURE and count == 1:
        return name, _structure(parts, order, depth)
    return name, None


def _structure(parts: Iterator[tuple[int, memoryview]], order: str, depth: int) -> Variables:
    widths = _numbers(*_next(parts), order)
    _, names = _next(parts)
    width = int(widths[0]) if len(widths) else 0
    if not 0 < width <= 256 or len(names) // width > MOST_FIELDS:
        raise Damaged("a structure without names")
    found: Variables = {}
    for at in range(0, len(names) - width + 1, width):
        _, content = _next(parts)
        value = _matrix(content, order, depth + 1)[1] if len(content) else None
        if value is not None:
            found[bytes(names[at : at + width]).split(b"\0")[0].decode("latin-1")] = value
    return found


def _next(parts: Iterator[tuple[int, memoryview]]) -> tuple[int, memoryview]:
    try:
        return next(parts)
    except StopIteration:
        raise Damaged("the file ends too early") from None


def _numbers(kind: int, data: memoryview, order: str) -> NDArray[Any]:
    if kind not in NUMBERS:
        raise Damaged("numbers of a type that is not known")
    dtype = np.dtype(order + NUMBERS[kind])
    return np.frombuffer(data[: len(data) // dtype.itemsize * dtype.itemsize], dtype)


def _text(kind: int, data: memoryview, order: str) -> str:
    coding = TEXTS.get(kind)
    if coding is None:
        raise Damaged("a text of a type that is not known")
    wide = {"<": "-le", ">": "-be"}[order] if coding.endswith(("16", "32")) else ""
    return bytes(data).decode(coding + wide, "replace")


def _old(data: bytes) -> Variables:
    """Return the variables of version 4: five numbers, a name and the values, one after another."""
    order = "<" if len(data) >= 4 and int.from_bytes(data[:4], "little") < 5000 else ">"
    found: Variables = {}
    at = 0
    while at < len(data):
        if at + 20 > len(data):
            raise Damaged("the file ends too early")
        kind, rows, columns, is_complex, length = (int(v) for v in np.frombuffer(data[at : at + 20], f"{order}i4"))
        precision, form = kind // 10 % 10, kind % 10
        if (
            min(kind, rows, columns, length) < 0
            or kind >= 5000
            or precision >= len(OLD_NUMBERS)
            or is_complex not in (0, 1)
        ):
            raise Damaged("no MATLAB file")
        dtype = np.dtype(order + OLD_NUMBERS[precision])
        start = at + 20 + length
        stop = start + rows * columns * dtype.itemsize * (1 + is_complex)
        if stop > len(data):
            raise Damaged("the file ends too early")
        name = data[at + 20 : start].split(b"\0")[0].decode("latin-1")
        if form == 0 and not is_complex:
            found[name] = np.frombuffer(data[start:stop], dtype).astype(np.float64).reshape((rows, columns), order="F")
        elif form == 1 and rows == 1:
            codes = np.frombuffer(data[start:stop], dtype).astype(np.float64)
            found[name] = "".join(chr(int(code)) if 0 < code < 256 else "?" for code in codes)
        at = stop
    if not found:
        raise Damaged("no MATLAB file")
    return found
