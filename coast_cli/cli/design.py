"""``coast design``: what to cut so that a pair has the figures that are wanted."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, PairOption
from coast_cli.cli.paths import WRITES


def design(
    config: ConfigArgument,
    *,
    target: Annotated[
        list[str], typer.Option(metavar="NAME=VALUE", help="a column of rank-pairs, or stroke_mm; repeatable")
    ],
    vary: Annotated[
        str, typer.Option(metavar="NAME,...", help="what may change: ROLE.depth_mm, .cut_mm, .uncut_mm, ...")
    ] = "outer.depth_mm,middle.depth_mm",
    pair: PairOption = None,
    save: Annotated[
        Path | None,
        typer.Option("--save", metavar="FILE.toml", help="the configuration with the designed pair added"),
        WRITES,
    ] = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> int:
    """Find the depths (and cut, uncut, diameters) that give a pair the wanted figures.

    Ranges are those of [explore]; depths without one stay between the measured samples. Exit 1 when no design reaches
    the targets; the rows then hold the nearest.
    """
    from coast_cli.design.inverse import designed_text, inverse_design
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
    from coast_cli.output.atomic import write_files
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config

    targets = dict(_target(text) for text in target)
    document = load_config(config)
    bench = build(document)
    outer, middle = bench.pair(pair)
    if outer is None:
        raise UsageError(f"--pair {middle}: a design needs an outer and a middle tube; allowed: OUTER/MIDDLE.")
    names = tuple(dict.fromkeys(name.strip() for name in vary.split(",")))
    found = inverse_design(bench, (outer, middle), targets, names)
    if save is not None:
        text = designed_text(bench, (outer, middle), found, str(save))
        write_files({save: lambda stream: stream.write(text)})
    origin = provenance(document, options={"target": targets, "vary": list(names), "pair": f"{outer}/{middle}"})
    write_answer(Answer("design", found.rows, origin, found.notes), format, output or ())
    return 0 if found.reached else 1


def _target(text: str) -> tuple[str, float]:
    from math import isfinite

    from coast_cli.errors import UsageError

    name, _, value = text.partition("=")
    try:
        number = float(value)
    except ValueError:
        number = float("nan")
    if not isfinite(number):
        raise UsageError(f"--target {text}: not understood; allowed: NAME=VALUE, e.g. rigidity_ratio_series=1.5.")
    return name.strip(), number
