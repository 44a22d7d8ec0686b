"""Rows of many frames: points of shapes, or one curvature a frame of a joint, beside the drive that the user knows.

A frame that cannot be traced stops a shape file, whose every row must be a point. In a joint it is a dropped frame: its
row stays, with an empty response and the reason in ``flag``.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from coast_cli.errors import BadInput
from coast_cli.recordings.trace import Trace, trace_image
from coast_cli.recordings.trace_image import BadFrame

if TYPE_CHECKING:
    from collections.abc import Sequence

Row = dict[str, str | float | int | None]


@dataclass(frozen=True)
class PictureFrame:
    """One image of a sequence: its trace, or the error that says why there is none."""

    path: Path
    trace: Trace | None
    error: BadFrame | None

    @property
    def flag(self) -> str:
        """A word on what is wrong or doubtful, or nothing."""
        return self.error.flag if self.error else self.trace.flag if self.trace else ""

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know about the frame."""
        if self.error:
            return (f"{self.error} The frame is dropped.",)
        return tuple(f"{self.path}: {note}." for note in self.trace.notes) if self.trace else ()

    @property
    def caption(self) -> str:
        """One line for the overlay."""
        if self.trace is None:
            return f"{self.path.name}: {self.error.message if self.error else ''}"
        trace = self.trace
        curvature = trace.arc.curvature / (trace.mm_per_px * 1e-3)
        return (
            f"{self.path.name}: curvature {curvature:.3f} +- {trace.curvature_std_per_m:.3f} 1/m, "
            f"length {trace.length_mm:.3f} mm {trace.flag}"
        )


def trace_frames(
    paths: Sequence[Path], *, mm_per_px: float, clamp: tuple[float, float] | None, keep_failures: bool
) -> list[PictureFrame]:
    """Trace images in order.

    Args:
        paths: the images.
        mm_per_px, clamp: as for `trace_image`; the camera stands still.
        keep_failures: return a frame that shows no whole tube as such, unless they all do.

    Raises:
        BadInput: an image that cannot be read, or (``BadFrame``) traced.
    """
    frames = []
    for path in paths:
        try:
            frames.append(PictureFrame(path, trace_image(path, mm_per_px=mm_per_px, clamp=clamp), None))
        except BadFrame as error:
            if not keep_failures:
                raise
            frames.append(PictureFrame(path, None, error.with_traceback(None)))
    failures = [frame.error for frame in frames if frame.error]
    if len(failures) == len(frames):
        raise failures[0]
    return frames


def shape_rows(frames: Sequence[PictureFrame], *, points: int, tube: str | None) -> list[Row]:
    """Return the points of every frame, a run each; without ``tube`` the reader takes the pair of its config."""
    stems = Counter(frame.path.stem for frame in frames)
    rows: list[Row] = []
    for frame in frames:
        if frame.trace is None:
            continue
        run = frame.path.stem if stems[frame.path.stem] == 1 else str(frame.path)
        head: Row = {"run": run} if tube is None else {"run": run, "tube": tube}
        for x, y, std in zip(*frame.trace.points_mm(points), strict=True):
            rows.append({**head, "x_mm": float(x), "y_mm": float(y), "std_mm": float(std), "flag": frame.flag or None})
    return rows


def joint_rows(frames: Sequence[PictureFrame], drive: Sequence[Row] | None) -> tuple[list[Row], tuple[str, ...]]:
    """Return one row a frame, with the columns of the drive first, and notes.

    Curvature is positive the way the sequence bends most, since a camera may look at the joint from either side.
    """
    traces = [frame.trace for frame in frames if frame.trace]
    largest = max((trace.arc.curvature for trace in traces), key=abs)
    sign = -1.0 if largest < 0 else 1.0
    rows: list[Row] = []
    for number, frame in enumerate(frames):
        row: Row = {"run": frames[0].path.stem, **(drive[number] if drive else {}), "frame": frame.path.name}
        trace = frame.trace
        row["curvature_per_m"] = sign * trace.arc.curvature / (trace.mm_per_px * 1e-3) if trace else None
        row["std_per_m"] = trace.curvature_std_per_m if trace else None
        row["misfit_mm"] = trace.arc.spread * trace.mm_per_px if trace else None
        row["length_mm"] = trace.length_mm if trace else None
        row["flag"] = frame.flag or None
        rows.append(row)
    side = "left" if sign > 0 else "right"
    notes = [f"positive curvature turns to the {side} on the image, seen from the clamp: the way the frames bend most."]
    if drive is None:
        notes.append("without a drive there is no stroke or tension column, which a joint recording needs.")
    return rows, tuple(notes)


def read_drive(path: Path, frames: int) -> list[Row]:
    """Return the rows of a CSV file with what is known of each frame, such as stroke_mm and bending_length_mm.

    Raises:
        BadInput: the file cannot be read, has another number of rows, or a column that the trace gives itself.
    """
    from coast_cli.recordings.table import read_table

    table = read_table(str(path))
    ours = {"frame", "curvature_per_m", "std_per_m", "misfit_mm", "length_mm", "flag"}
    if clash := [name for name in table.names if name in ours]:
        raise BadInput("the trace gives this column itself", file=path, line=table.header_line, found=clash[0])
    if len(table.line) != frames:
        raise BadInput("one row a frame is needed", file=path, found=f"{len(table.line)} rows, {frames} frames")
    columns = {
        name: [_cell(cell.decode("utf-8").strip(), table.decimal) for cell in cells.tolist()]
        for name, cells in zip(table.names, table.columns, strict=True)
    }
    return [{name: cells[row] for name, cells in columns.items()} for row in range(frames)]


def _cell(text: str, decimal: str) -> str | float:
    try:
        return float(text.replace(decimal, "."))
    except ValueError:
        return text


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return sha256(path.read_bytes()).hexdigest()
