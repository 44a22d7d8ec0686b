"""One configuration as one HTML page: a sheet of answers, then the details behind each, and the inputs last.

The page needs nothing from outside and no script. Without matplotlib it has its tables, and says how to get the pictures.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from coast_cli.output.atomic import check_suffix, write_files
from coast_cli.output.diagnosis_report import sections
from coast_cli.output.diagnosis_words import HEADLINES
from coast_cli.output.html import footer, page, paragraph, section
from coast_cli.output.pair_drawing import drawing_alone
from coast_cli.output.pdf import pdf_of, require_printer
from coast_cli.output.picture import can_draw
from coast_cli.output.progress import waiting
from coast_cli.output.report_contents import CURVATURES, DesignReport, Wanted, contents
from coast_cli.output.report_design import (
    checks_section,
    ranking_section,
    shapes_section,
    strokes_section,
    tolerance_section,
)
from coast_cli.output.report_first import drawn_design, first_sheet
from coast_cli.output.report_inputs import inputs_section
from coast_cli.spec.build import build

if TYPE_CHECKING:
    from coast_cli.recordings.model import Recordings
    from coast_cli.spec.config import Config

NO_PICTURES = "There are no pictures, since matplotlib is not installed: `pip install matplotlib` and run it again."


SUFFIXES = (".html", ".htm", ".pdf", ".svg")


def report(
    config: Config,
    path: str | Path,
    recordings: Recordings | None = None,
    *,
    pair: str | None = None,
    curvatures: Sequence[float] = CURVATURES,
    bending_lengths: Sequence[float] | None = None,
    samples: int = 10_000,
    seed: int = 0,
    hold_out: Sequence[str] = (),
) -> None:
    """Write all that is known of a design as one page (.html, .pdf), or the drawing of the pair alone (.svg).

    Args:
        config: of the design. path: of the file. recordings: to diagnose with it; None leaves that out.
        pair: ``OUTER/MIDDLE``; None is the configuration's. curvatures: of the stroke table, 1/m.
        bending_lengths: of the stroke table, m; None: 20, 30 and 40 mm, or half and all of shorter tubes.
        samples: over the tolerances, 0 for none. seed: of their random numbers. hold_out: runs that no fit may see.

    Raises:
        BadInput: the pair is unknown or left open, or the configuration contradicts itself.
        UsageError: another suffix, a folder that is not there, or nothing that prints a PDF.

    Example:
        >>> coast.report(coast.load_config(coast.REFERENCE), "no/such/folder/report.html", samples=0)
        Traceback (most recent call last):
        coast_cli.errors.UsageError: ...
    """
    path = Path(path)
    check_suffix("-o", path, SUFFIXES)
    suffix = path.suffix.lower()
    if suffix == ".pdf":
        require_printer(path)
    design = build(config)
    if suffix == ".svg":
        drawing = drawing_alone(*drawn_design(design, pair))
        write_files({path: lambda stream: stream.write(drawing)})
        return
    found = contents(design, Wanted(pair, curvatures, bending_lengths, samples, seed, hold_out), recordings)
    with waiting("drawing"):
        text = page_of(found)
        content = pdf_of(text) if suffix == ".pdf" else text.encode()
    write_files({path: lambda stream: stream.write(content)}, binary=True)


def page_of(answer: DesignReport) -> str:
    """Return the page; the same answer gives the same text."""
    parts = _parts(answer)
    titles = {anchor: title for anchor, (title, _) in parts.items()} | {"provenance": "Provenance"}
    links = "\n".join(f'<a href="#{anchor}">{escape(title)}</a>' for anchor, title in titles.items())
    body = [
        f"<h1>{escape(answer.pair)}: design report</h1>",
        _inputs_line(answer),
        first_sheet(answer),
        paragraph("" if can_draw() else NO_PICTURES),
        f"<nav>\n{links}\n</nav>",
    ]
    body.append('<div class="details">')
    for anchor, (title, content) in parts.items():
        body.append(section(title, content or paragraph(answer.missing[anchor]), anchor=anchor))
    body.append(section(titles["provenance"], _provenance(), footer(answer.provenance), anchor="provenance"))
    body.append("</div>")
    return page(f"coast report: {answer.pair}, {answer.config.source}", body)


def _parts(answer: DesignReport) -> dict[str, tuple[str, str]]:
    """Return title and content of each section by its anchor; a content that is left out is empty."""
    config, pair = answer.config, answer.pair
    parts: dict[str, tuple[str, str]] = {}
    if answer.diagnosis is not None:
        headline = HEADLINES[answer.diagnosis.diagnosis.verdict]
        content = "\n".join([f"<p><b>{escape(headline)}</b></p>", *sections(answer.diagnosis, level=3)])
        parts["diagnosis"] = ("Diagnosis of the recordings", content)
    tolerances = tolerance_section(config, pair, answer.tolerance, answer.samples) if answer.tolerance else ""
    return parts | {
        "checks": ("Checks", checks_section(config, answer.checks) if answer.checks else ""),
        "tolerances": ("Tolerances", tolerances),
        "ranking": ("Ranking", ranking_section(answer.ranking, answer.rank_options, pair) if answer.ranking else ""),
        "strokes": (f"Strokes of {pair}", strokes_section(*answer.strokes) if answer.strokes else ""),
        "shapes": ("Shapes under gravity", shapes_section(*answer.shapes, pair)),
        "inputs": ("Inputs", inputs_section(config)),
    }


def _inputs_line(answer: DesignReport) -> str:
    """Return which file this is about and which version said so."""
    config = answer.provenance["configs"][0]
    version = answer.provenance["versions"]["coast"]
    return (
        f"<p><code>{escape(config['file'])}</code>, sha256 <code>{config['sha256'][:16]}</code>, by coast {version}</p>"
    )


def _provenance() -> str:
    return paragraph(
        "The same files, options and versions give the same page to the byte. The digest of a configuration is of what it "
        "says, whatever its comments and order. Models, equations and their limits: `coast explain NAME`, and the paper, "
        '"Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023).'
    )
