"""A diagnosis as one HTML page that needs nothing from outside: five answers, the picture inside it, provenance."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from coast_cli.output.diagnosis_words import (
    HEADLINES,
    chance,
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
    tip,
    unit_of,
)

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.output.diagnosis import DiagnosisAnswer

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1a1a1a; max-width: 56rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; } h2 { font-size: 1.1rem; margin: 1.6rem 0 .4rem; }
table { border-collapse: collapse; margin: .4rem 0; } th, td { padding: .2rem .9rem .2rem 0; text-align: right; }
th:first-child, td:first-child { text-align: left; } thead th { border-bottom: 1px solid #999; font-weight: 600; }
code { font: .9em ui-monospace, monospace; overflow-wrap: anywhere; } img { width: 100%; height: auto; }
footer { margin-top: 2rem; border-top: 1px solid #ccc; color: #555; font-size: .85rem; }
section { break-inside: avoid; } @page { margin: 15mm; } @media print { body { margin: 0; max-width: none; } }
""".strip()


def report(answer: DiagnosisAnswer) -> str:
    """Return the page; it draws with matplotlib."""
    found = answer.diagnosis
    parts = [
        "<!DOCTYPE html>", '<html lang="en">', "<head>", '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>coast diagnose: {escape(found.verdict)}</title>", f"<style>{_STYLE}</style>", "</head>", "<body>",
        f"<h1>{escape(HEADLINES[found.verdict])}</h1>",
        f"<p>Verdict: <b>{escape(found.verdict)}</b>. {escape(sentence(found.reason))}</p>",
        _section("1. Is there a mismatch?", _text(mismatch(found))),
        _section("2. Where?", _where(answer)),
        _section("3. What was left out?", _what(found)),
        _section("4. The model with it", _model(found)),
        _section("5. Does it fit better?", _fit(found)),
    ]  # fmt: skip
    if found.next_recording:
        parts.append(_section("Next recording", _text(sentence(found.next_recording))))
    notes = [*found.notes, *answer.notes]
    if notes:
        items = "".join(f"<li>{escape(sentence(note))}</li>" for note in notes)
        parts.append(_section("Notes", f"<ul>{items}</ul>"))
    if found.comparison is not None:
        parts.append(_section("Recording and models", _picture(answer)))
    parts += [_origin(answer), "</body>", "</html>", ""]
    return "\n".join(parts)


def _where(answer: DiagnosisAnswer) -> str:
    found = answer.diagnosis
    if not found.where:
        return _text(nowhere(found))
    rows = [(place(region, answer.drive_unit), percent(region.share), chance(region.p_value)) for region in found.where]
    return _table(("region", "share of the excess", "probability by chance"), rows)


def _what(found: Diagnosis) -> str:
    if not found.effects:
        tried = f" Closest, not good enough: {', '.join(found.attempts)}." if found.attempts else ""
        return _text(f"Nothing is named.{tried}")
    items = [f"<p>{escape(named(effect))}<br>\n<code>{escape(effect.equation)}</code></p>" for effect in found.effects]
    if found.alternatives:
        items.append(_text(f"The recording cannot tell it from: {others(found)}."))
    return "\n".join(items)


def _model(found: Diagnosis) -> str:
    rows = [
        (name, measured(value), f"{found.configured[name]:.5g}" if name in found.configured else "")
        for name, value in found.parameters.items()
    ]
    rows += [(f"{e.id}.{name}", measured(value), "") for e in found.effects for name, value in e.parameters.items()]
    return _table(("parameter", "fitted", "configured"), rows) if rows else _text("Nothing was fitted.")


def _fit(found: Diagnosis) -> str:
    fit = found.comparison
    if fit is None:
        return _text("Nothing was fitted.")
    said = _text(gained(fit)) if found.effects else ""
    table = _table((f"RMS error ({unit_of(found)})", "train", "held out", "over noise"), levels(found))
    return said + table + _text(tip(found)) + _text(held_out(fit))


def _picture(answer: DiagnosisAnswer) -> str:
    from coast_cli.output.diagnosis_plot import plot_diagnosis

    data = b64encode(plot_diagnosis(answer).render("png")).decode()
    words = "Recording, refitted base and corrected model of each run, what is left, and where the excess error lies"
    return f'<img alt="{words}" src="data:image/png;base64,{data}">'


def _origin(answer: DiagnosisAnswer) -> str:
    origin = answer.provenance
    lines = [", ".join(f"{name} {version}" for name, version in origin.get("versions", {}).items())]
    inputs = [file for name in ("configs", "recordings") for file in origin.get(name, ())]
    lines += [f"{file['file']}  sha256 {file['sha256']}" for file in inputs]
    lines += [f"{name} {value}" for name, value in origin.get("options", {}).items()]
    return "<footer>" + "<br>\n".join(f"<code>{escape(line)}</code>" for line in lines) + "</footer>"


def _section(title: str, content: str) -> str:
    return f"<section>\n<h2>{escape(title)}</h2>\n{content}\n</section>"


def _text(text: str) -> str:
    return f"<p>{escape(text)}</p>"


def _table(names: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "\n".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"
