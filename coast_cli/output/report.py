"""One configuration as one HTML page: inputs, ranking, shapes, strokes, tolerances, checks, diagnosis of recordings.

The page needs nothing from outside and no script. Without matplotlib it has its tables, and says how to get the pictures.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from coast_cli.output.diagnosis_report import sections
from coast_cli.output.diagnosis_words import HEADLINES, percent
from coast_cli.output.html import Column, Row, footer, page, paragraph, section, table
from coast_cli.output.picture import can_draw
from coast_cli.output.report_contents import DesignReport
from coast_cli.output.report_design import (
    checks_section,
    ranking_section,
    shapes_section,
    strokes_section,
    tolerance_section,
)
from coast_cli.output.report_inputs import inputs_of, inputs_section, said_of

NO_PICTURES = (
    "There are no pictures, since matplotlib is not installed: `pip install 'coast-cli[plot]'` and run it again."
)


def page_of(answer: DesignReport) -> str:
    """Return the page; the same answer gives the same text."""
    parts = _parts(answer)
    titles = {anchor: title for anchor, (title, _) in parts.items()} | {"provenance": "Provenance"}
    links = "\n".join(f'<a href="#{anchor}">{escape(title)}</a>' for anchor, title in titles.items())
    body = [
        f"<h1>{escape(answer.pair)}: design report</h1>",
        _inputs_line(answer),
        _summary(answer),
        paragraph("" if can_draw() else NO_PICTURES),
        f"<nav>\n{links}\n</nav>",
    ]
    for anchor, (title, content) in parts.items():
        body.append(section(title, content or paragraph(answer.missing[anchor]), anchor=anchor))
    body.append(section(titles["provenance"], _provenance(), footer(answer.provenance), anchor="provenance"))
    return page(f"coast report: {answer.pair}, {answer.config.source}", body)


def _parts(answer: DesignReport) -> dict[str, tuple[str, str]]:
    """Return title and content of each section by its anchor; a content that is left out is empty."""
    config, pair = answer.config, answer.pair
    parts = {
        "inputs": ("Inputs", inputs_section(config)),
        "ranking": ("Ranking", ranking_section(answer.ranking, answer.rank_options, pair) if answer.ranking else ""),
        "shapes": ("Shapes under gravity", shapes_section(*answer.shapes, pair)),
        "strokes": (f"Strokes of {pair}", strokes_section(*answer.strokes) if answer.strokes else ""),
        "tolerances": (
            "Tolerances",
            tolerance_section(config, pair, answer.tolerance, answer.samples) if answer.tolerance else "",
        ),
        "checks": ("Checks", checks_section(config, answer.checks) if answer.checks else ""),
    }
    if answer.diagnosis is not None:
        headline = HEADLINES[answer.diagnosis.diagnosis.verdict]
        content = "\n".join([f"<p><b>{escape(headline)}</b></p>", *sections(answer.diagnosis, level=3)])
        parts["diagnosis"] = ("Diagnosis of the recordings", content)
    return parts


def _inputs_line(answer: DesignReport) -> str:
    """Return which file this is about and which version said so."""
    config = answer.provenance["configs"][0]
    version = answer.provenance["versions"]["coast"]
    return (
        f"<p><code>{escape(config['file'])}</code>, sha256 <code>{config['sha256'][:16]}</code>, by coast {version}</p>"
    )


def _summary(answer: DesignReport) -> str:
    rows = [("Pair", f"{answer.pair}, {answer.chosen}")]
    rows.append(("Inputs", said_of(inputs_of(answer.config))))
    rows += _ranked(answer)
    if answer.checks:
        failing = [f"{row['check']} ({row['bound']})" for row in answer.checks if not row["passed"]]
        held = f"{len(answer.checks) - len(failing)} of {len(answer.checks)} limits hold as drawn"
        rows.append(("Checks", f"{held}; {', '.join(failing)} {_fail(failing)}" if failing else held))
    if answer.tolerance:
        every = next((row for row in answer.tolerance[0] if (row["kind"], row["name"]) == ("check", "all")), None)
        if every is not None:
            source = "[tolerances] of the file" if answer.config.tolerances else "default tolerances"
            rows.append(("As made", f"{100.0 * every['probability']:.1f} % pass every check over the {source}"))
    if answer.diagnosis is not None:
        found = answer.diagnosis.diagnosis
        effects = ", ".join(f"{effect.id} ({percent(effect.confidence)})" for effect in found.effects)
        rows.append(("Recordings", HEADLINES[found.verdict] + (f" Named: {effects}." if effects else "")))
    return table([Column("In short", holds="key"), Column("", holds="text")], [Row(row) for row in rows])


def _ranked(answer: DesignReport) -> list[tuple[str, str]]:
    if answer.ranking is None:
        return []
    columns = answer.ranking.columns
    names = [f"{outer}/{middle}" for outer, middle in zip(columns["outer"], columns["middle"], strict=True)]
    if answer.pair not in names:
        return []
    place = names.index(answer.pair)
    front = "on the Pareto front" if columns["pareto"][place] else "not on the Pareto front"
    first = "" if place == 0 else f"; {names[0]} ranks first"
    return [("Ranking", f"{place + 1} of {len(names)} by score, {front}{first}")]


def _provenance() -> str:
    return paragraph(
        "The same files, options and versions give the same page to the byte. The digest of a configuration is of what it "
        "says, whatever its comments and order. Models, equations and their limits: `coast explain NAME`, and the paper, "
        '"Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023).'
    )


def _fail(names: Sequence[str]) -> str:
    return "fails" if len(names) == 1 else "fail"
