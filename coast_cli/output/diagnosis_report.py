"""A diagnosis as HTML, a page by itself or parts of a larger one: five answers, the picture, provenance."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from coast_cli.output.diagnosis_words import (
    HEADLINES,
    SHARED_COLUMNS,
    carried_over,
    chance,
    curve_words,
    gained,
    held_out,
    levels,
    measured,
    mismatch,
    named,
    nowhere,
    others,
    percent,
    place,
    sentence,
    shared_rows,
    tip_words,
    told,
    unit_words,
)
from coast_cli.output.html import HtmlColumn, Row, bullets, figure, footer, page, paragraph, section, table

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.diagnosis.unnamed.forms import Curve
    from coast_cli.output.diagnosis import DiagnosisAnswer


def report_page(answer: DiagnosisAnswer) -> str:
    """Return the page."""
    found = answer.diagnosis
    return page(
        f"coast diagnose: {found.verdict}",
        [f"<h1>{escape(HEADLINES[found.verdict])}</h1>", *sections(answer), footer(answer.provenance)],
    )


def sections(answer: DiagnosisAnswer, level: int = 2) -> list[str]:
    """Return the parts of the page below its headline, with headings of a level."""
    found = answer.diagnosis
    parts = {
        "1. Is there a mismatch?": paragraph(mismatch(found)),
        "2. Where?": _where(answer),
        "3. What was left out?": _what(found),
        "4. The model with it": _model(found),
        "5. Does it fit better?": _fit(found),
        "Shared with the shapes": _shared(found),
        "Next recording": paragraph(sentence(found.next_recording) if found.next_recording else ""),
        "Notes": bullets(sentence(note) for note in (*found.notes, *answer.notes)),
        "Recording and models": _picture(answer) if found.comparison is not None else "",
    }
    verdict = f"<p>Verdict: <b>{escape(found.verdict)}</b>. {escape(sentence(found.reason))}</p>"
    return [verdict, *(section(title, content, level=level) for title, content in parts.items() if content)]


def _where(answer: DiagnosisAnswer) -> str:
    found = answer.diagnosis
    if not found.where:
        return paragraph(nowhere(found))
    rows = [(place(region, answer.drive_unit), percent(region.share), chance(region.p_value)) for region in found.where]
    return _table(("region", "share of the excess", "probability by chance"), rows)


def _what(found: Diagnosis) -> str:
    if not found.effects:
        tried = f" Closest, not good enough: {', '.join(found.attempts)}." if found.attempts else ""
        items = [paragraph(f"Nothing is named.{tried}")]
    else:
        items = [
            f"<p>{escape(named(effect))}<br>\n<code>{escape(effect.equation)}</code></p>" for effect in found.effects
        ]
    if found.alternatives:
        items.append(paragraph(f"The recording cannot tell it from: {others(found)}."))
    law = told(found)
    if law is not None:
        items.append(f"<p>{escape(law[0])}<br>\n<code>{escape(law[1])}</code></p>")
    if found.unnamed is not None and found.unnamed.curves:
        items.append(_laws(found.unnamed.curves))
    return "\n".join(items)


def _laws(curves: Sequence[Curve]) -> str:
    from coast_cli.output.diagnosis_plot import plot_laws

    tables = [_table(curve.names(), curve.rows()) for curve in curves]
    words = f"{curve_words(curves[0])}; broken line: the equation" if curves[0].form else curve_words(curves[0])
    return "\n".join([figure(plot_laws(curves), words, "png"), *tables])


def _model(found: Diagnosis) -> str:
    rows = [
        (name, measured(value), f"{found.configured[name]:.5g}" if name in found.configured else "")
        for name, value in found.parameters.items()
    ]
    rows += [(f"{e.id}.{name}", measured(value), "") for e in found.effects for name, value in e.parameters.items()]
    return _table(("parameter", "fitted", "configured"), rows) if rows else paragraph("Nothing was fitted.")


def _fit(found: Diagnosis) -> str:
    fit = found.comparison
    if fit is None:
        return paragraph("Nothing was fitted.")
    said = paragraph(gained(fit)) if found.effects or found.verdict == "unnamed" else ""
    errors = _table((f"RMS error ({unit_words(found)})", "train", "held out", "over noise"), levels(found))
    return said + errors + paragraph(tip_words(found)) + paragraph(held_out(fit))


def _shared(found: Diagnosis) -> str:
    if found.carried is None:
        return ""
    shapes = found.carried.shapes
    said = paragraph(
        f"The shapes: {sentence(HEADLINES[shapes.verdict])} {carried_over(found.carried, unit_words(found))}"
    )
    rows = shared_rows(found.carried)
    return said + (_table(SHARED_COLUMNS, rows) if rows else "") + (_what(shapes) if shapes.effects else "")


def _picture(answer: DiagnosisAnswer) -> str:
    from coast_cli.output.diagnosis_plot import plot_diagnosis

    words = "Recording, refitted base and corrected model of each run, and what is left; yellow: where the mismatch is"
    return figure(plot_diagnosis(answer.diagnosis, laws=False), words, "png")


def _table(names: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    columns = [HtmlColumn(name, holds="text" if number == 0 else "number") for number, name in enumerate(names)]
    return table(columns, [Row(row) for row in rows])
