"""Send a diagnosis where the user wants it: page or JSON to stdout and files, a model file, a plot, a report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from coast_cli.errors import UsageError
from coast_cli.output.atomic import check_suffix, write_files
from coast_cli.output.standard_streams import to_stdout
from coast_cli.output.view import stdout_width

if TYPE_CHECKING:
    from coast_cli.diagnosis.answer import Diagnosis
    from coast_cli.recordings.model import Recordings
    from coast_cli.spec.config import Config

RENDERERS = {"table": "coast_cli.output.diagnosis_page", "json": "coast_cli.output.diagnosis_json"}
SUFFIXES = {".txt": "table", ".json": "json"}
PICTURES = (".png", ".svg")


@dataclass(frozen=True)
class DiagnosisAnswer:
    """A diagnosis with what it was made from.

    Attributes:
        config, recordings: as read. provenance: as of every answer. notes: besides the diagnosis' own.
    """

    diagnosis: Diagnosis
    config: Config
    recordings: Recordings
    provenance: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def drive_unit(self) -> str:
        """The unit of what drives the joint, as people write it."""
        joint = self.recordings.joint
        return "N" if joint is not None and joint.runs[0].stroke is None else "mm"


@dataclass(frozen=True)
class Outputs:
    """What is asked for; checked before the diagnosis is made, so that a wrong name costs no minute of fitting."""

    format: str | None = None
    files: tuple[Path, ...] = ()
    model: Path | None = None
    plot: Path | None = None
    report: Path | None = None

    def check(self) -> None:
        """Refuse formats, suffixes and places that cannot be.

        Raises:
            UsageError: naming the option.
        """
        if self.format is not None and self.format not in RENDERERS:
            raise UsageError(f"--format {self.format}: not a format of a diagnosis; allowed: {', '.join(RENDERERS)}.")
        for path in self.files:
            check_suffix("-o", path, SUFFIXES)
        if self.model is not None:
            check_suffix("--save-model", self.model, (".toml",))
        if self.report is not None:
            check_suffix("--report", self.report, (".html", ".htm"))
        if self.plot is not None:
            check_suffix("--plot", self.plot, PICTURES)
        if self.plot is not None or self.report is not None:
            from coast_cli.output.picture import require_matplotlib

            require_matplotlib()

    @property
    def quiet(self) -> bool:
        """Whether stdout stays empty: only files are asked for by -o."""
        return self.format is None and bool(self.files)


def write_diagnosis(answer: DiagnosisAnswer, outputs: Outputs) -> None:
    """Write everything asked for, all files or none.

    Raises:
        UsageError: a file cannot be written, or matplotlib is not installed for a plot.
    """
    contents: dict[Path, bytes] = {path: _text(answer, SUFFIXES[path.suffix.lower()]) for path in outputs.files}
    if outputs.model is not None:
        from coast_cli.diagnosis.model_file import model_text

        text = model_text(answer.config, answer.diagnosis, answer.recordings, str(outputs.model))
        contents[outputs.model] = text.encode()
    if outputs.plot is not None:
        from coast_cli.output.diagnosis_plot import plot_diagnosis

        contents[outputs.plot] = plot_diagnosis(answer.diagnosis).render(outputs.plot.suffix.lower().removeprefix("."))
    if outputs.report is not None:
        from coast_cli.output.diagnosis_report import report_page

        contents[outputs.report] = report_page(answer).encode()
    write_files({path: partial(_put, content) for path, content in contents.items()}, binary=True)
    if not outputs.quiet:
        shown = outputs.format or "table"
        fitted = {"width": stdout_width()} if shown == "table" else {}
        to_stdout(partial(_renderer(shown), answer, **fitted))


def _text(answer: DiagnosisAnswer, format: str) -> bytes:
    stream = StringIO()
    _renderer(format)(answer, stream)
    return stream.getvalue().encode()


def _put(content: bytes, stream: IO[Any]) -> None:
    stream.write(content)


def _renderer(format: str) -> Callable[..., None]:
    found: Callable[..., None] = import_module(RENDERERS[format]).render
    return found
