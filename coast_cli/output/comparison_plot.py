"""Plots of recordings against a model, residuals below, as in P's Figures 7 and 9."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.output.picture import COLOURS, RECORDED, Picture
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from coast_cli.diagnosis.compare import JointErrors, ModelComparison, ShapeErrors

MOST_PANELS = 12
PANEL_INCHES = (4.0, 3.6)
RESPONSES = {
    "curvature": ("curvature (1/m)", 1.0),
    "bend": ("bend (deg)", DEGREE),
    "notch": ("notch bend (deg)", DEGREE),
    "position": ("position (mm)", MILLIMETRE),
    "force": ("force (N)", 1.0),
}
DIRECTIONS = ((1, "load", COLOURS[0]), (-1, "release", COLOURS[1]), (0, "hold", COLOURS[2]))
_MODELS = ("black", *COLOURS[3:])


def plot_comparison(comparison: ModelComparison) -> tuple[Picture, tuple[str, ...]]:
    """Draw each run over its drive, load and release apart, a line a model, residuals below; return notes too."""
    names = [Path(name).stem for name, _ in comparison.models]
    by_model = [[*one.joint, *one.shape] for _, one in comparison.models]
    runs: list[tuple[JointErrors | ShapeErrors, ...]] = list(zip(*by_model, strict=True))
    shown = runs[:MOST_PANELS]
    columns = min(len(shown), 4)
    rows = -(-len(shown) // columns)

    def paint(figure: Any) -> None:  # noqa: ANN401
        panels = np.atleast_1d(figure.subfigures(rows, columns)).ravel()
        for panel, several in zip(panels, shown, strict=False):
            above, below = panel.subplots(2, 1, sharex=True, height_ratios=(3, 1))
            draw: Any = _joint if hasattr(several[0], "predicted") else _shape
            draw(several, names if len(names) > 1 else ["model"], above, below)
            above.set_title(several[0].run.name)

    picture = Picture((PANEL_INCHES[0] * columns, PANEL_INCHES[1] * rows), paint)
    return picture, (f"the picture shows the first {MOST_PANELS} of {len(runs)} runs.",) if len(runs) > len(
        shown
    ) else ()


def _joint(several: Sequence[JointErrors], names: Sequence[str], above: Any, below: Any) -> None:  # noqa: ANN401
    run = several[0].run
    label, unit = RESPONSES[run.kind]
    drive = run.drive / MILLIMETRE if run.stroke is not None else run.drive
    for direction, name, colour in DIRECTIONS:
        rows = run.direction == direction
        if rows.any():
            above.plot(drive[rows], run.response[rows] / unit, ".", ms=3, color=colour, alpha=0.6)
            above.plot([], [], ".", color=colour, label=name)
            if len(several) == 1:
                below.plot(drive[rows], -several[0].difference[rows] / unit, ".", ms=3, color=colour, alpha=0.6)
    for one, name, colour in zip(several, names, _colours(len(several)), strict=True):
        above.plot(drive, one.predicted / unit, "-", lw=1.0, color=colour)
        above.plot([], [], "-", color=colour, label=name)
        if len(several) > 1:
            below.plot(drive, -one.difference / unit, ".", ms=2, color=colour, alpha=0.6)
    above.legend()
    above.set_ylabel(label)
    below.axhline(0.0, lw=0.5, color="black")
    below.set_ylabel("residual")
    below.set_xlabel("stroke X1 (mm)" if run.stroke is not None else "tension (N)")


def _shape(several: Sequence[ShapeErrors], names: Sequence[str], above: Any, below: Any) -> None:  # noqa: ANN401
    run = several[0].run
    above.plot(run.x / MILLIMETRE, run.y / MILLIMETRE, ".", ms=4, color=RECORDED, label="recorded")
    for one, name, colour in zip(several, names, _colours(len(several)), strict=True):
        above.plot(one.x / MILLIMETRE, one.y / MILLIMETRE, "-", lw=1.0, color=colour, label=name)
        below.plot(run.x / MILLIMETRE, one.distance / MILLIMETRE, ".", ms=4, color=colour)
    above.legend()
    above.set_ylabel("y (mm)")
    below.set_ylabel("distance (mm)")
    below.set_xlabel("x (mm)")


def _colours(count: int) -> list[str]:
    """Return a colour for each model, none of them that of a direction; black first."""
    return [_MODELS[index % len(_MODELS)] for index in range(count)]
