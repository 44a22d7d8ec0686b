"""``coast stroke``: what tendon stroke bends the joint how far, and back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from coast_cli.output.atomic import Writer

from coast_cli.cli.options import FormatOption, PairOption, PlotOption, numbers
from coast_cli.cli.paths import WRITES, Reads

WORKING_COPY = Path("configs/tubes.toml")
FOR_CONTROLLERS = (".h", ".npz")


def _to_write(paths: list[Path] | None) -> list[Path] | None:
    """Refuse files whose suffix says no format before any work is done for them."""
    from coast_cli.output.write import format_of

    for path in paths or ():
        if path.suffix.lower() not in FOR_CONTROLLERS:
            format_of(path)
    return paths


def stroke(
    config: Annotated[
        Path | None,
        typer.Argument(metavar="[CONFIG]", help="configuration; else configs/tubes.toml, else the shipped one"),
        Reads(WORKING_COPY),
    ] = None,
    *,
    kappa: Annotated[str | None, typer.Option(help="curvatures, 1/m: 20 or 20,30 or 0:40:5")] = None,
    x2: Annotated[str, typer.Option("--x2", help="bending lengths, mm: as for --kappa")],
    stroke: Annotated[str | None, typer.Option(help="strokes, mm, instead of curvatures: what they reach")] = None,
    pair: PairOption = None,
    branch: Annotated[
        Literal["load", "release"], typer.Option(help="the way up, or the way back from the largest --kappa")
    ] = "load",
    tolerances: Annotated[
        bool, typer.Option("--tolerances", help="bands also of how the tubes are made, by [tolerances] or its defaults")
    ] = False,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="write a file: .txt, .json, .csv, .md or .tex; .h (C) or .npz for a controller; repeatable",
            callback=_to_write,
        ),
        WRITES,
    ] = None,
) -> None:
    """Print the stroke, tension, strain and tip for curvatures and bending lengths; --stroke inverts.

    Valid for increasing stroke: on release the real joint lags, and --branch release asks a corrected model for it. A
    calibrated or diagnosed model gives its 90 % band.
    """
    from coast_cli.design.bands import alternatives, told_of
    from coast_cli.design.checks import jump_told
    from coast_cli.design.stroke import stroke_table
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer, Columns
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import say, write_answer
    from coast_cli.spec.build import build
    from coast_cli.spec.load import REFERENCE, load_config, load_config_text, read_text
    from coast_cli.units import MILLIMETRE

    if (kappa is None) == (stroke is None):
        raise UsageError("give either --kappa (curvatures) or --stroke (to invert).")
    if config is None and not WORKING_COPY.exists():
        say("no CONFIG given: reading the reference input that ships in the package.")
        document = load_config_text(read_text(REFERENCE), REFERENCE.name)
    else:
        if config is None:
            say(f"no CONFIG given: reading {WORKING_COPY}.")
        document = load_config(config or WORKING_COPY)
    design = build(document)
    joint = design.joint(pair)
    lengths = [value * MILLIMETRE for value in numbers(x2, "--x2")]
    drives = {
        "curvatures": [] if kappa is None else numbers(kappa, "--kappa"),
        "strokes": [] if stroke is None else [value * MILLIMETRE for value in numbers(stroke, "--stroke")],
    }
    others = alternatives(design, pair, tolerances=tolerances)
    steps = None if document.actuator is None else document.actuator.steps_per_mm
    found = stroke_table(
        joint,
        lengths,
        **drives,
        effects=design.effects,
        checks=document.checks,
        alternatives=others,
        steps_per_mm=steps,
        release=branch == "release",
    )
    controller = [path for path in output or () if path.suffix.lower() in FOR_CONTROLLERS]
    beside: Mapping[Path, Writer] = {}
    notes = found.notes
    if controller:
        from coast_cli.design.stroke_grid import stroke_grid
        from coast_cli.output.controller import writers

        grid = stroke_grid(
            joint, lengths, **drives, effects=design.effects, steps_per_mm=steps, release=branch == "release"
        )
        beside = writers(grid, controller, document, design.pair(pair))
        notes = (*notes, f"between the nodes of the controller's table lines are off by at most {grid.told_error}.")
    if plot is not None:
        found.plot(plot)
    notes = (
        *design.notes,
        *design.uncorrected_joint,
        *notes,
        *jump_told(design, pair),
        *told_of(document, tolerances=tolerances),
    )
    options = ({"tolerances": True} if tolerances else {}) | ({"branch": branch} if branch != "load" else {})
    origin = provenance(document, options=options)
    answer = Answer("stroke", Columns(found.columns), origin, notes)
    pages = [path for path in output or () if path not in controller]
    write_answer(answer, format, pages, beside=beside)
