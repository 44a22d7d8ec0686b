"""A diagnosis as a picture: recording, refitted base and corrected model, what is left, the mismatch marked on the curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.diagnosis.curves import JointCurve
from coast_cli.output.comparison_plot import RESPONSES
from coast_cli.output.picture import COLOURS, RECORDED, Picture
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.diagnosis.curves import ShapeCurve
    from coast_cli.diagnosis.unnamed.forms import Curve

    Floats = NDArray[np.float64]

MOST_PANELS = 6
MOST_NOTCHES = 3
_MOST_OF_IT = 0.5  # of the excess: a region that holds less does not say where it is
_LAW_HEIGHT, _LAW_WIDTH = 2.6, 3.6  # inches
_BASE, _CORRECTED = COLOURS[:2]


def plot_diagnosis(found: Diagnosis, *, laws: bool = True) -> Picture:
    """Draw some of the runs with their models and what is left, the place of the mismatch marked on each.

    Args:
        laws: whether laws without a name are drawn below, each over the range that was seen.
    """
    shown = _spread(found.curves, MOST_PANELS)
    columns = 2 if len(shown) in (2, 4) else max(min(len(shown), 3), 1)
    rows = max(-(-len(shown) // columns), 1)
    panel = 3.0 if not shown or isinstance(shown[0], JointCurve) else 4.8
    added = found.unnamed.curves if laws and found.unnamed is not None else ()
    height = panel * rows if shown else 1.0

    def paint(figure: Any) -> None:  # noqa: ANN401
        upper_part = figure
        if added:
            upper_part, lower_part = figure.subfigures(2, 1, height_ratios=(height, _LAW_HEIGHT))
            _laws(lower_part, added)
        for place_, curve in zip(upper_part.add_gridspec(rows, columns), shown, strict=False):
            ratios = (2, 1) if isinstance(curve, JointCurve) else (2, 1, 1)
            inner = place_.subgridspec(len(ratios), 1, height_ratios=ratios)
            upper = upper_part.add_subplot(inner[0])
            lower = upper_part.add_subplot(inner[1], sharex=upper if isinstance(curve, JointCurve) else None)
            if isinstance(curve, JointCurve):
                _run(curve, found, upper, lower)
            else:
                _shape(curve, found, upper, lower)
                _bend(curve, found, upper_part.add_subplot(inner[2], sharex=lower))
            upper.set_title(_title(curve, found))
            lower.set_ylabel("recorded - model" if isinstance(curve, JointCurve) else "distance (mm)")
            if curve is shown[0]:
                upper.legend()

    return Picture((3.6 * max(columns, 2), height + (_LAW_HEIGHT if added else 0.0)), paint)


def plot_laws(curves: Sequence[Curve]) -> Picture:
    """Draw laws without a name over the range that was seen, each with its 90 % band and its equation."""
    return Picture((_LAW_WIDTH * len(curves), _LAW_HEIGHT), lambda figure: _laws(figure, curves))


def _laws(figure: Any, curves: Sequence[Curve]) -> None:  # noqa: ANN401
    row = figure.subplots(1, len(curves), squeeze=False)[0]
    for axes, curve in zip(row, curves, strict=True):
        if curve.low:
            axes.fill_between(curve.x, curve.low, curve.high, color=_CORRECTED, alpha=0.2, lw=0, label="90 % band")
        axes.plot(curve.x, curve.y, "-", color=_CORRECTED, label="law without a name")
        if curve.form is not None:
            axes.plot(curve.x, curve.form.values, "--", lw=1.0, color="black", label=curve.form.name)
        axes.axhline(0.0, lw=0.5, color="black", zorder=1)
        axes.set(xlabel=curve.axis, ylabel=curve.unit, title=f"law {curve.law.number}")
        axes.legend()


def plot_place(found: Diagnosis) -> Picture | None:
    """Draw the run that holds most of the mismatch, in time where there is one, with the place marked on the curve."""
    every = [curve for curve in found.curves if isinstance(curve, JointCurve)]
    if not every:
        return None
    worst = max(every, key=lambda curve: float(np.nanmean((curve.run.response - curve.base) ** 2)))

    def paint(figure: Any) -> None:  # noqa: ANN401
        left, right = figure.subplots(1, 2)
        for axes, over in ((left, worst.run.time), (right, _drive(worst))):
            if over is not None:
                _over(axes, worst, found, over)
        left.set(xlabel="time (s)", title=_title(worst, found))
        right.set(xlabel=_drive_label(worst))
        left.set_visible(worst.run.time is not None)
        right.legend()

    return Picture((7.2, 2.5), paint)


def _over(axes: Any, curve: JointCurve, found: Diagnosis, over: Floats) -> None:  # noqa: ANN401
    """Draw the first response of a run, both models and the marked place over time or drive."""
    label, unit = RESPONSES[curve.run.kind]
    recorded = curve.run.response[:, 0] / unit
    marked = _marked(curve, found)
    axes.plot(over[marked], recorded[marked], "o", ms=6.0, color=COLOURS[4], alpha=0.45, mew=0.0, label="mismatch")
    axes.plot(over, recorded, ".", ms=2.5, color=RECORDED, label="recording")
    for values, colour, words in _models(curve, found):
        axes.plot(over, values[:, 0] / unit, "-", lw=1.1, color=colour, label=words)
    axes.set_ylabel(label)


def _marked(curve: JointCurve, found: Diagnosis) -> NDArray[np.bool_]:
    """Return the rows of a run that lie in the regions of the mismatch which say where in a run it is."""
    run = curve.run
    rows = np.ones(run.drive.size, dtype=bool)
    values = {
        "time": run.time,
        "stroke": None if run.stroke is None else run.stroke / MILLIMETRE,
        "tension": run.tension,
        "curvature": run.response[:, 0] if run.kind == "curvature" else None,
    }
    narrowed = False
    for region in (one for one in found.where if one.share >= _MOST_OF_IT):
        over = values.get(region.axis)
        if region.axis == "direction":
            rows &= (run.direction < 0) == (region.value == "release")
        elif over is not None and region.low is not None and region.high is not None:
            rows &= (over >= region.low) & (over <= region.high)
        else:
            continue
        narrowed = True
    return rows if narrowed else np.zeros_like(rows)


def _drive(curve: JointCurve) -> Floats:
    return curve.run.drive / MILLIMETRE if curve.run.stroke is not None else curve.run.drive


def _drive_label(curve: JointCurve) -> str:
    return "stroke X1 (mm)" if curve.run.stroke is not None else "tension (N)"


def _spread(items: Sequence[JointCurve | ShapeCurve], most: int) -> list[JointCurve | ShapeCurve]:
    """Return at most so many, evenly over the list, the first and the last among them."""
    if len(items) <= most:
        return list(items)
    return [items[round(index * (len(items) - 1) / (most - 1))] for index in range(most)]


def _title(curve: JointCurve | ShapeCurve, found: Diagnosis) -> str:
    held = found.comparison is not None and curve.run.name in found.comparison.held_out_runs
    if not isinstance(curve, JointCurve):
        what = f", {curve.run.pair}"
    else:
        what = f", X2 = {_lengths(curve.run.bending_length)} mm" if curve.run.middle else ""
    return f"{curve.run.name}{what}{' (held out)' if held else ''}"


def _run(curve: JointCurve, found: Diagnosis, upper: Any, lower: Any) -> None:  # noqa: ANN401
    run = curve.run
    label, unit = RESPONSES[run.kind]
    drive, marked = _drive(curve), _marked(curve, found)
    for column in _columns(run.response):
        recorded = run.response[:, column] / unit
        words = "mismatch" if column == 0 else None
        upper.plot(drive[marked], recorded[marked], "o", ms=5.5, color=COLOURS[4], alpha=0.4, mew=0.0, label=words)
        upper.plot(drive, recorded, ".", ms=2.5, color=RECORDED, label="recording" if column == 0 else None)
        for values, colour, words in _models(curve, found):
            model = values[:, column] / unit
            upper.plot(drive, model, "-", lw=1.0, color=colour, label=words if column == 0 else None)
            lower.plot(drive, recorded - model, ".", ms=2.0, color=colour, alpha=0.7)
    upper.set_ylabel(label)
    upper.tick_params(labelbottom=False)
    lower.axhspan(-2.0 * found.noise, 2.0 * found.noise, color="0.9", lw=0, zorder=0)
    lower.axhline(0.0, lw=0.5, color="black", zorder=1)
    lower.set_xlabel(_drive_label(curve))


def _shape(curve: ShapeCurve, found: Diagnosis, upper: Any, lower: Any) -> None:  # noqa: ANN401
    seen = np.stack((curve.run.x, curve.run.y)) / MILLIMETRE
    upper.plot(*seen, ".", ms=2.5, color=RECORDED, label="recording")
    for values, colour, words in _models(curve, found):
        line = values / MILLIMETRE
        upper.plot(*line, "-", lw=1.0, color=colour, label=words)
        lower.plot(curve.at / MILLIMETRE, np.hypot(*(seen - line)), ".", ms=2.0, color=colour, alpha=0.7)
    upper.set_aspect("equal", adjustable="datalim")
    upper.set_xlabel("x (mm)")
    upper.set_ylabel("y (mm)")
    lower.axhspan(0.0, 2.0 * found.noise, color="0.9", lw=0, zorder=0)
    lower.tick_params(labelbottom=False)


def _bend(curve: ShapeCurve, found: Diagnosis, axes: Any) -> None:  # noqa: ANN401
    """Draw curvature along the tube, the natural curvature as fitted, and where the excess error lies."""
    at = curve.at / MILLIMETRE
    shown = 3 if found.model_effects or found.model_tubes else 2
    for values, colour in list(zip(curve.curvature, (RECORDED, _BASE, _CORRECTED), strict=True))[:shown]:
        axes.plot(at, values, "-", lw=1.0, color=colour)
    if curve.natural is not None:
        axes.axhline(curve.natural, lw=0.8, ls="--", color="black")
    for region in found.where:
        if region.axis == "arc_length" and region.low is not None and region.high is not None:
            axes.axvspan(region.low, max(region.high, region.low + 0.005 * at[-1]), color=COLOURS[4], alpha=0.25, lw=0)
    axes.set_ylabel("curvature (1/m)")
    axes.set_xlabel("arc length (mm); dashed: natural")


def _models(curve: JointCurve | ShapeCurve, found: Diagnosis) -> list[tuple[Floats, str, str]]:
    models = [(curve.base, _BASE, "base refitted")]
    words = "with effects" if found.effects or found.unnamed is None else "with the law"
    return [*models, (curve.corrected, _CORRECTED, words)] if found.model_effects or found.model_tubes else models


def _columns(response: Floats) -> list[int]:
    """Return the columns to draw: of many notches the first, the middle and the last."""
    count = response.shape[1]
    return list(range(count)) if count <= MOST_NOTCHES else [0, count // 2, count - 1]


def _lengths(length: Floats) -> str:
    low, high = float(np.min(length)) / MILLIMETRE, float(np.max(length)) / MILLIMETRE
    return f"{low:.3g}" if high - low < 1e-6 else f"{low:.3g} to {high:.3g}"
