"""Pictures of designs: pairs as in P's Figure 8, shapes as in Figure 7, strokes as in Figure 9, and what errs how far."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np

from coast_cli.output.labels import LABELS
from coast_cli.output.picture import COLOURS, MARKS, Picture, short

_MOST_CURVES = 12
_MOST_LABELS = 40
# Points from a mark to its name: where it starts, its alignment, its middle; and how far from there others are clear.
_CORNERS = (
    ((6, 4), "left", (15.0, 8.0)),
    ((6, -11), "left", (15.0, -8.0)),
    ((-6, 4), "right", (-15.0, 8.0)),
    ((-6, -11), "right", (-15.0, -8.0)),
)
_CLEAR, _PANEL = 16.0, (240.0, 210.0)
_CLOUD = 20_000  # points of a cloud; more only blacken it


def plot_pairs(columns: Mapping[str, Any], rigidity: str) -> Picture:
    """Draw pairs over pre-curvature: the rigidity ratio (Figure 8 a) and total EI (b), middle tubes as families."""
    known = np.array([value is not None for value in columns["total_precurvature_rad"]])
    table = {name: np.asarray(values)[known] for name, values in columns.items()}
    families = sorted(set(table["middle"].tolist()))

    def panel(axes: Any, figure: str) -> None:  # noqa: ANN401
        x, y = (_shown(name, table[name]) for name in ("total_precurvature_rad", figure))
        for family, colour, mark in zip(families, cycle(COLOURS), cycle(MARKS), strict=False):
            rows = np.flatnonzero(table["middle"] == family)
            rows = rows[np.argsort([int(name[1:]) for name in table["sample"][rows]])]
            axes.plot(x[rows], y[rows], "-", color=colour, lw=0.9, alpha=0.6, zorder=1)
            axes.plot(x[rows], y[rows], mark, color=colour, ms=5, label=short(family))
        front = table["pareto"].astype(bool)
        axes.plot(x[front], y[front], "o", mfc="none", mec="black", ms=10, mew=0.8, label="front")
        if x.size <= _MOST_LABELS:
            _names(axes, table["sample"], x, y)
        _label(axes, "total_precurvature_rad", figure)

    def paint(figure: Any) -> None:  # noqa: ANN401
        left, right = figure.subplots(1, 2)
        panel(left, f"rigidity_ratio_{rigidity}")
        panel(right, f"total_rigidity_{rigidity}_n_m2")
        left.set_title("(a)")
        right.set_title("(b)")
        if len(families) <= _MOST_CURVES:
            figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=len(families) + 1)

    return Picture((9.0, 4.4), paint)


def plot_front(front: Sequence[Mapping[str, Any]], bench: Mapping[str, Any], rigidity: str) -> Picture:
    """Draw the front of an exploration beside the pairs on the bench."""
    ratio, total = f"rigidity_ratio_{rigidity}", f"total_rigidity_{rigidity}_n_m2"

    def values(name: str) -> Any:  # noqa: ANN401
        return _shown(name, [row[name] for row in front[:_CLOUD]])

    def paint(figure: Any) -> None:  # noqa: ANN401
        for axes, name, title in zip(figure.subplots(1, 2), (ratio, total), ("(a)", "(b)"), strict=True):
            axes.plot(values("total_precurvature_rad"), values(name), ".", color=COLOURS[0], ms=4, label="front")
            x, y = (_shown(column, bench[column]) for column in ("total_precurvature_rad", name))
            axes.plot(x, y, MARKS[1], color=COLOURS[1], ms=5, label="bench")
            if len(bench["sample"]) <= _MOST_LABELS:
                _names(axes, bench["sample"], x, y)
            _label(axes, "total_precurvature_rad", name)
            axes.set_title(title)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)

    return Picture((9.0, 4.4), paint)


def plot_shapes(columns: Mapping[str, Any]) -> Picture:
    """Draw the shapes of tubes under gravity, both axes to one scale."""
    names, x, y = (np.asarray(columns[key]) for key in ("tube", "x_mm", "y_mm"))
    tubes = list(dict.fromkeys(names.tolist()))
    wide = float(np.ptp(x))
    high = max(1.1 * float(np.ptp(y)), 0.2 * wide)  # a tube that hardly sags is drawn as one
    height = min(5.0 * high / wide + 0.9, 8.0) if wide > 0.0 else 8.0

    def paint(figure: Any) -> None:  # noqa: ANN401
        axes = figure.subplots()
        for tube, colour in zip(tubes, cycle(COLOURS), strict=False):
            rows = names == tube
            axes.plot(x[rows], y[rows], "-", color=colour)
            axes.annotate(
                short(tube),
                (x[rows][-1], y[rows][-1]),
                xytext=(4, 0),
                textcoords="offset points",
                color=colour,
                va="center",
            )
        axes.set_aspect("equal", adjustable="box")
        middle = 0.5 * float(y.min() + y.max())
        axes.set_ylim(middle - 0.5 * high, middle + 0.5 * high)
        axes.set(xlabel="x, along the clamp (mm)", ylabel="y, against gravity (mm)")

    return Picture((6.0, height), paint)


def plot_strokes(columns: Mapping[str, Any]) -> Picture:
    """Draw curvature over stroke (over tension without a tendon), a line for each bending length."""
    length, curvature = (np.asarray(columns[key], dtype=float) for key in ("bending_length_mm", "curvature_per_m"))
    tendon = any(value is not None for value in columns["stroke_mm"])
    drive = np.array([np.nan if v is None else v for v in columns["stroke_mm" if tendon else "tension_n"]], dtype=float)

    def paint(figure: Any) -> None:  # noqa: ANN401
        axes = figure.subplots()
        for one, colour, mark in zip(np.unique(length), cycle(COLOURS), cycle(MARKS), strict=False):
            rows = np.flatnonzero(length == one)
            rows = rows[np.argsort(drive[rows])]
            axes.plot(drive[rows], curvature[rows], "-", marker=mark, ms=4, color=colour, label=f"X2 = {one:.4g} mm")
        axes.set(xlabel="tendon stroke X1 (mm)" if tendon else "tension (N)", ylabel="curvature (1/m)")
        pair = "/".join(name for name in (columns["outer"][0], columns["middle"][0]) if name)
        axes.set_title(pair)
        axes.legend()

    return Picture((5.6, 4.2), paint)


def plot_tolerance(pair: str, rows: Iterable[Mapping[str, Any]], columns: Mapping[str, Any]) -> Picture:
    """Draw how each figure of a pair is distributed, with its value as drawn and the limits of its checks."""
    known = list(rows)
    figures = [row for row in known if row["kind"] == "figure"]
    limits = [row for row in known if row["kind"] == "check" and row["limit"] is not None]
    across = 4
    down = -(-len(figures) // across)

    def paint(figure: Any) -> None:  # noqa: ANN401
        panels = np.atleast_1d(figure.subplots(down, across)).ravel()
        for axes in panels[len(figures) :]:
            axes.set_axis_off()
        for axes, row in zip(panels, figures, strict=False):
            label, values = LABELS[row["name"]], _shown(row["name"], columns[row["name"]])
            axes.hist(
                values[np.isfinite(values)], bins=min(1 + int(values.size**0.5), 60), color=COLOURS[0], alpha=0.75, lw=0
            )
            if row["nominal"] is not None:
                axes.axvline(row["nominal"] * label.scale, color="black", lw=1.0, label="as drawn")
            for limit in limits:
                if _bounds(limit["name"], row["name"], known):
                    axes.axvline(limit["limit"] * label.scale, color=COLOURS[1], lw=1.2, ls="--", label="limit")
            axes.set_xlabel(label.heading)
            axes.set_yticks([])
            axes.locator_params(axis="x", nbins=4)
            axes.grid(visible=False)
            axes.spines["left"].set_visible(False)
        named = {name: line for axes in panels for line, name in zip(*axes.get_legend_handles_labels(), strict=True)}
        figure.suptitle(f"{pair}, {values.size} samples", x=0.01, ha="left")
        figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=2)

    return Picture((9.0, 1.9 * down + 0.8), paint)


def _bounds(check: str, figure: str, rows: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether a check limits a figure: its name without max_, and for the ratio the same value as drawn."""
    name = check.removeprefix("max_")
    nominal = {row["nominal"] for row in rows if row["name"] == check}
    return figure == name or (
        figure.startswith(f"{name}_") and any(row["name"] == figure and row["nominal"] in nominal for row in rows)
    )


def _names(axes: Any, names: Iterable[Any], x: Any, y: Any) -> None:  # noqa: ANN401
    """Write the names of points beside them, over lines and under points, each in a corner where no other point is."""
    clear = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.7}
    spans = [np.nanmax(values) - np.nanmin(values) or 1.0 for values in (x, y)]
    places = np.stack([(values - np.nanmin(values)) / span for values, span in zip((x, y), spans, strict=True)], axis=1)
    places *= _PANEL
    for row, name in enumerate(names):
        if not np.all(np.isfinite(places[row])):
            continue
        others = np.delete(places, row, axis=0)
        gaps = [np.nanmin(np.hypot(*(others - places[row] - middle).T), initial=_CLEAR) for _, _, middle in _CORNERS]
        at, align, _ = _CORNERS[int(np.argmax(gaps))]  # the first that is clear
        axes.annotate(
            str(name),
            (x[row], y[row]),
            xytext=at,
            textcoords="offset points",
            ha=align,
            fontsize=8,
            bbox=clear,
            zorder=1.5,
        )


def _label(axes: Any, x: str, y: str) -> None:  # noqa: ANN401
    axes.set(xlabel=LABELS[x].heading, ylabel=LABELS[y].heading)
    axes.margins(0.08)


def _shown(name: str, values: Any) -> Any:  # noqa: ANN401
    """Return a column in the unit of its label; None is NaN."""
    return np.asarray(values, dtype=float) * LABELS[name].scale
