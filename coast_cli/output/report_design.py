"""What a report says of a design: ranking, shapes, strokes, what tolerances do, checks; each a section of HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from coast_cli.design.rank import Ranking, RankOptions
from coast_cli.design.tolerance import MOST_RANKED
from coast_cli.output.design_plot import plot_pairs, plot_shapes, plot_strokes, plot_tolerance
from coast_cli.output.diagnosis_words import sentence
from coast_cli.output.html import (
    Group,
    HtmlColumn,
    Markup,
    Row,
    bullets,
    figure,
    grouped,
    joined,
    paragraph,
    section,
    table,
)
from coast_cli.output.labels import LABELS, column
from coast_cli.output.report_inputs import Sources
from coast_cli.spec.config import Checks, Config
from coast_cli.spec.tolerances import Tolerances

Columns = Mapping[str, Any]
_MOST_PAIRS = 40
_MOST_ROWS = 200
_FRONT = "●"
_CHANCES = {"all": "all checks hold", "impossible": "cannot be made or assembled"}
_PAIR_FIGURES = (
    "score",
    "total_precurvature_rad",
    "signed_precurvature_rad",
    "rigidity_ratio_mean",
    "rigidity_ratio_series",
    "total_rigidity_mean_n_m2",
    "total_rigidity_series_n_m2",
)
_ASKED = ("curvature_per_m",)  # written as it was asked for
_STROKE_FIGURES = ("curvature_per_m", "stroke_mm", "tension_n", "tendon_strain", "tip_x_mm", "tip_y_mm")


def ranking_section(ranking: Ranking, options: RankOptions, pair: str) -> str:
    """Return the ranked pairs with the front marked; the row of ``pair`` stands out."""
    columns = ranking.columns
    count = len(columns["rank"])
    figures = [column(name, columns[name]) for name in _PAIR_FIGURES]
    names = [f"{outer}/{middle}" for outer, middle in zip(columns["outer"], columns["middle"], strict=True)]
    shown = [k for k in range(count) if k < _MOST_PAIRS or names[k] == pair]
    head = [
        HtmlColumn("rank"),
        HtmlColumn("sample", holds="key"),
        HtmlColumn("pair", holds="key"),
        HtmlColumn("front", holds="key"),
        *(HtmlColumn(LABELS[name].words, LABELS[name].unit) for name in _PAIR_FIGURES),
        HtmlColumn("leads", holds="key"),
    ]
    rows = [
        Row(
            [
                str(columns["rank"][k]),
                str(columns["sample"][k]),
                names[k],
                _FRONT if columns["pareto"][k] else "",
                *(values[k] for values in figures),
                columns["leading_tube"][k] or "-",
            ],
            "chosen" if names[k] == pair else "",
        )
        for k in shown
    ]
    weights = ", ".join(f"{weight:g}" for weight in options.weights)
    said = (
        f"The score joins total pre-curvature, |ln(rigidity ratio)| and total EI, each over its reference, with "
        f"weights {weights}; smaller is better. It takes {options.rigidity} rigidities and {options.assembly} assembly. "
        f"{_FRONT} marks the Pareto front: no other pair is as good in all three and better in one."
    )
    reasons = [
        f"{columns['sample'][k]} ({names[k]}) cannot be assembled: {columns['reason'][k]}."
        for k in shown
        if columns["reason"][k] is not None
    ]
    more = [f"{count - len(shown)} more pairs: `coast rank-pairs` lists them all."] if count > len(shown) else []
    words = "Pairs over their pre-curvature: (a) rigidity ratio, (b) total EI; rings mark the Pareto front"
    picture = figure(plot_pairs(columns, options.rigidity), words) if any(columns["pareto"]) else ""
    return joined(paragraph(said), table(head, rows), _notes([*reasons, *more, *ranking.notes]), picture)


def shapes_section(columns: Columns, notes: Sequence[str], pair: str) -> str:
    """Return the shapes of tubes under gravity and where their tips are; the rows of the pair's tubes stand out."""
    tubes, names = list(columns["tube"]), ("x_mm", "y_mm", "angle_deg")
    last = [k for k in range(len(tubes)) if k + 1 == len(tubes) or tubes[k + 1] != tubes[k]]
    ends = [column(name, [columns[name][k] for k in last]) for name in names]
    head = [
        HtmlColumn("tube", holds="key"),
        *(HtmlColumn(f"tip {LABELS[name].words}", LABELS[name].unit) for name in names),
    ]
    rows = [
        Row([tubes[k], *(values[place] for values in ends)], "chosen" if tubes[k] in pair.split("/") else "")
        for place, k in enumerate(last)
    ]
    said = "Each tube by itself, clamped at the left along +x, gravity along -y."
    picture = figure(plot_shapes(columns), "Tubes under their own weight, both axes to one scale")
    return joined(paragraph(said), picture, table(head, rows), _notes(notes))


def strokes_section(columns: Columns, notes: Sequence[str]) -> str:
    """Return the stroke table, a part for each bending length, and its curves."""
    shown = range(min(len(columns["curvature_per_m"]), _MOST_ROWS))
    tendon = any(value is not None for value in columns["stroke_mm"])
    names = [name for name in _STROKE_FIGURES if tendon or name not in {"stroke_mm", "tendon_strain"}]
    figures = [
        [f"{value:.6g}" for value in columns[name]] if name in _ASKED else column(name, columns[name]) for name in names
    ]
    groups: dict[float, list[Row]] = {}
    for k in shown:
        groups.setdefault(float(columns["bending_length_mm"][k]), []).append(Row([values[k] for values in figures]))
    parts = [Group(f"X2 = {length:.6g} mm", rows) for length, rows in groups.items()]
    said = "What bends the joint how far, with increasing stroke: on release the real joint lags, which this model leaves out."
    left = len(columns["curvature_per_m"]) - len(shown)
    more = [f"{left} more rows: `coast stroke` lists them all."] if left else []
    head = [HtmlColumn(LABELS[name].words, LABELS[name].unit) for name in names]
    words = f"Curvature over {'stroke' if tendon else 'tension'}, a line for each bending length X2"
    return joined(paragraph(said), figure(plot_strokes(columns), words), grouped(head, parts), _notes([*more, *notes]))


def tolerance_section(
    config: Config, pair: str, found: tuple[Sequence[Mapping[str, Any]], Sequence[str], Columns], samples: int
) -> str:
    """Return what varies and by how much, distributions, chances of checks and first places, and what to tighten."""
    rows, notes, columns = found
    kinds = {kind: [row for row in rows if row["kind"] == kind] for kind in ("figure", "check", "first", "index")}
    where = "in the file" if config.tolerances is not None else "defaults of the program"
    said = f"{samples} random samples of {pair} over the tolerances below, which are {where}."
    parts = [paragraph(said), _tolerances(config), _distributions(kinds["figure"])]
    words = "How the figures of the pair are distributed as made, with their values as drawn and the limits of checks"
    parts.append(figure(plot_tolerance(pair, rows, columns), words))
    times = min(samples, MOST_RANKED)
    parts.append(_chances(kinds["check"], "check", "Chance that each check holds"))
    parts.append(
        _chances(kinds["first"], "pair", f"Chance that each pair ranks first, the whole bench made anew {times} times")
    )
    parts.append(_indices(kinds["index"]))
    return joined(*parts, _notes(notes))


def checks_section(config: Config, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the limits of a pair with their values, and whether each holds."""
    held = sum(bool(row["passed"]) for row in rows)
    said = f"{held} of {len(rows)} limits hold for {rows[0]['pair']} as drawn."
    head = [
        HtmlColumn("check", holds="key"),
        HtmlColumn("meaning", holds="text"),
        HtmlColumn("bound", holds="key"),
        HtmlColumn("value"),
        HtmlColumn("limit"),
        HtmlColumn("result", holds="key"),
    ]
    lines = [
        Row(
            [
                row["check"],
                _meaning(config, row["check"]),
                row["bound"],
                f"{row['value']:.4g}",
                f"{row['limit']:.4g}",
                "✓ holds" if row["passed"] else "✗ fails",
            ],
            "" if row["passed"] else "fails",
        )
        for row in rows
    ]
    return paragraph(said) + "\n" + table(head, lines)


def _meaning(config: Config, check: str) -> str:
    said = Checks.model_fields[check].description or ""
    point = config.checks.max_stroke_mm if config.checks is not None else None
    at = f": {point.curvature_per_m:g} 1/m, {point.bending_length_mm:g} mm" if point is not None else ""
    return said + at if check == "max_stroke_mm" else said


def _tolerances(config: Config) -> str:
    sources, limits = Sources(config), config.tolerances or Tolerances()
    head = [
        HtmlColumn("varies", holds="key"),
        HtmlColumn("±"),
        HtmlColumn("distribution", holds="key"),
        HtmlColumn("source", holds="text"),
    ]
    rows = []
    for name, field in Tolerances.model_fields.items():
        one = getattr(limits, name)
        if one is not None:
            path = ("tolerances", name)
            said = (sources.of(path) or "in the file") if sources.given(path) else field.description or ""
            rows.append(Row([name, f"{one.plus_minus:g}", one.distribution, said]))
    return table(head, rows)


def _distributions(rows: Sequence[Mapping[str, Any]]) -> str:
    names = ("nominal", "mean", "std", "low_90", "median", "high_90")
    head = [HtmlColumn("figure", holds="key"), HtmlColumn("unit", holds="key")]
    head += [HtmlColumn(name) for name in ("as drawn", "mean", "std", "5 %", "median", "95 %")]
    lines = []
    for row in rows:
        label = LABELS[row["name"]]
        lines.append(Row([label.words, label.unit, *column(row["name"], [row[name] for name in names])]))
    return table(head, lines)


def _chances(rows: Sequence[Mapping[str, Any]], what: str, said: str) -> str:
    if not rows:
        return ""
    head = [HtmlColumn(what, holds="key"), HtmlColumn("limit"), HtmlColumn("chance"), HtmlColumn("95 % interval")]
    lines = []
    for row in rows:
        share, low, high = (100.0 * row[name] for name in ("probability", "probability_low", "probability_high"))
        bound = "" if row["limit"] is None else f"{row['input']} {row['limit']:.4g}"
        lines.append(
            Row([_CHANCES.get(row["name"], row["name"]), bound, f"{share:.2f} %", f"{low:.2f} to {high:.2f} %"])
        )
    if all(row["limit"] is None for row in rows):
        head, lines = [*head[:1], *head[2:]], [Row([*line.cells[:1], *line.cells[2:]]) for line in lines]
    return section(said, table(head, lines), level=3)


def _indices(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the total Sobol indices: a row an input, a column a figure."""
    if not rows:
        return ""
    figures = list(dict.fromkeys(row["name"] for row in rows))
    total = {(row["input"], row["name"]): float(row["total_effect"]) for row in rows}
    inputs = list(dict.fromkeys(row["input"] for row in rows))
    inputs.sort(key=lambda name: -max(total.get((name, figure_), 0.0) for figure_ in figures))
    head = [HtmlColumn("input", holds="key"), *(HtmlColumn(LABELS[name].words) for name in figures)]
    most = {one: max(share for (_, name), share in total.items() if name == one) for one in figures}
    lines = [Row([name, *(_share(total.get((name, one)), most[one]) for one in figures)]) for name in inputs]
    said = (
        "Share of each figure's variance that an input makes, with all it interacts with: the total Sobol index in per "
        "cent, blank below 1. The largest of each figure is bold."
    )
    return section("What to tighten first", paragraph(said), table(head, lines), level=3)


def _share(index: float | None, most: float) -> str:
    if index is None:
        return ""
    text = f"{100.0 * index:.0f}"
    return Markup(f"<b>{text}</b>") if index == most else text


def _notes(notes: Sequence[str]) -> str:
    return bullets(sentence(note) for note in notes)
