"""A diagnosis as a page for the terminal: five answers in order, each with its number, within 80 columns."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import IO, TYPE_CHECKING

from coast_cli.output.diagnosis_words import (
    HEADLINES,
    against_noise,
    figure,
    gained,
    judged,
    measured,
    percent,
    place,
    unit_of,
)

if TYPE_CHECKING:
    from rich.table import Table

    from coast_cli.diagnosis.answer import Diagnosis, Level
    from coast_cli.output.diagnosis import DiagnosisAnswer

WIDTH = 80
_INDENT = "   "
_MOST_REGIONS = 5
_MOST_NOTES = 6


def render(answer: DiagnosisAnswer, stream: IO[str]) -> None:
    """Write the page."""
    found = answer.diagnosis
    page = _Page(stream)
    page.say(f"{HEADLINES[found.verdict]} (verdict: {found.verdict})", indent="")
    page.say(f"{_sentence(found.reason)}", indent="")
    page.heading(1, "Is there a mismatch?")
    _mismatch(page, found)
    page.heading(2, "Where?")
    _where(page, found)
    page.heading(3, "What was left out?")
    _what(page, found)
    page.heading(4, "The model with it")
    _model(page, found)
    page.heading(5, "Does it fit better?")
    _fit(page, found)
    if found.next_recording:
        page.gap()
        page.say(f"Next recording: {_sentence(found.next_recording)}", indent="")
    notes = [note for note in found.notes if found.comparison is None or found.comparison.rule not in note]
    if notes:
        page.gap()
        for note in notes[:_MOST_NOTES]:
            page.say(f"Note: {_sentence(note)}", indent="")
    for config in answer.provenance.get("configs", ()):
        page.gap()
        page.say(f"{config['file']}  sha256 {config['sha256'][:16]}", indent="")


class _Page:
    """Lines of at most 80 columns."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream

    def say(self, text: str, indent: str = _INDENT) -> None:
        """Write a paragraph."""
        for line in wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent, break_long_words=False):
            self._stream.write(f"{line}\n")

    def gap(self) -> None:
        """Leave a line empty."""
        self._stream.write("\n")

    def heading(self, number: int, text: str) -> None:
        """Begin an answer."""
        self.gap()
        self.say(f"{number}. {text}", indent="")

    def table(self, names: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """Write a small table, the first column to the left, figures to the right."""
        from rich.console import Console

        console = Console(file=self._stream, width=WIDTH, highlight=False, color_system=None)
        with console.capture() as capture:
            console.print(_table(names, rows))
        self._stream.writelines(f"{_INDENT}{line.rstrip()}\n" for line in capture.get().splitlines())


def _table(names: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for place_, name in enumerate(names):
        table.add_column(name, justify="left" if place_ == 0 else "right", overflow="fold", max_width=44)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    return table


def _mismatch(page: _Page, found: Diagnosis) -> None:
    unit, fit = unit_of(found), found.comparison
    if fit is None:
        page.say(f"Not decided. The noise of the recording is {figure(found.noise)} {unit}.")
        return
    error = judged(fit.refitted)
    page.say(
        f"{'No' if found.verdict in ('agrees', 'parameters') else 'Yes'}: base model "
        f"{'as configured' if found.verdict == 'agrees' else 'refitted'} "
        f"{figure(judged(fit.configured) if found.verdict == 'agrees' else error)} {unit} RMS, "
        f"noise {figure(found.noise)} {unit}."
    )


def _where(page: _Page, found: Diagnosis) -> None:
    if not found.where:
        page.say("Nowhere: no part of the recording holds more error than the rest.")
        return
    shown = found.where[:_MOST_REGIONS]
    page.table(
        ("region", "share of the excess", "by chance"),
        [(place(r), percent(r.share), f"{r.p_value:.0e}" if r.p_value >= 1e-99 else "< 1e-99") for r in shown],
    )
    if len(found.where) > len(shown):
        page.say(f"and {len(found.where) - len(shown)} more (--format json).")


def _what(page: _Page, found: Diagnosis) -> None:
    if not found.effects:
        tried = f" Closest, not good enough: {', '.join(found.attempts)}." if found.attempts else ""
        page.say(f"Nothing is named.{tried}")
        return
    for effect in found.effects:
        page.say(f"{effect.id}: {effect.title} ({effect.component}; {effect.kind})")
        page.say(effect.equation, indent=2 * _INDENT)
    page.say(f"Confidence {percent(found.effects[0].confidence)}.")
    if found.alternatives:
        page.say(f"The recording cannot tell it from: {'; '.join(' + '.join(ids) for ids in found.alternatives)}.")


def _model(page: _Page, found: Diagnosis) -> None:
    rows = [
        (name, measured(value), f"{found.configured[name]:.5g}" if name in found.configured else "")
        for name, value in found.parameters.items()
    ]
    rows += [
        (f"{effect.id}.{name}", measured(value), "")
        for effect in found.effects
        for name, value in effect.parameters.items()
    ]
    if rows:
        page.table(("parameter", "fitted", "configured"), rows)
    else:
        page.say("Nothing was fitted.")


def _fit(page: _Page, found: Diagnosis) -> None:
    fit = found.comparison
    if fit is None:
        page.say("Nothing was fitted.")
        return
    unit = unit_of(found)
    if found.effects:
        page.say(gained(fit))
    models = [("as configured", fit.configured), ("base refitted", fit.refitted)]
    if found.effects or found.attempts:
        models.append(("with effects" if found.effects else "closest effects", fit.with_effects))
    page.table(
        (f"RMS error ({unit})", "train", "held out", "over noise"),
        [(label, figure(level.train), figure(level.held_out), _over(found, level)) for label, level in models]
        + [("noise", figure(found.noise), "", "")],
    )
    page.say(f"Tip: {figure(fit.tip_mm_refitted)} mm refitted, {figure(fit.tip_mm_with_effects)} mm with effects.")
    runs = ", ".join(fit.held_out_runs)
    page.say(f"Held out: {runs + ' (' + fit.rule + ')' if runs else fit.rule}.")


def _over(found: Diagnosis, level: Level) -> str:
    return against_noise(found, judged(level))


def _sentence(text: str) -> str:
    """Return the text as a sentence; a parameter's name that begins it keeps its letters."""
    begins_with_name = "_" in text.partition(" ")[0]
    begun = text if begins_with_name else text[:1].upper() + text[1:]
    return begun if begun.endswith((".", "?", "!")) else f"{begun}."
