"""Plots of recordings against a model, residuals below, as in P's Figures 7 and 9; matplotlib is the [plot] extra."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.errors import UsageError
from coast_cli.output.atomic import write_files
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.diagnosis.compare import Comparison, JointErrors, ShapeErrors

FORMATS = (".png", ".pdf", ".svg")
MOST_PANELS = 12
PANEL_INCHES = (4.0, 3.6)
RESPONSES = {
    "curvature": ("curvature (1/m)", 1.0),
    "bend": ("bend (deg)", DEGREE),
    "notch": ("notch bend (deg)", DEGREE),
}
DIRECTIONS = ((1, "load", "tab:blue"), (-1, "release", "tab:orange"), (0, "hold", "tab:green"))


def plot_comparison(comparison: Comparison, path: Path) -> tuple[str, ...]:
    """Draw each run over its drive, load and release apart, the model as a line, residuals below; return notes.

    Raises:
        UsageError: matplotlib is not installed, the suffix is no picture, or the file cannot be written.
    """
    figure_class = _figure(path)
    runs: list[JointErrors | ShapeErrors] = [*comparison.joint, *comparison.shape]
    shown = runs[:MOST_PANELS]
    columns = min(len(shown), 4)
    rows = -(-len(shown) // columns)
    figure = figure_class(figsize=(PANEL_INCHES[0] * columns, PANEL_INCHES[1] * rows), layout="constrained")
    panels = np.atleast_1d(figure.subfigures(rows, columns)).ravel()
    for panel, one in zip(panels, shown, strict=False):
        above, below = panel.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        draw: Any = _joint if hasattr(one, "predicted") else _shape
        draw(one, above, below)
        above.set_title(one.run.name, fontsize=9)
    write_files({path: lambda stream: figure.savefig(stream, format=path.suffix[1:].lower(), metadata=_stable(path))},
                binary=True)  # fmt: skip
    left = len(runs) - len(shown)
    return (f"{path}: the first {MOST_PANELS} of {len(runs)} runs are drawn.",) if left else ()


def _figure(path: Path) -> Any:  # noqa: ANN401
    if path.suffix.lower() not in FORMATS:
        raise UsageError(f"--plot {path}: the suffix does not say a picture; allowed: {', '.join(FORMATS)}.")
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise UsageError("plots need matplotlib: install coast-cli[plot].") from None
    return Figure


def _stable(path: Path) -> dict[str, None]:
    """Leave clock and version out of the file, so that the same answer gives the same bytes."""
    return {{".pdf": "CreationDate", ".svg": "Date"}.get(path.suffix.lower(), "Software"): None}


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
    above.plot(drive, one.predicted / unit, "-", lw=0.8, color="black")
    above.plot([], [], "-", color="black", label="model")
    above.legend(fontsize=7)
    above.set_ylabel(label)
    below.axhline(0.0, lw=0.5, color="black")
    below.set_ylabel("residual")
    below.set_xlabel("stroke X1 (mm)" if run.stroke is not None else "tension (N)")


def _shape(one: ShapeErrors, above: Any, below: Any) -> None:  # noqa: ANN401
    run = one.run
    above.plot(run.x / MILLIMETRE, run.y / MILLIMETRE, ".", ms=4, color="tab:blue", label="recorded")
    above.plot(one.x / MILLIMETRE, one.y / MILLIMETRE, "-", lw=0.8, color="black", label="model")
    above.legend(fontsize=7)
    above.set_ylabel("y (mm)")
    below.plot(run.x / MILLIMETRE, one.distance / MILLIMETRE, ".", ms=4, color="tab:blue")
    below.set_ylabel("distance (mm)")
    below.set_xlabel("x (mm)")
