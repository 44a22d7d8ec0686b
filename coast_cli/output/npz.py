"""A stroke table as numpy's .npz: the same bytes for the same table."""

from __future__ import annotations

from io import BytesIO
from typing import IO, Any

import numpy as np

from coast_cli.design.stroke_grid import StrokeGrid, TableOrigin


def write_npz(grid: StrokeGrid, origin: TableOrigin, stream: IO[Any]) -> None:
    """Write axes, table, largest error, checksum and origin; the stream is one of text over one of bytes."""
    arrays: dict[str, Any] = {
        "bending_length_mm": grid.bending_length_mm,
        grid.drive_name: grid.drive,
        grid.value_name: grid.value,
        "max_error": grid.max_error,
        "crc32": np.uint32(grid.checksum),
        "branch": grid.branch,
        "pair": origin.pair,
        "config": origin.source,
        "config_sha256": origin.digest,
    }
    if grid.steps is not None and origin.steps_per_mm is not None:
        arrays |= {"stroke_steps": grid.steps.astype(np.int32), "steps_per_mm": origin.steps_per_mm}
    data = BytesIO()
    np.savez(data, **arrays)
    stream.flush()
    bytes_of: Any = stream
    bytes_of.buffer.write(data.getvalue())
