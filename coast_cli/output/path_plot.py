"""The picture of a path: the path with the robot on it at some feeds, and beside it the controls over the feed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.output.picture import COLOURS, RECORDED, Picture
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.design.path import PathPlan

_POSES = 5
_POINTS = 200  # of a pose


def plot_path(plan: PathPlan) -> Picture:
    """Draw the path with poses of the robot, the tip a dot (a cross where out of reach), X1, and X2 with X3."""
    columns = plan.columns
    inward = np.array([way == "in" for way in columns["way"]])
    feed = np.asarray(columns["feed_mm"])
    reachable = np.asarray(columns["reachable"])

    def poses(axes: Any) -> None:  # noqa: ANN401
        path = plan.path
        axes.plot(path.x / MILLIMETRE, path.y / MILLIMETRE, "--", color=RECORDED, lw=1.2, label="path", zorder=3)
        rows = np.flatnonzero(inward)[1:]
        shown = rows[np.unique(np.linspace(0, rows.size - 1, _POSES + 1).round().astype(int)[1:])]
        for number, row in enumerate(shown):
            x, y = plan.body.place(np.linspace(0.0, feed[row] * MILLIMETRE, _POINTS))
            first = number == 0
            axes.plot(
                x / MILLIMETRE, y / MILLIMETRE, color=COLOURS[0], lw=2.6, alpha=0.3, label="robot" if first else None
            )
            mark, colour = (".", COLOURS[0]) if reachable[row] else ("x", COLOURS[1])
            axes.plot(x[-1] / MILLIMETRE, y[-1] / MILLIMETRE, mark, color=colour, ms=7)
            axes.annotate(
                f"{feed[row]:.4g} mm",
                (x[-1] / MILLIMETRE, y[-1] / MILLIMETRE),
                xytext=(7, -4),
                textcoords="offset points",
                fontsize=8,
            )
        axes.set(xlabel="x (mm)", ylabel="y (mm)")
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.12)
        axes.legend()

    def control(axes: Any, names: dict[str, str], label: str) -> None:  # noqa: ANN401
        for (name, words), colour in zip(names.items(), COLOURS, strict=False):
            values = np.array([np.nan if value is None else value for value in columns[name]], dtype=float)
            axes.plot(feed[inward], values[inward], color=colour, label=words)
            if not inward.all() and len(names) == 1:  # the lengths are the same on the way out
                back = np.append(np.flatnonzero(inward)[-1], np.flatnonzero(~inward))
                axes.plot(feed[back], values[back], "--", color=colour, label=f"{words}, way out")
            axes.plot(feed[~reachable], values[~reachable], "x", color=COLOURS[1], ms=4, mew=0.8)
        if not reachable.all():
            axes.plot([], [], "x", color=COLOURS[1], ms=4, mew=0.8, label="out of reach")
        axes.set_ylabel(label)
        axes.legend()

    def paint(figure: Any) -> None:  # noqa: ANN401
        grid = figure.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
        left, upper = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
        lower = figure.add_subplot(grid[1, 1], sharex=upper)
        poses(left)
        drive = "stroke_mm" if any(value is not None for value in columns["stroke_mm"]) else "tension_n"
        control(
            upper,
            {drive: "X1" if drive == "stroke_mm" else "tension"},
            "tendon stroke (mm)" if drive == "stroke_mm" else "tension (N)",
        )
        control(lower, {"bending_length_mm": "X2 bend", "outer_advance_mm": "X3 outer tube"}, "length (mm)")
        upper.tick_params(labelbottom=False)
        lower.set_xlabel("feed (mm)")
        left.set_title("(a)")
        upper.set_title("(b)")

    return Picture((9.4, 4.4), paint)
