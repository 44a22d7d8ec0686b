"""From a silhouette to points on the axis of the tube: the medial ridge first, then edges to a fraction of a pixel.

The skeleton of the mask gives the way along the tube. Profiles of grey level across it give both edges where the level
is half way between tube and ground. Only sections of full width tell where the axis is: at a notch one edge is missing,
and the middle of what is left is not on the axis. Those sections are found and left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.trace_distance import edge_distance
from coast_cli.recordings.trace_image import BadFrame

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from coast_cli.recordings.trace_spline import SplineCurve
    from coast_cli.recordings.trace_threshold import Silhouette

    Floats = NDArray[np.float64]
    Image = NDArray[np.float32]
    Mask = NDArray[np.bool_]

FLOOR = 0.02  # pixels: what a noiseless drawing is traced to


@dataclass(frozen=True)
class PixelPath:
    """The way along a tube, pixels of the photograph: points, arc length and about half the width of the tube."""

    x: Floats
    y: Floats
    radius: float


@dataclass(frozen=True)
class Sections:
    """Cross-sections of the tube at stations along a curve, pixels.

    Attributes:
        s: arc length of each station on the curve, shape (n,).
        x, y: the middle between the two edges, shape (n,).
        left, right: normal offsets of the edges from the curve; left is positive to the left of the way, on the image.
        inside: share of the tube's contrast that each section reaches; 0 off the photograph and in a fixture.
        full: True where the section has the full width.
        width: the full width.
        bias: how far the middles may lie off the axis all together: half the scatter of the full widths that is not
            noise, which is what the rounded corners of short rings leave.
        at_border: True where a section is cut by the border of the photograph.
    """

    s: Floats
    x: Floats
    y: Floats
    left: Floats
    right: Floats
    inside: Floats
    full: Mask
    width: float
    bias: float
    at_border: Mask


def medial_path(silhouette: Silhouette) -> PixelPath:
    """Return the longest way along the skeleton of a silhouette, without its last half width at either end.

    Raises:
        BadFrame: a second object crosses or touches the tube (``two-tubes``), or the object is not slender.
    """
    from scipy.ndimage import label
    from skimage.morphology import skeletonize

    mask = np.pad(silhouette.mask, 1)
    distance = edge_distance(mask)
    radius = float(np.median(distance[skeletonize(mask)]))
    thin = 0.4 * radius  # hairs and tendons; they go by a morphological opening
    mask = edge_distance(distance <= thin) <= thin
    distance = edge_distance(mask)
    ridge = skeletonize(mask) & (distance < 2.5 * radius)  # a fixture that holds the tube is thicker
    pieces, _ = label(ridge, structure=np.ones((3, 3)))
    lengths = np.bincount(pieces[ridge], minlength=2)
    if np.sort(lengths)[-2] > 8 * radius:
        raise _crossed()
    rows, columns = np.nonzero(pieces == np.argmax(lengths))
    way = _longest_way(rows, columns)
    _refuse_branches(rows, columns, way, radius)
    trim = max(int(radius), 1)
    way = way[trim:-trim]
    if way.size < 8:
        raise BadFrame("no-tube", "no tube is seen: what stands out from the ground is not long and thin")
    x, y = silhouette.to_image(columns[way].astype(np.float64) - 1, rows[way].astype(np.float64) - 1)
    return PixelPath(x, y, radius * silhouette.shrink)


def _longest_way(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return indices of the skeleton pixels on the longest shortest way, by two sweeps of Dijkstra's algorithm."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    points = np.stack([rows, columns], axis=1).astype(float)
    if len(points) < 8:
        raise BadFrame("no-tube", "no tube is seen: what stands out from the ground is not long and thin")
    pairs = cKDTree(points).query_pairs(1.5, output_type="ndarray").astype(np.int32)  # as scipy 1.11 wants indices
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    graph = coo_array((lengths, (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points))).tocsr()
    first = dijkstra(graph, directed=False, indices=[0])[0]
    end = int(np.argmax(np.where(np.isfinite(first), first, -1.0)))
    distances, predecessors = dijkstra(graph, directed=False, indices=[end], return_predecessors=True)
    second, before = distances[0], predecessors[0]
    here = int(np.argmax(np.where(np.isfinite(second), second, -1.0)))
    way = []
    while here >= 0:
        way.append(here)
        here = int(before[here])
    return np.asarray(way, dtype=np.intp)


def _refuse_branches(rows: NDArray[np.intp], columns: NDArray[np.intp], way: NDArray[np.intp], radius: float) -> None:
    from scipy.spatial import cKDTree

    points = np.stack([rows, columns], axis=1).astype(float)
    off = np.asarray(cKDTree(points[way]).query(points)[0])
    if float(off.max()) > max(6 * radius, 0.2 * len(way)):
        raise _crossed()


def _crossed() -> BadFrame:
    message = "something as wide as the tube crosses or touches it"
    return BadFrame("two-tubes", message, hint="Crop to one tube, or clear the ground.")


def cross_sections(contrast: Image, curve: SplineCurve, radius: float, *, extend: float = 0.0) -> Sections:
    """Return edges and middles of the tube at stations along a curve, one pixel or a sixteenth of a width apart.

    Args:
        contrast: the photograph less its light, positive on the tube, shape (rows, columns).
        curve: the way along the tube, pixels.
        radius: about half the width of the tube, pixels.
        extend: how far past both ends of the curve to look.
    """
    from scipy.ndimage import map_coordinates, uniform_filter1d

    step = max(1.0, radius / 8)
    s = np.arange(-extend, curve.length + extend, step)
    x, y, angle = curve.at(s)
    reach = 1.8 * radius + 4
    fine = min(0.5, radius / 16)
    offset = np.arange(-reach, reach + fine / 2, fine)
    # On the image rows count down, so the left of the way (dx, dy) is (dy, -dx).
    px = x[:, None] - offset * np.sin(angle)[:, None]
    py = y[:, None] - offset * np.cos(angle)[:, None]
    grey = map_coordinates(contrast, [py, px], order=1, mode="nearest").astype(float)
    span = max(round(8 * radius / step), 3)
    outer = offset.size // 8
    beside = np.stack([np.median(grey[:, :outer], axis=1), np.median(grey[:, -outer:], axis=1)])
    dark = 0.5 * float(np.median(grey.max(axis=1)))
    blocked = (beside > dark).any(axis=0)  # no ground beside the tube: a fixture
    right_ground, left_ground = uniform_filter1d(np.where(beside > dark, 0.0, beside), span, axis=1, mode="nearest")
    blend = (offset + reach) / (2 * reach)
    grey -= right_ground[:, None] * (1 - blend) + left_ground[:, None] * blend
    level = _tube_level(uniform_filter1d(grey, max(round(0.5 * radius / fine), 1), axis=1), span)
    grey /= level[:, None]
    left, right = _outermost_crossing(grey, offset), -_outermost_crossing(grey[:, ::-1], -offset[::-1])
    width, full = _full_width(left - right, 2.6 * radius)
    rows, columns = contrast.shape
    out = (px < -0.5) | (px > columns - 0.5) | (py < -0.5) | (py > rows - 0.5)
    near = np.abs(offset) <= 0.5 * width + 1
    at_border = out[:, near].any(axis=1)
    middle = (left + right) / 2
    cores = _cores(full & ~at_border & ~blocked, round(0.25 * width / step))
    return Sections(
        s=s,
        x=x - middle * np.sin(angle),
        y=y - middle * np.cos(angle),
        left=left,
        right=right,
        inside=np.where(blocked | out[:, offset.size // 2], 0.0, np.max(grey[:, near], axis=1)),
        full=cores,
        width=width,
        bias=_bias(left - right, cores),
        at_border=at_border,
    )


def _tube_level(grey: Floats, span: int) -> Floats:
    """Return the level of the tube along the way: what the rings reach, smoothed over several of them."""
    from scipy.ndimage import percentile_filter, uniform_filter1d

    peak = np.max(grey, axis=1)
    level = percentile_filter(peak, 80, size=min(2 * span, peak.size), mode="nearest")
    level = uniform_filter1d(level, span, mode="nearest")
    return np.maximum(level, 0.25 * float(np.median(level)) + 1e-12)


def _outermost_crossing(grey: Floats, offset: Floats, share: float = 0.5) -> Floats:
    """Return the largest offset at which a profile falls through half of the tube's level, NaN where there is none."""
    above = grey > share
    index = np.arange(grey.shape[0])
    last = np.clip(offset.size - 1 - np.argmax(above[:, ::-1], axis=1), 0, offset.size - 2)
    inner, outer = grey[index, last], grey[index, last + 1]
    fall = np.where(inner - outer > 1e-9, inner - outer, 1.0)
    part = np.clip((inner - share) / fall, 0, 1)
    return np.where(above.any(axis=1), offset[last] + part * (offset[last + 1] - offset[last]), np.nan)


def _full_width(width: Floats, most: float) -> tuple[float, Mask]:
    """Return the width of the sections that are not cut, and which they are; wider ones than ``most`` are not tube."""
    seen = width[np.isfinite(width) & (width < most)]
    if seen.size < 12:
        raise BadFrame("no-tube", "the edges of the tube cannot be made out", hint="Light the ground more.")
    full = float(np.percentile(seen, 95))
    near = np.zeros(width.shape, dtype=bool)
    for _ in range(6):
        with np.errstate(invalid="ignore"):
            near = np.abs(width - full) < max(0.08 * full, 0.6)
        if not near.any():
            break
        full = float(np.median(width[near]))
    return full, near


def _cores(full: Mask, most: int) -> Mask:
    """Return the middle half of every run of full sections: its ends lie at the rounded corners of a ring."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], full.astype(np.int8), [0]])))
    cores = np.zeros_like(full)
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        cut = min((stop - start - 1) // 4, most)
        cores[start + cut : stop - cut] = True
    return cores


def _bias(width: Floats, full: Mask) -> float:
    pairs = full[1:] & full[:-1]
    if pairs.sum() < 2:
        return FLOOR
    noise = float(np.mean((np.diff(width)[pairs]) ** 2)) / 2
    return float(np.hypot(np.sqrt(max(float(np.var(width[full])) - noise, 0.0)) / 2, FLOOR))
