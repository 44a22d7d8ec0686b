"""``coast trace``: photographs in, a recording of shapes or curvatures out."""

from __future__ import annotations

from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated

import typer

from coast_cli.cli.options import FormatOption, OutputOption
from coast_cli.cli.paths import READS, Writes

if TYPE_CHECKING:
    from coast_cli.recordings.trace_sequence import PictureFrame

ImagesArgument = Annotated[
    list[Path], typer.Argument(metavar="IMAGE...", help="photographs of one tube, in order", show_default=False), READS
]


def trace(
    images: ImagesArgument,
    *,
    scale: Annotated[float, typer.Option(metavar="MM_PER_PX", help="millimetres to a pixel")],
    clamp: Annotated[
        str | None, typer.Option(metavar="X,Y", help="pixel where the tube leaves its clamp; else its left end")
    ] = None,
    kind: Annotated[str, typer.Option(help="shape: points of each frame; joint: one curvature a frame")] = "shape",
    tube: Annotated[
        str | None, typer.Option(metavar="NAME", help="shape: the tube, or OUTER/MIDDLE; else the config's joint.pair")
    ] = None,
    points: Annotated[int, typer.Option(help="shape: points from clamp to tip")] = 60,
    drive: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="joint: CSV, a row a frame (stroke_mm, bending_length_mm, ...)"),
        READS,
    ] = None,
    overlay: Annotated[
        Path | None,
        typer.Option(metavar="DIR|FILE.png", help="draw the trace on the photograph, to look at"),
        Writes(lambda given: _overlay_paths(given["overlay"], given["images"])),
    ] = None,
    format: FormatOption = None,
    output: OutputOption = None,
) -> None:
    """Trace the centreline of a notched tube in photographs, with its uncertainty.

    Needs the extra `vision`. A frame without one whole tube is an error, or with --kind joint a dropped frame.
    """
    from functools import partial

    from coast_cli.errors import UsageError
    from coast_cli.output.answer import Answer
    from coast_cli.output.provenance import provenance
    from coast_cli.output.write import write_answer
    from coast_cli.recordings.trace_image import require_vision

    if kind not in {"shape", "joint"}:
        raise UsageError(f"--kind {kind}: allowed: shape, joint.")
    if not 0.0 < scale < float("inf"):
        raise UsageError(f"--scale {scale:g}: must be a positive number of millimetres to a pixel.")
    if not 3 <= points <= 100_000:
        raise UsageError(f"--points {points}: allowed: 3 to 100000.")
    if kind == "shape" and drive is not None:
        raise UsageError("--drive belongs to --kind joint.")
    if kind == "joint" and tube is not None:
        raise UsageError("--tube belongs to --kind shape; name the tubes of a joint in columns of --drive.")
    place = None if clamp is None else _pixel(clamp)
    pictures = [] if overlay is None else _overlay_paths(overlay, images)
    require_vision()

    from coast_cli.recordings.trace_sequence import digest, joint_rows, read_drive, shape_rows, trace_frames

    known = None if drive is None else read_drive(drive, len(images))
    frames = trace_frames(images, mm_per_px=scale, clamp=place, keep_failures=kind == "joint")
    notes = tuple(note for frame in frames for note in frame.notes)
    if kind == "shape":
        rows = shape_rows(frames, points=points, tube=tube)
        notes += tuple(frame.caption for frame in frames)
    else:
        rows, more = joint_rows(frames, known)
        notes += more
    if pictures:
        from coast_cli.output.atomic import write_files

        writers = {place: partial(_draw, frame) for place, frame in zip(pictures, frames, strict=True)}
        write_files(writers, binary=True)
    sources = [(str(path), digest(path)) for path in images]
    options = {"scale_mm_per_px": scale, "clamp_px": place and list(place), "kind": kind}
    write_answer(Answer("trace", rows, provenance(recordings=sources, options=options), notes), format, output or ())


def _pixel(text: str) -> tuple[float, float]:
    from coast_cli.cli.options import numbers
    from coast_cli.errors import UsageError

    values = numbers(text, "--clamp")
    if len(values) != 2:
        raise UsageError(f"--clamp {text}: allowed: X,Y in pixels, column and row.")
    return values[0], values[1]


def _overlay_paths(overlay: Path, images: list[Path]) -> list[Path]:
    """Where each overlay goes: the one file, or NAME.overlay.png in a folder, which is made if need be."""
    from coast_cli.errors import UsageError

    if overlay.suffix.lower() == ".png":
        if len(images) > 1:
            raise UsageError(f"--overlay {overlay}: one file for {len(images)} images; give a folder.")
        return [overlay]
    paths = [overlay / f"{image.stem}.overlay.png" for image in images]
    if len(set(paths)) < len(paths):
        raise UsageError(f"--overlay {overlay}: two images have the same name, so would their overlays.")
    try:
        overlay.mkdir(exist_ok=True)
    except OSError as error:
        raise UsageError(f"--overlay {overlay}: cannot be made ({error.strerror or error}).") from None
    return paths


def _draw(frame: PictureFrame, stream: IO[bytes]) -> None:
    from coast_cli.recordings.trace_overlay import overlay_png

    stream.write(overlay_png(frame.path, frame.trace, frame.caption))
