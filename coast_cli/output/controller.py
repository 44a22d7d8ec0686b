"""Files for controllers: which writer a suffix asks for, and where the table comes from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from coast_cli.design.stroke_grid import StrokeGrid, TableOrigin
from coast_cli.output.atomic import Writer
from coast_cli.output.c_header import write_c_header
from coast_cli.output.npz import write_npz
from coast_cli.spec.config import Config
from coast_cli.spec.digest import config_digest

_WRITERS = {".h": write_c_header, ".npz": write_npz}


def writers(
    grid: StrokeGrid, paths: Sequence[Path], config: Config, pair: tuple[str | None, str]
) -> Mapping[Path, Writer]:
    """Return what writes a table to each path."""
    origin = TableOrigin(
        pair="/".join(name for name in pair if name),
        source=config.source or "<text>",
        digest=config_digest(config),
        steps_per_mm=None if config.actuator is None else config.actuator.steps_per_mm,
    )
    return {path: partial(_WRITERS[path.suffix.lower()], grid, origin) for path in paths}
