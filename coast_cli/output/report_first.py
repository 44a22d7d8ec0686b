"""The first sheet of a report: what it answers. The drawing, the verdicts, the best pairs, strokes, where the mismatch is."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from coast_cli.mechanics.tube import NotchedTube
from coast_cli.output.diagnosis_plot import plot_place
from coast_cli.output.diagnosis_words import HEADLINES, named, percent
from coast_cli.output.html import HtmlColumn, Markup, Row, figure, joined, paragraph, section, side_by_side, table
from coast_cli.output.labels import LABELS, column
from coast_cli.output.pair_drawing import drawing
from coast_cli.output.picture import can_draw
from coast_cli.output.report_contents import DesignReport
from coast_cli.output.report_inputs import inputs_of, said_of
from coast_cli.spec.build import Design, build
from coast_cli.units import MILLIMETRE

_BEST = 5
_MOST_CURVATURES = 9
_GOOD = {"agrees": "good", "parameters": "good", "insufficient": "open"}


def first_sheet(answer: DesignReport) -> str:
    """Return the sheet, without its title."""
    return joined(
        drawing(*drawn_design(build(answer.config), answer.pair)),
        _summary(answer),
        side_by_side(_best(answer), _strokes(answer)),
        _place(answer),
    )


def drawn_design(design: Design, pair: str | None) -> tuple[NotchedTube | None, NotchedTube, float | None]:
    """Return what a drawing shows: the tubes of a pair, or of the configuration's, and the tendon's radius, m.

    Raises:
        BadInput: as ``Design.pair``.
    """
    outer, middle = design.pair(pair)
    tendon = design.config.tendon
    radius = None if tendon is None else tendon.radius_mm * MILLIMETRE
    return None if outer is None else design.tube(outer), design.tube(middle), radius


def _summary(answer: DesignReport) -> str:
    rows = [("Pair", f"{answer.pair}, {answer.chosen}")]
    rows += _ranked(answer)
    rows += _checked(answer)
    if answer.tolerance:
        every = next((row for row in answer.tolerance[0] if (row["kind"], row["name"]) == ("check", "all")), None)
        if every is not None:
            source = "[tolerances] of the file" if answer.config.tolerances else "default tolerances"
            rows.append(("As made", f"{100.0 * every['probability']:.1f} % pass every check over the {source}"))
    if answer.diagnosis is not None:
        found = answer.diagnosis.diagnosis
        effects = ", ".join(f"{effect.id} ({percent(effect.confidence)})" for effect in found.effects)
        said = HEADLINES[found.verdict] + (f" Named: {effects}." if effects else "")
        rows.append(("Recordings", _verdict(_GOOD.get(found.verdict, "bad"), said)))
    rows.append(("Inputs", said_of(inputs_of(answer.config))))
    return table([HtmlColumn("In short", holds="key"), HtmlColumn("", holds="text")], [Row(row) for row in rows])


def _checked(answer: DesignReport) -> list[tuple[str, str]]:
    """Return how many limits hold, which fail, and which is closest to its limit."""
    if not answer.checks:
        return []
    failing = [f"{row['check']} ({row['bound']})" for row in answer.checks if not row["passed"]]
    held = f"{len(answer.checks) - len(failing)} of {len(answer.checks)} limits hold as drawn"
    if failing:
        return [("Checks", _verdict("bad", f"{held}; {', '.join(failing)} {'fails' if len(failing) == 1 else 'fail'}"))]
    margins = {
        row["check"]: abs(row["limit"] - row["value"]) / abs(row["limit"]) for row in answer.checks if row["limit"]
    }
    nearest = min(margins, key=margins.__getitem__, default=None)
    near = "" if nearest is None else f"; the nearest is {nearest}, {percent(margins[nearest])} from its limit"
    return [("Checks", _verdict("good", held + near))]


def _verdict(kind: str, text: str) -> Markup:
    """Return a text in the colour of what it says, with a mark for who sees no colour."""
    mark = {"good": "✓", "bad": "✗", "open": "?"}[kind]
    return Markup(f'<span class="{kind}">{mark} {escape(text)}</span>')


def _ranked(answer: DesignReport) -> list[tuple[str, str]]:
    if answer.ranking is None:
        return []
    columns = answer.ranking.columns
    names = _pairs(answer)
    if answer.pair not in names:
        return []
    place = names.index(answer.pair)
    front = "on the Pareto front" if columns["pareto"][place] else "not on the Pareto front"
    first = "" if place == 0 else f"; {names[0]} ranks first"
    return [("Ranking", f"{place + 1} of {len(names)} by score, {front}{first}")]


def _pairs(answer: DesignReport) -> list[str]:
    if answer.ranking is None:
        return []
    columns = answer.ranking.columns
    return [f"{outer}/{middle}" for outer, middle in zip(columns["outer"], columns["middle"], strict=True)]


def _best(answer: DesignReport) -> str:
    """Return the first pairs of the ranking, and the report's own."""
    if answer.ranking is None:
        return ""
    columns, names = answer.ranking.columns, _pairs(answer)
    shown = [k for k in range(len(names)) if k < _BEST or names[k] == answer.pair]
    figures = ("score", "total_precurvature_rad", "rigidity_ratio_mean")
    values = [column(name, [columns[name][k] for k in shown]) for name in figures]
    head = [
        HtmlColumn("rank"),
        HtmlColumn("pair", holds="key"),
        *(HtmlColumn(LABELS[n].words, LABELS[n].unit) for n in figures),
    ]
    rows = [
        Row(
            [str(columns["rank"][k]), names[k], *(one[place] for one in values)],
            "chosen" if names[k] == answer.pair else "",
        )
        for place, k in enumerate(shown)
    ]
    return section("The best pairs", table(head, rows), level=3)


def _strokes(answer: DesignReport) -> str:
    """Return the drive for each curvature, a column for each bending length."""
    if answer.strokes is None:
        return ""
    columns = answer.strokes[0]
    drive = "stroke_mm" if any(value is not None for value in columns["stroke_mm"]) else "tension_n"
    curvatures = list(dict.fromkeys(float(value) for value in columns["curvature_per_m"]))[:_MOST_CURVATURES]
    lengths = list(dict.fromkeys(float(value) for value in columns["bending_length_mm"]))
    found = {
        (float(kappa), float(length)): value
        for kappa, length, value in zip(
            columns["curvature_per_m"], columns["bending_length_mm"], columns[drive], strict=True
        )
    }
    cells = [column(drive, [found.get((kappa, length)) for kappa in curvatures]) for length in lengths]
    head = [HtmlColumn("curvature", "1/m"), *(HtmlColumn(f"{length:.6g} mm", LABELS[drive].unit) for length in lengths)]
    rows = [Row([f"{kappa:.6g}", *(one[k] for one in cells)]) for k, kappa in enumerate(curvatures)]
    words = LABELS[drive].words
    return section(f"{words[:1].upper()}{words[1:]} at X2 of", table(head, rows), level=3)


def _place(answer: DesignReport) -> str:
    """Return the recording with the place of the mismatch marked on it, and the sentence of what was left out."""
    if answer.diagnosis is None:
        return ""
    found = answer.diagnosis.diagnosis
    said: Sequence[str] = [named(effect) for effect in found.effects] or [found.reason]
    picture = plot_place(found) if can_draw() else None
    words = "The recording with the model refitted (blue) and with what was left out (orange); yellow: where the mismatch is"
    return section(
        HEADLINES[found.verdict],
        *(paragraph(one) for one in said),
        "" if picture is None else figure(picture, words),
        level=3,
    )
