"""Arguments and options that several commands share, with one wording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.paths import READS, WRITES


def _to_write(paths: list[Path] | None) -> list[Path] | None:
    """Refuse files whose suffix says no format before any work is done for them."""
    from coast_cli.output.write import format_of

    for path in paths or ():
        format_of(path)
    return paths


def _to_draw(path: Path | None) -> Path | None:
    """Refuse a picture that cannot be drawn before any work is done for it."""
    if path is not None:
        from coast_cli.output.atomic import check_suffix
        from coast_cli.output.picture import FORMATS, require_matplotlib

        check_suffix("--plot", path, FORMATS)
        require_matplotlib()
    return path


ConfigArgument = Annotated[
    Path, typer.Argument(metavar="CONFIG", help="configuration (TOML)", show_default=False), READS
]
ConfigsArgument = Annotated[
    list[Path], typer.Argument(metavar="CONFIG", help="configurations (TOML)", show_default=False), READS
]
FormatOption = Annotated[
    str | None, typer.Option("--format", "-f", metavar="FORMAT", help="table, json, csv, markdown or latex, to stdout")
]
OutputOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="write a file: .txt, .json, .csv, .md or .tex; repeatable",
        callback=_to_write,
    ),
    WRITES,
]
PairOption = Annotated[
    str | None, typer.Option("--pair", metavar="OUTER/MIDDLE", help="the pair, or one tube; default: joint.pair")
]
PlotOption = Annotated[
    Path | None,
    typer.Option("--plot", metavar="FILE", help="also draw a picture: .png, .svg or .pdf", callback=_to_draw),
    WRITES,
]


def numbers(text: str, option: str) -> list[float]:
    """Return the numbers of ``20``, ``20,30`` or ``0:40:5`` (both ends included), in the order given.

    Raises:
        UsageError: not such a list, not finite, or too long.
    """
    from coast_cli.errors import UsageError

    values: list[float] = []
    for part in text.split(","):
        try:
            values.extend(_range(*map(float, part.split(":"))) if ":" in part else [float(part)])
        except (ValueError, TypeError, OverflowError):
            allowed = "a number, a list 20,30 or a range start:stop:step"
            raise UsageError(f"{option} {text}: not understood; allowed: {allowed}.") from None
    if not all(abs(value) < float("inf") for value in values):
        raise UsageError(f"{option} {text}: not finite.")
    return values


def _range(start: float, stop: float, step: float) -> list[float]:
    steps = (stop - start) / step if step else -1.0
    if not 0.0 <= steps < 1e6:
        raise ValueError
    return [start + index * step for index in range(int(steps + 1e-9) + 1)]
