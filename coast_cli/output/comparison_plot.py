"""Plots of recordings against a model, residuals below, as in P's Figures 7 and 9."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.output.picture import COLOURS, RECORDED, Picture
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.diagnosis.compare import Comparison, JointErrors, ShapeErrors

MOST_PANELS = 12
PANEL_INCHES = (4.0, 3.6)
RESPONSES = {
    "curvature": ("curvature (1/m)", 1.0),
    "bend": ("bend (deg)", DEGREE),
    "notch": ("notch bend (deg)", DEGREE),
}
DIRECTIONS = ((1, "load", COLOURS[0]), (-1, "release", COLOURS[1]), (0, "hold", COLOURS[2]))
_MODEL = "black"


def plot_comparison(comparison: Comparison) -> tuple[Picture, tuple[str, ...]]:
    """Draw each run over its drive, load and release apart, the model as a line, residuals below; return notes too."""
    runs: list[JointErrors | ShapeErrors] = [*comparison.joint, *comparison.shape]
    shown = runs[:MOST_PANELS]
    columns = min(len(shown), 4)
    rows = -(-len(shown) // columns)

    def paint(figure: Any) -> None:  # noqa: ANN401
        panels = np.atleast_1d(figure.subfigures(rows, columns)).ravel()
        for panel, one in zip(panels, shown, strict=False):
            above, below = panel.subplots(2, 1, sharex=True, height_ratios=(3, 1))
            draw: Any = _joint if hasattr(one, "predicted") else _shape
            draw(one, above, below)
            above.set_title(one.run.name)

    picture = Picture((PANEL_INCHES[0] * columns, PANEL_INCHES[1] * rows), paint)
    return picture, (f"the picture shows the first {MOST_PANELS} of {len(runs)} runs.",) if len(runs) > len(
        shown
    ) else ()


def _joint(one: JointErrors, above: Any, below: Any) -> None:  # noqa: ANN401
    run = one.run
    label, unit = RESPONSES[run.kind]
    drive = run.drive / MILLIMETRE if run.stroke is not None else run.drive
    for direction, name, colour in DIRECTIONS:
        rows = run.direction == direction
        if rows.any():
            above.plot(drive[rows], run.response[rows] / unit, ".", ms=3, color=colour, alpha=0.6)
            above.plot([], [], ".", color=colour, label=name)
            below.plot(drive[rows], -one.difference[rows] / unit, ".", ms=3, color=colour, alpha=0.6)
    above.plot(drive, one.predicted / unit, "-", lw=1.0, color=_MODEL)
    above.plot([], [], "-", color=_MODEL, label="model")
    above.legend()
    above.set_ylabel(label)
    below.axhline(0.0, lw=0.5, color="black")
    below.set_ylabel("residual")
    below.set_xlabel("stroke X1 (mm)" if run.stroke is not None else "tension (N)")


def _shape(one: ShapeErrors, above: Any, below: Any) -> None:  # noqa: ANN401
    run = one.run
    above.plot(run.x / MILLIMETRE, run.y / MILLIMETRE, ".", ms=4, color=RECORDED, label="recorded")
    above.plot(one.x / MILLIMETRE, one.y / MILLIMETRE, "-", lw=1.0, color=_MODEL, label="model")
    above.legend()
    above.set_ylabel("y (mm)")
    below.plot(run.x / MILLIMETRE, one.distance / MILLIMETRE, ".", ms=4, color=_MODEL)
    below.set_ylabel("distance (mm)")
    below.set_xlabel("x (mm)")
