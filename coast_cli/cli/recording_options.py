"""Arguments and options of the commands that read recordings, with one wording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.paths import READS, WRITES

RecordingsArgument = Annotated[
    list[Path],
    typer.Argument(metavar="RECORDING...", help="recordings (CSV and other text, .mat)", show_default=False),
    READS,
]
ColumnsOption = Annotated[
    str | None,
    typer.Option(
        metavar="FILE.toml|OURS=THEIRS,...",
        help="what their columns are: stroke_mm=X1, or a mapping file",
    ),
    READS,
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
FromOption = Annotated[
    float | None, typer.Option("--from", metavar="S", help="rows from this time on, in seconds of their clock")
]
ToOption = Annotated[float | None, typer.Option("--to", metavar="S", help="rows up to this time")]
PlotOption = Annotated[Path | None, typer.Option(metavar="FILE.png", help="draw recording against model"), WRITES]
HoldOutOption = Annotated[
    list[str] | None, typer.Option("--hold-out", metavar="RUN", help="a run that is not fitted; repeatable")
]
NoiseOption = Annotated[
    float | None,
    typer.Option("--noise", metavar="VALUE", help="noise of the camera where it is known, in the response's unit"),
]
