"""Arguments and options of the commands that read recordings, with one wording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.paths import READS, WRITES

RecordingsArgument = Annotated[
    list[Path], typer.Argument(metavar="RECORDING...", help="recordings (CSV)", show_default=False), READS
]
ColumnsOption = Annotated[
    str | None,
    typer.Option(metavar="OURS=THEIRS,...", help="foreign column names: stroke_mm=X1,curvature_per_m=kappa"),
]
RecordedPairOption = Annotated[
    str | None,
    typer.Option(
        "--pair", metavar="OUTER/MIDDLE", help="tubes of recordings without such columns; default: joint.pair"
    ),
]
BendingLengthOption = Annotated[
    float | None, typer.Option("--x2", metavar="MM", help="bending length of recordings without that column")
]
PlotOption = Annotated[Path | None, typer.Option(metavar="FILE.png", help="draw recording against model"), WRITES]
HoldOutOption = Annotated[
    list[str] | None, typer.Option("--hold-out", metavar="RUN", help="a run that is not fitted; repeatable")
]


def renamed_columns(text: str | None) -> dict[str, str]:
    """Return our column name -> the file's own of ``stroke_mm=X1,curvature_per_m=kappa``.

    Raises:
        UsageError: not of that form, or a name twice.
    """
    from coast_cli.errors import UsageError

    renamed: dict[str, str] = {}
    for part in text.split(",") if text else ():
        ours, equals, theirs = (piece.strip() for piece in part.partition("="))
        if not (ours and equals and theirs) or ours in renamed:
            allowed = "OURS=THEIRS, each of our names once, such as stroke_mm=X1,curvature_per_m=kappa"
            raise UsageError(f"--columns {text}: not understood at {part!r}; allowed: {allowed}.")
        renamed[ours] = theirs
    return renamed
