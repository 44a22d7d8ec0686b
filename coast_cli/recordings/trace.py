"""Trace the centreline of a notched tube in a photograph, with its uncertainty: what P does with a CMOS camera.

threshold -> connected component -> medial ridge -> edges of full sections -> smoothing spline -> circle.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.trace_image import BadFrame, read_grey, require_vision

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.trace_centreline import Sections
    from coast_cli.recordings.trace_spline import Arc, SplineCurve

    Floats = NDArray[np.float64]
    Image = NDArray[np.float32]


@dataclass(frozen=True)
class Trace:
    """One traced frame. Lengths in pixels of the photograph, unless the name says otherwise.

    Attributes:
        source: the image.
        mm_per_px: its scale.
        curve: the centreline; the clamp is at arc length ``clamp``, the tip at ``tip``.
        sections: the cross-sections that it was fitted to.
        arc: the circle through the sections from clamp to tip.
        mirrored: True where the tube leaves the clamp to the left of the image, so that x is turned round.
        flag: what makes the frame doubtful, one or two words, or empty.
        notes: the same in sentences.
    """

    source: Path
    mm_per_px: float
    curve: SplineCurve
    sections: Sections
    arc: Arc
    clamp: float
    tip: float
    mirrored: bool
    flag: str
    notes: tuple[str, ...]

    @property
    def length_mm(self) -> float:
        """Arc length from clamp to tip."""
        return (self.tip - self.clamp) * self.mm_per_px

    @property
    def curvature_per_m(self) -> float:
        """Curvature of the circle, positive where the tube bends towards the top of the image."""
        return (-1 if self.mirrored else 1) * self.arc.curvature / (self.mm_per_px * 1e-3)

    @property
    def curvature_std_per_m(self) -> float:
        """Standard deviation of that curvature; the scale is taken as exact."""
        return self.arc.std / (self.mm_per_px * 1e-3)

    def points_px(self, count: int) -> tuple[Floats, Floats, Floats]:
        """Return x, y and standard deviation across, of points evenly spaced from clamp to tip."""
        s = np.linspace(self.clamp, self.tip, count)
        x, y, _ = self.curve.at(s)
        return x, y, np.hypot(self.curve.std(s), self.sections.bias)

    def points_mm(self, count: int) -> tuple[Floats, Floats, Floats]:
        """Return the same in millimetres from the clamp, x along the tube's way out and y against gravity."""
        x, y, std = self.points_px(count)
        along = x[0] - x if self.mirrored else x - x[0]
        return along * self.mm_per_px, (y[0] - y) * self.mm_per_px, std * self.mm_per_px


def trace_image(path: Path, *, mm_per_px: float, clamp: tuple[float, float] | None = None) -> Trace:
    """Return the centreline of the tube in one image file.

    Args:
        path: the image; anything Pillow reads, one frame.
        mm_per_px: scale of the photograph.
        clamp: pixel (x, y) where the bending segment leaves its clamp; without it, the left end of the tube.

    Raises:
        BadInput: the file is no readable image.
        BadFrame: it does not show one whole tube; ``flag`` says why in a word.
        UsageError: the extra `vision` is not installed.
    """
    require_vision()
    try:
        return trace_levels(read_grey(path), mm_per_px=mm_per_px, clamp=clamp, source=path)
    except BadFrame as error:
        named = error.of_file(path)
    raise named  # not from the error, whose traceback would keep the photograph in memory


def trace_levels(
    levels: Image, *, mm_per_px: float, clamp: tuple[float, float] | None = None, source: Path = Path("image")
) -> Trace:
    """Return the centreline of the tube in grey levels of shape (rows, columns); see `trace_image`."""
    from coast_cli.recordings.trace_centreline import medial_path
    from coast_cli.recordings.trace_spline import fit_arc
    from coast_cli.recordings.trace_threshold import find_silhouette

    silhouette = find_silhouette(levels)
    path = medial_path(silhouette)
    way = _leftmost_first(np.stack([path.x, path.y], axis=1))
    curve, sections = _refined(silhouette.contrast, way, path.radius, rounds=3)
    _refuse_cut_off_side(sections)
    if _tip_comes_first(curve, sections, clamp):
        x, y, _ = curve.at(np.linspace(curve.length, 0, 400))
        curve, sections = _refined(silhouette.contrast, np.stack([x, y], axis=1), path.radius, rounds=1)
    ends = _ends(sections)
    borders = _borders(sections, *ends)
    if borders[1]:
        raise _cut_off("the tip of the tube is cut off at the border of the image", at=curve.at(np.array([ends[1]])))
    first, last = _clamped(curve, sections, ends, clamp)
    chosen = sections.full & (sections.s >= first) & (sections.s <= last)
    flag, notes = _gaps(sections, chosen, first, last)
    if _glare_near(silhouette.glare, curve, sections.width, first, last):
        flag, notes = "glare", ("a saturated spot lies on the tube or at its tip: it may hide part of it", *notes)
    if clamp is None:
        x, y, _ = curve.at(np.array([first]))
        notes = (
            f"the clamp is taken at the left end, {x[0]:.0f},{y[0]:.0f}; give its pixel where it is elsewhere",
            *notes,
        )
    arc = fit_arc(sections.x[chosen], sections.y[chosen])
    mirrored = bool(np.cos(curve.at(np.array([first]))[2][0]) < -0.1)  # an upright clamp is no mirror image
    return Trace(source, mm_per_px, curve, sections, arc, first, last, mirrored=mirrored, flag=flag, notes=notes)


def _leftmost_first(way: Floats) -> Floats:
    return way[::-1] if way[0, 0] > way[-1, 0] else way


def _refined(contrast: Image, way: Floats, radius: float, *, rounds: int) -> tuple[SplineCurve, Sections]:
    """Return the centreline from a rough way along the tube: sections across it, a spline through them, and again."""
    from coast_cli.recordings.trace_centreline import cross_sections
    from coast_cli.recordings.trace_spline import fit_curve

    steps = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    curve = fit_curve(steps, way[:, 0], way[:, 1], 0.0, float(steps[-1]), grain=2 * radius)
    extend = 4 * radius
    for _ in range(rounds):
        sections = cross_sections(contrast, curve, radius, extend=extend)
        radius, extend = sections.width / 2, 2 * radius
        full = sections.full
        if sections.at_border.mean() > 0.3:
            raise _cut_off("the tube runs along the border of the image, partly outside")
        if full.sum() < 24:
            raise _no_edges()
        first, last = _ends(sections)
        curve = fit_curve(sections.s[full], sections.x[full], sections.y[full], first, last)
    return curve, cross_sections(contrast, curve, radius, extend=extend)


def _ends(sections: Sections) -> tuple[float, float]:
    """Arc lengths where the tube begins and ends: where it is seen, no wider than it is, and inside the image."""
    with np.errstate(invalid="ignore"):
        there = (sections.inside > 0.4) & (sections.left - sections.right < 1.25 * sections.width)
    index = np.flatnonzero(there)
    if index.size == 0:
        raise _no_edges()
    return float(sections.s[index[0]]), float(sections.s[index[-1]])


def _no_edges() -> BadFrame:
    message = "too few sections of the tube have both edges"
    return BadFrame("no-tube", message, hint="Light the ground evenly and shade the glare.")


def _borders(sections: Sections, first: float, last: float) -> tuple[bool, bool]:
    """Whether the tube begins and ends at the border of the image."""
    out = sections.s[sections.at_border]
    reach = 0.75 * sections.width
    return bool((out < first + reach).any()), bool((out > last - reach).any())


def _refuse_cut_off_side(sections: Sections) -> None:
    first, last = _ends(sections)
    margin = 2 * sections.width
    between = (sections.s > first + margin) & (sections.s < last - margin)
    if sections.at_border[between].any():
        raise _cut_off("the tube leaves the image between its ends")


def _cut_off(message: str, *, at: tuple[Floats, ...] | None = None) -> BadFrame:
    hint = "Show the whole bending segment."
    if at is not None:
        hint += f" If it is clamped there, say that the clamp is at {at[0][0]:.0f},{at[1][0]:.0f}."
    return BadFrame("cut-off", message, hint=hint)


def _glare_near(glare: NDArray[np.bool_], curve: SplineCurve, width: float, first: float, last: float) -> bool:
    """Whether saturated pixels touch the tube over a quarter of its width or more, or lie right before its tip."""
    x, y, angle = curve.at(np.arange(first, last + width, max(width / 16, 1.0)))
    across = np.linspace(-0.7, 0.7, 15)[:, None] * width
    column = np.clip(np.round(x - across * np.sin(angle)).astype(int), 0, glare.shape[1] - 1)
    row = np.clip(np.round(y - across * np.cos(angle)).astype(int), 0, glare.shape[0] - 1)
    return int((glare[row, column].mean(axis=0) > 0.1).sum()) * max(width / 16, 1.0) > 0.25 * width


def _nearest(curve: SplineCurve, clamp: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """Arc length of the point nearest to the clamp, and how far off it is."""
    s = np.linspace(low, high, 4001)
    x, y, _ = curve.at(s)
    off = np.hypot(x - clamp[0], y - clamp[1])
    nearest = int(np.argmin(off))
    return float(s[nearest]), float(off[nearest])


def _tip_comes_first(curve: SplineCurve, sections: Sections, clamp: tuple[float, float] | None) -> bool:
    first, last = _ends(sections)
    if clamp is None:
        return False
    borders = _borders(sections, first, last)
    if borders[0] != borders[1]:
        return borders[1]
    return _nearest(curve, clamp, first, last)[0] > (first + last) / 2


def _clamped(
    curve: SplineCurve, sections: Sections, ends: tuple[float, float], clamp: tuple[float, float] | None
) -> tuple[float, float]:
    """Return the part of the curve from the clamp to the tip."""
    first, last = ends
    if clamp is None:
        return first, last
    at, off = _nearest(curve, clamp, first, last)
    if off > 1.5 * sections.width:
        x, y, _ = curve.at(np.array([first]))
        message = f"the clamp at {clamp[0]:g},{clamp[1]:g} is {off:.0f} pixels from the tube"
        raise BadFrame("off-clamp", message, hint=f"The tube begins near {x[0]:.0f},{y[0]:.0f}.")
    if last - at < 4 * sections.width:
        raise BadFrame("off-clamp", f"only {last - at:.0f} pixels of tube lie beyond the clamp")
    return at, last


def _gaps(sections: Sections, chosen: NDArray[np.bool_], first: float, last: float) -> tuple[str, tuple[str, ...]]:
    """Flag a stretch without a full section that is longer than notches can make it."""
    s = np.concatenate([[first], sections.s[chosen], [last]])
    gap = np.diff(s)
    if chosen.sum() < 24 or gap.max() > 0.4 * (last - first):
        message = "most of the tube's edges cannot be made out"
        raise BadFrame("broken", message, hint="Shade the glare and light the ground evenly.")
    notches = gap[gap > 1.5 * np.median(gap)]
    usual = float(np.median(notches)) if notches.size > 2 else 0.0
    widest = int(np.argmax(gap))
    if gap[widest] <= max(3 * usual, 2.5 * sections.width):
        return "", ()
    at = (s[widest] + s[widest + 1]) / 2
    x, y = np.interp(at, sections.s, sections.x), np.interp(at, sections.s, sections.y)
    return "gap", (f"no whole section over {gap[widest]:.0f} pixels near {x:.0f},{y:.0f}: glare or dirt; bridged",)
