"""Notch patterns as DXF of release 12, in mm: what every CAM program reads.

Layers: OUTLINE (the unrolled skin), CUT (the laser's path, a closed polyline a notch), NAME (the tube). Tubes lie one above
the other, along the tube in x from the clamp, around it in y from the middle of the notches.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import IO, Any

import numpy as np

from coast_cli.design.pattern import Pattern
from coast_cli.units import MILLIMETRE

_APART, _TEXT = 1.0, 0.3  # mm between tubes; height of a name
_LAYERS = (("OUTLINE", 8), ("CUT", 1), ("NAME", 3))  # and their colours


def write_dxf(patterns: Sequence[Pattern], stream: IO[Any]) -> None:
    """Write the patterns; release 12 knows no units, so that a comment says them."""
    places = np.cumsum([0.0, *(one.circumference / MILLIMETRE + _APART for one in patterns[:-1])]).tolist()
    for code, value in _file(patterns, places):
        stream.write(f"{code}\n{value}\n")


def _file(patterns: Sequence[Pattern], places: Sequence[float]) -> Iterator[tuple[int, str]]:
    yield 999, "lengths in mm"
    yield from ((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"), (0, "ENDSEC"))
    yield from ((0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (70, str(len(_LAYERS))))
    for name, colour in _LAYERS:
        yield from ((0, "LAYER"), (2, name), (70, "0"), (62, str(colour)), (6, "CONTINUOUS"))
    yield from ((0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    for one, place in zip(patterns, places, strict=True):
        length, half = one.length / MILLIMETRE, one.circumference / 2.0 / MILLIMETRE
        yield from _closed("OUTLINE", np.array([(0.0, -half), (length, -half), (length, half), (0.0, half)]), place)
        for path in one.path / MILLIMETRE:
            yield from _closed("CUT", path, place)
        yield from ((0, "TEXT"), (8, "NAME"), *_point(0.0, place + half + 0.1), (40, f"{_TEXT}"), (1, one.name))
    yield from ((0, "ENDSEC"), (0, "EOF"))


def _closed(layer: str, corners: np.ndarray[Any, Any], place: float) -> Iterator[tuple[int, str]]:
    yield from ((0, "POLYLINE"), (8, layer), (66, "1"), *_point(0.0, 0.0), (70, "1"))
    for x, y in corners.tolist():
        yield from ((0, "VERTEX"), (8, layer), *_point(x, y + place))
    yield from ((0, "SEQEND"), (8, layer))


def _point(x: float, y: float) -> tuple[tuple[int, str], ...]:
    return (10, f"{x:.6f}"), (20, f"{y:.6f}"), (30, "0.0")
