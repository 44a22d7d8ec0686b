"""A diagnosis as a page for the terminal: five answers in order, each with its number, within 80 columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from textwrap import wrap
from typing import IO, TYPE_CHECKING

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

if TYPE_CHECKING:
    from rich.table import Table

    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.output.diagnosis import DiagnosisAnswer

WIDTH = 80
_INDENT = "   "
_MOST_REGIONS = 5
_MOST_NOTES = 8


def render(answer: DiagnosisAnswer, stream: IO[str], *, width: int | None = None) -> None:
    """Write the page, 80 columns wide or as the terminal is where that is less."""
    page = _Page(stream, min(width or WIDTH, WIDTH))
    _answers(page, answer)
    carried = answer.diagnosis.carried
    if carried is not None:
        page.heading("The shapes of the same call")
        page.say(carried_over(carried, unit_words(answer.diagnosis)))
        if carried.shared:
            page.table(SHARED_COLUMNS, shared_rows(carried))
        page.heading("")
        _answers(page, replace(answer, diagnosis=carried.shapes))
    for config in answer.provenance.get("configs", ()):
        page.heading(f"{config['file']}  sha256 {config['sha256'][:16]}")


def _answers(page: _Page, answer: DiagnosisAnswer) -> None:
    found = answer.diagnosis
    page.say(f"{HEADLINES[found.verdict]} (verdict: {found.verdict})", indent="")
    page.say(sentence(found.reason), indent="")
    page.heading("1. Is there a mismatch?")
    page.say(mismatch(found))
    page.heading("2. Where?")
    _where(page, answer)
    page.heading("3. What was left out?")
    _what(page, found)
    page.heading("4. The model with it")
    _model(page, found)
    page.heading("5. Does it fit better?")
    _fit(page, found)
    if found.next_recording:
        page.heading(f"Next recording: {sentence(found.next_recording)}")
    fit = found.comparison
    notes = [note for note in found.notes if fit is None or fit.rule not in note]
    for number, note in enumerate(notes[:_MOST_NOTES]):
        page.heading(f"Note: {sentence(note)}") if number == 0 else page.say(f"Note: {sentence(note)}", indent="")


class _Page:
    """Lines of at most so many columns."""

    def __init__(self, stream: IO[str], width: int) -> None:
        self._stream, self._width = stream, width

    def say(self, text: str, indent: str = _INDENT) -> None:
        """Write a paragraph."""
        for line in wrap(
            text, self._width, initial_indent=indent, subsequent_indent=indent, break_long_words=self._width < WIDTH
        ):
            self._stream.write(f"{line}\n")

    def heading(self, text: str) -> None:
        """Leave a line empty and write a paragraph from the margin."""
        self._stream.write("\n")
        self.say(text, indent="")

    def table(self, names: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Write a small table, the first column to the left, figures to the right."""
        from rich.console import Console

        console = Console(file=self._stream, width=self._width - len(_INDENT), highlight=False, color_system=None)
        with console.capture() as capture:
            console.print(_table(names, rows))
        self._stream.writelines(f"{_INDENT}{line.rstrip()}\n" for line in capture.get().splitlines())


def _table(names: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for number, name in enumerate(names):
        table.add_column(name, justify="left" if number == 0 else "right", overflow="fold", max_width=44)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    return table


def _where(page: _Page, answer: DiagnosisAnswer) -> None:
    found = answer.diagnosis
    if not found.where:
        page.say(nowhere(found))
        return
    shown = found.where[:_MOST_REGIONS]
    page.table(
        ("region", "share of the excess", "by chance"),
        [(place(region, answer.drive_unit), percent(region.share), chance(region.p_value)) for region in shown],
    )
    if len(found.where) > len(shown):
        page.say(f"and {len(found.where) - len(shown)} more (--format json).")


def _what(page: _Page, found: Diagnosis) -> None:
    if not found.effects:
        tried = f" Closest, not good enough: {', '.join(found.attempts)}." if found.attempts else ""
        page.say(f"Nothing is named.{tried}")
    for effect in found.effects:
        page.say(named(effect))
        page.say(effect.equation, indent=2 * _INDENT)
    if found.alternatives:
        page.say(f"The recording cannot tell it from: {others(found)}.")
    law = told(found)
    if law is not None:
        page.say(law[0])
        page.say(law[1], indent=2 * _INDENT)
    for curve in found.unnamed.curves if found.unnamed is not None else ():
        page.say(f"{curve_words(curve)}:")
        page.table(curve.names(), curve.rows())


def _model(page: _Page, found: Diagnosis) -> None:
    rows = [
        (name, measured(value), f"{found.configured[name]:.5g}" if name in found.configured else "")
        for name, value in found.parameters.items()
    ]
    rows += [(f"{e.id}.{name}", measured(value), "") for e in found.effects for name, value in e.parameters.items()]
    if rows:
        page.table(("parameter", "fitted", "configured"), rows)
    else:
        page.say("Nothing was fitted.")


def _fit(page: _Page, found: Diagnosis) -> None:
    fit = found.comparison
    if fit is None:
        page.say("Nothing was fitted.")
        return
    if found.effects or found.verdict == "unnamed":
        page.say(gained(fit))
    page.table((f"RMS error ({unit_words(found)})", "train", "held out", "over noise"), levels(found))
    page.say(tip_words(found))
    page.say(held_out(fit))
