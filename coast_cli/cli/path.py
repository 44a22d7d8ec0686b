"""``coast path``: the controls of the robot along a planar path, and what of it is out of reach."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from coast_cli.cli.options import ConfigArgument, FormatOption, OutputOption, PairOption, PlotOption
from coast_cli.cli.paths import READS


def path(
    config: ConfigArgument,
    *,
    path: Annotated[
        Path,
        typer.Option(
            metavar="FILE.csv", help="arc_length_mm and curvature_per_m (s_mm, kappa_per_mm), or x_mm and y_mm (z_mm)"
        ),
        READS,
    ],
    pair: PairOption = None,
    model: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="a model with corrections, as --save-model wrote it"), READS
    ] = None,
    within: Annotated[
        float, typer.Option(metavar="MM", min=0.0, help="how far the body may be off the path, mm")
    ] = 1.0,
    points: Annotated[
        int | None, typer.Option(min=2, max=100_000, help="evenly spaced feeds; default: the rows of the file")
    ] = None,
    back: Annotated[bool, typer.Option("--back", help="also draw the robot back through the same feeds")] = False,
    plot: PlotOption = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> int:
    """Print the controls X1 to X4 and psi along a planar path; exit 1 when a row is out of reach.

    X1 is the tendon's stroke, X2 the bending length, X3 how far the outer tube is fed beyond the middle one, X4 how far
    the stage is fed, psi (roll_deg) 0 where the bend is to the left of the path and 180 to the right. The robot follows
    its tip: X1 holds one curvature while X2 grows with X4, then X3 feeds on. The path starts where the robot comes out,
    along its tangent.

    Limits are those of [checks] for stroke and tendon strain, the notches' faces, a set of nitinol, 145 degrees of bend,
    the notched lengths, and --within.
    """
    from math import isfinite

    import numpy as np

    from coast_cli.design.checks import jump_told
    from coast_cli.design.path import plan_path
    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer, Columns
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.recordings.planar_path import read_path
    from coast_cli.spec.build import build
    from coast_cli.spec.load import load_config
    from coast_cli.units import MILLIMETRE

    if not isfinite(within):
        raise UsageError(f"--within {within}: allowed: a length in mm.")
    documents = [load_config(file) for file in (config, model) if file is not None]
    design = build(documents[-1])
    followed = read_path(path)
    feed = followed.rows if points is None else np.linspace(0.0, followed.length, points)
    plan = plan_path(
        design.joint(pair),
        design.effects,
        followed,
        feed,
        within=within * MILLIMETRE,
        checks=design.config.checks,
        back=back,
    )
    if plot is not None:
        plan.plot(plot)
    names = "/".join(name for name in design.pair(pair) if name)
    options = {"pair": names, "within": within, "points": points, "back": back}
    origin = provenance(*documents, recordings=[(followed.source, followed.digest)], options=options)
    notes = (*design.notes, *design.uncorrected_joint, *plan.notes, *jump_told(design, pair))
    write_answer(Answer("path", Columns(plan.columns), origin, notes), format, output or ())
    return 0 if plan.reached else 1
