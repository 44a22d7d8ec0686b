"""A picture to judge a trace by: the photograph with the centreline, the sections it rests on, and the circle."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray
    from PIL.ImageDraw import ImageDraw

    from coast_cli.recordings.trace import Trace

    Floats = NDArray[np.float64]

CENTRELINE, CIRCLE, EDGE, LEFT_OUT, ENDS = "#e6194b", "#4363d8", "#3cb44b", "#f58231", "#ffe119"
LEAST = 1200  # pixels across; smaller photographs are enlarged


def overlay_png(path: Path, trace: Trace | None, caption: str) -> bytes:
    """Return a PNG of the photograph with its trace, or of the photograph alone where there is none.

    Edges of the sections used are green, of those left out orange; the centreline is red, the circle blue; the clamp a
    square and the tip a ring, yellow.
    """
    from PIL import Image, ImageDraw

    from coast_cli.recordings.trace_image import read_grey

    levels = read_grey(path)
    span = max(float(np.ptp(levels)), 1e-9)
    picture = Image.fromarray(((levels - levels.min()) * (255 / span)).astype(np.uint8)).convert("RGB")
    zoom = max(1, -(-LEAST // max(picture.size)))
    picture = picture.resize((picture.width * zoom, picture.height * zoom), Image.Resampling.BICUBIC)
    draw = ImageDraw.Draw(picture)
    thick = max(round(max(picture.size) / 1200), 1)
    if trace is not None:
        _draw_trace(draw, trace, zoom, thick)
    size = 16 * thick
    whole = Image.new("RGB", (picture.width, picture.height + size + 12), "black")
    whole.paste(picture, (0, size + 12))
    ImageDraw.Draw(whole).text((6, 4), caption, fill="white", font_size=size)
    stream = BytesIO()
    whole.save(stream, "PNG", compress_level=3)
    return stream.getvalue()


def _draw_trace(draw: ImageDraw, trace: Trace, zoom: int, thick: int) -> None:
    sections = trace.sections
    inside = (sections.s >= trace.clamp) & (sections.s <= trace.tip)
    x, y, angle = trace.curve.at(sections.s)
    for offset in (sections.left, sections.right):
        for use, colour in ((~sections.full, LEFT_OUT), (sections.full, EDGE)):
            seen = inside & use & np.isfinite(offset)
            _dots(draw, (x - offset * np.sin(angle))[seen], (y - offset * np.cos(angle))[seen], zoom, thick, colour)
    _line(draw, *_circle(trace), zoom, thick, CIRCLE)
    _line(draw, *trace.points_px(400)[:2], zoom, thick, CENTRELINE)
    ends_x, ends_y, _ = trace.points_px(2)
    reach = max(5 * thick, 0.3 * sections.width * zoom)
    for mark, px, py in zip((draw.rectangle, draw.ellipse), ends_x, ends_y, strict=True):
        cx, cy = (px + 0.5) * zoom, (py + 0.5) * zoom
        mark((cx - reach, cy - reach, cx + reach, cy + reach), outline=ENDS, width=2 * thick)


def _circle(trace: Trace) -> tuple[Floats, Floats]:
    """Return the fitted circle over the length of the tube, both ways from beside its middle."""
    middle_x, middle_y, _ = trace.points_px(3)
    foot_x, foot_y, angle = trace.arc.foot(float(middle_x[1]), float(middle_y[1]))
    s = np.linspace(-0.5, 0.5, 401) * (trace.tip - trace.clamp)
    half = trace.arc.curvature * s / 2
    chord = s * np.sinc(half / np.pi)
    return foot_x + chord * np.cos(angle + half), foot_y - chord * np.sin(angle + half)


def _line(draw: ImageDraw, x: Floats, y: Floats, zoom: int, thick: int, colour: str) -> None:
    draw.line(list(zip((x + 0.5) * zoom, (y + 0.5) * zoom, strict=True)), fill=colour, width=thick)


def _dots(draw: ImageDraw, x: Floats, y: Floats, zoom: int, thick: int, colour: str) -> None:
    half = max(thick / 2, 0.5)
    for px, py in zip((x + 0.5) * zoom, (y + 0.5) * zoom, strict=True):
        draw.rectangle((px - half, py - half, px + half, py + half), fill=colour)
