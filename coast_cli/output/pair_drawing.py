"""A drawing to scale of the tubes of a joint: some pitches from the side, and the sections of a ring and of a notch."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from math import acos, cos, sin

from coast_cli.mechanics.tube import NotchedTube
from coast_cli.units import MILLIMETRE

_PITCHES = 8
_LINE = 0.008  # mm
_GAP = 0.35
_COLOURS = ("#0072B2", "#D55E00")


def drawing_alone(outer: NotchedTube | None, middle: NotchedTube, tendon_radius: float | None = None) -> str:
    """Return the drawing as an SVG file of its own, on white."""
    svg = drawing(outer, middle, tendon_radius)
    svg = svg[svg.index("<svg") : svg.index("</svg>")] + "</svg>\n"
    ground = 'width="900" xmlns="http://www.w3.org/2000/svg" style="background: #fff; color: #1a1a1a; font-family: sans-serif"'
    return svg.replace('class="drawing"', ground, 1)


def drawing(outer: NotchedTube | None, middle: NotchedTube, tendon_radius: float | None = None) -> str:
    """Return SVG of the last pitches before the tip; the outer tube's notches face down, the middle tube's up.

    Args:
        outer, middle: the tubes; outer is None for a joint of one tube.
        tendon_radius: m, or None where there is no tendon.
    """
    tubes = [tube for tube in (outer, middle) if tube is not None]
    count = min(_PITCHES, *(tube.depth.size for tube in tubes))
    length = max(_millimetres(tube, count) for tube in tubes)
    radius = max(tube.outer_radius for tube in tubes) / MILLIMETRE
    size = max(0.16 * radius / 0.25, 0.01 * length)
    across = length + _GAP + 4.0 * radius + 2.0 * _GAP
    height = 2.0 * radius + 3.4 * size
    parts = [*_side(tubes, count), *_tendon(tendon_radius, length), *_scale(radius, size)]
    for place, at_notch in enumerate((False, True)):
        centre = length + _GAP + radius + place * (2.0 * radius + _GAP)
        parts += [f'<g transform="translate({_n(centre)} 0)">', *_section(tubes, at_notch=at_notch)]
        if tendon_radius is not None:
            parts.append(f'<circle r="{_n(tendon_radius / MILLIMETRE)}" fill="currentColor"/>')
        parts += [_text(0.0, radius + 1.2 * size, size, "notch" if at_notch else "ring", "middle"), "</g>"]
    said = "; ".join(_said(tube) for tube in tubes)
    view = f"{_n(-0.05)} {_n(-radius - 0.4 * size)} {_n(across + 0.1)} {_n(height)}"
    return (
        f'<figure>\n<svg class="drawing" viewBox="{view}" role="img" aria-label="{escape(said)}" '
        f'font-family="inherit">\n'
        + "\n".join(parts)
        + f"\n</svg>\n<figcaption>To scale: {escape(said)}.</figcaption>\n</figure>"
    )


def _side(tubes: list[NotchedTube], count: int) -> Iterator[str]:
    """Yield the tubes from the side: whole rings, and what each notch leaves."""
    for number, tube in enumerate(tubes):
        radius, at = tube.outer_radius / MILLIMETRE, 0.0
        down = number == 0 and len(tubes) > 1
        style = f'fill="{_COLOURS[-len(tubes) :][number]}" fill-opacity="{0.3 + 0.35 * (not down)}" stroke="none"'
        for depth, cut, uncut in zip(tube.depth[-count:], tube.cut[-count:], tube.uncut[-count:], strict=True):
            ring, gap, left = uncut / MILLIMETRE, cut / MILLIMETRE, 2.0 * radius - depth / MILLIMETRE
            yield f'<rect x="{_n(at)}" y="{_n(-radius)}" width="{_n(ring)}" height="{_n(2.0 * radius)}" {style}/>'
            y = -radius if down else radius - left
            yield f'<rect x="{_n(at + ring)}" y="{_n(y)}" width="{_n(gap)}" height="{_n(left)}" {style}/>'
            at += ring + gap


def _section(tubes: list[NotchedTube], *, at_notch: bool) -> Iterator[str]:
    """Yield what a plane across the tubes meets: annuli, or what the last notch leaves of them."""
    for number, tube in enumerate(tubes):
        down = number == 0 and len(tubes) > 1
        style = f'fill="{_COLOURS[-len(tubes) :][number]}" fill-opacity="{0.45 if down else 0.75}"'
        outer, inner = tube.outer_radius / MILLIMETRE, tube.inner_radius / MILLIMETRE
        if not at_notch:
            yield f'<path fill-rule="evenodd" d="{_circle(outer)} {_circle(inner)}" {style}/>'
            continue
        half = acos(min(max((float(tube.depth[-1]) / MILLIMETRE - outer) / outer, -1.0), 1.0))
        turn = -1.0 if down else 1.0
        x_out, y_out, x_in, y_in = outer * sin(half), outer * cos(half), inner * sin(half), inner * cos(half)
        sweep = 0 if down else 1
        yield (
            f'<path d="M {_n(x_out)} {_n(turn * y_out)} A {_n(outer)} {_n(outer)} 0 0 {sweep} {_n(-x_out)} {_n(turn * y_out)} '
            f'L {_n(-x_in)} {_n(turn * y_in)} A {_n(inner)} {_n(inner)} 0 0 {1 - sweep} {_n(x_in)} {_n(turn * y_in)} Z" {style}/>'
        )


def _tendon(radius: float | None, length: float) -> Iterator[str]:
    if radius is not None:
        width = 2.0 * radius / MILLIMETRE
        yield f'<rect x="0" y="{_n(-width / 2.0)}" width="{_n(length)}" height="{_n(width)}" fill="currentColor"/>'


def _scale(radius: float, size: float) -> Iterator[str]:
    y = radius + 0.7 * size
    yield f'<path d="M 0 {_n(y)} h 1" stroke="currentColor" stroke-width="{_n(3.0 * _LINE)}"/>'
    yield _text(1.0 + 0.4 * size, y + 0.35 * size, size, "1 mm", "start")


def _text(x: float, y: float, size: float, text: str, anchor: str) -> str:
    where = f'x="{_n(x)}" y="{_n(y)}" font-size="{_n(size)}" text-anchor="{anchor}"'
    return f'<text {where} fill="currentColor">{escape(text)}</text>'


def _said(tube: NotchedTube) -> str:
    depth, cut, uncut = (float(values[-1]) / MILLIMETRE for values in (tube.depth, tube.cut, tube.uncut))
    return (
        f"{tube.name} {2e3 * tube.outer_radius:.4g} mm outside, {2e3 * tube.inner_radius:.4g} inside, "
        f"{tube.depth.size} notches {depth:.4g} deep, cut {cut:.4g}, uncut {uncut:.4g}"
    )


def _millimetres(tube: NotchedTube, count: int) -> float:
    return float((tube.cut[-count:] + tube.uncut[-count:]).sum()) / MILLIMETRE


def _circle(radius: float) -> str:
    r = _n(radius)
    return f"M {r} 0 A {r} {r} 0 1 1 -{r} 0 A {r} {r} 0 1 1 {r} 0 Z"


def _n(value: float) -> str:
    return f"{value + 0.0:.4g}"
