"""A stroke table as a C99 header: axes, table, a function that interpolates, its largest error and a checksum."""

from __future__ import annotations

from collections.abc import Sequence
from typing import IO, Any

import numpy as np

from coast_cli.design.stroke_grid import StrokeGrid, TableOrigin
from coast_cli.version import __version__

_LINE = 8  # numbers a line
_LOOK_UP = """
/* The cell of an axis that holds a value, and where in it (0 to 1); values outside are taken at the end. */
static inline int coast_cell(const float *axis, int count, float value, float *part)
{
    int low = 0;
    *part = 0.0f;
    if (count < 2 || value <= axis[0])
        return 0;
    while (low < count - 2 && value >= axis[low + 1])
        low++;
    *part = value >= axis[count - 1] ? 1.0f : (value - axis[low]) / (axis[low + 1] - axis[low]);
    return low;
}

static inline float coast_%(value)s_at(float %(drive)s, float bending_length_mm)
{
    float along, across;
    int column = coast_cell(coast_%(drive)s, COAST_DRIVES, %(drive)s, &along);
    int row = coast_cell(coast_bending_length_mm, COAST_LENGTHS, bending_length_mm, &across);
    int next = row + (COAST_LENGTHS > 1);
    float near = coast_%(value)s[row][column] + along * (coast_%(value)s[row][column + 1] - coast_%(value)s[row][column]);
    float far = coast_%(value)s[next][column] + along * (coast_%(value)s[next][column + 1] - coast_%(value)s[next][column]);
    return near + across * (far - near);
}
"""


def write_c_header(grid: StrokeGrid, origin: TableOrigin, stream: IO[Any]) -> None:
    """Write the header."""
    error = np.nextafter(np.float32(grid.max_error), np.float32(np.inf))
    lines = [
        f"/* {grid.value_name} of {_comment(origin.pair)} over {grid.drive_name} and X2 (mm), on {grid.branch}.",
        f"   Written by coast {__version__} from {_comment(origin.source)}, sha256 {origin.digest}.",
        f"   Between the nodes bilinear: off by at most {grid.told_error} from the model. COAST_CRC32 is of the table",
        "   as little-endian single precision numbers, the bending length slowest. */",
        "#ifndef COAST_STROKE_TABLE_H",
        "#define COAST_STROKE_TABLE_H",
        "",
        "#include <stdint.h>",
        "",
        f"#define COAST_LENGTHS {grid.bending_length_mm.size}",
        f"#define COAST_DRIVES {grid.drive.size}",
        f"#define COAST_MAX_ERROR {_number(error)} /* {grid.told_error} */",
        f"#define COAST_CRC32 0x{grid.checksum:08x}u",
    ]
    if grid.steps is not None and origin.steps_per_mm is not None:
        lines.append(f"#define COAST_STEPS_PER_MM {_number(origin.steps_per_mm)}")
    lines += [
        "",
        *_vector("bending_length_mm", "LENGTHS", grid.bending_length_mm),
        *_vector(grid.drive_name, "DRIVES", grid.drive),
    ]
    lines += _table("float", grid.value_name, [[_number(value) for value in row] for row in grid.value])
    if grid.steps is not None:
        lines += _table("int32_t", "stroke_steps", [[str(int(value)) for value in row] for row in grid.steps])
    stream.write("\n".join(lines) + "\n")
    stream.write(_LOOK_UP % {"value": grid.value_name, "drive": grid.drive_name})
    stream.write("\n#endif\n")


def _vector(name: str, size: str, values: np.ndarray[Any, Any]) -> list[str]:
    return [
        f"static const float coast_{name}[COAST_{size}] = {{",
        *_rows([_number(value) for value in values], "    "),
        "};",
    ]


def _table(kind: str, name: str, rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [f"static const {kind} coast_{name}[COAST_LENGTHS][COAST_DRIVES] = {{"]
    for row in rows:
        lines += ["    {", *_rows(row, "        "), "    },"]
    return [*lines, "};"]


def _rows(values: Sequence[str], indent: str) -> list[str]:
    return [indent + ", ".join(values[first : first + _LINE]) + "," for first in range(0, len(values), _LINE)]


def _number(value: float) -> str:
    """Return a single precision number as C reads it, to its last bit."""
    text = f"{np.float32(value):.9g}"
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def _comment(text: str) -> str:
    """Return a text that ends no comment and holds no line of its own."""
    return "".join(mark if mark.isprintable() else "?" for mark in text).replace("*/", "* /")
