"""From a photograph to the silhouette of its one tube: an adaptive threshold and the connected component.

The light is fitted with a smooth surface that does not see the tube, the difference is cut at a share of its local
contrast, and the pieces are joined over gaps the width of a notch. What is left must be one long thin object.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.recordings.trace_distance import edge_distance
from coast_cli.recordings.trace_image import BadFrame

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Image = NDArray[np.float32]
    Mask = NDArray[np.bool_]

SLENDER = 4.0  # least length of a tube, in widths
WORKING_RADIUS = 6.0  # half width of the tube in the shrunk mask, in its pixels
SHARE = 0.35  # threshold of the mask, as a share of the local contrast
NOISE_FACTOR = 5.0  # what stands out from the ground, in its standard deviations


@dataclass(frozen=True)
class Silhouette:
    """The tube as a shrunk mask with its notches filled.

    Attributes:
        mask: True on the tube, shape (rows, columns) of the shrunk crop.
        left, top: pixel of the photograph at the corner of the crop.
        shrink: pixels of the photograph to one of the mask.
        contrast: the photograph after the light was taken out: about 0 on the ground, positive on the tube.
        glare: True where the photograph is saturated and the light around it is not; of a dark tube only.
    """

    mask: Mask
    left: int
    top: int
    shrink: int
    contrast: Image
    glare: Mask

    def to_image(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return pixel coordinates of the photograph for those of the mask."""
        half = (self.shrink - 1) / 2
        return x * self.shrink + half + self.left, y * self.shrink + half + self.top


def find_silhouette(levels: Image) -> Silhouette:
    """Return the silhouette of the one tube in a photograph, dark on a light ground or light on a dark one.

    Args:
        levels: grey levels, shape (rows, columns).

    Raises:
        BadFrame: no tube (``no-tube``), or several or one in pieces (``two-tubes``).
    """
    if float(np.ptp(levels)) == 0.0:
        raise _no_tube()
    difference, glare = flatten_light(levels)
    found: list[tuple[float, Silhouette]] = []
    errors: list[BadFrame] = []
    for mask, sign, weight in _polarities(difference):
        try:
            found.append((weight, _one_tube(mask, np.float32(sign) * difference, glare & (sign < 0))))
        except BadFrame as error:
            errors.append(error.with_traceback(None))  # which would keep the photograph in memory
    if found:
        return max(found, key=lambda pair: pair[0])[1]
    raise errors.pop(0) if errors else _no_tube()


def _no_tube() -> BadFrame:
    return BadFrame(
        "no-tube",
        "no tube is seen: nothing long and thin stands out from the ground",
        hint="Light the ground evenly, or crop to the tube.",
    )


def flatten_light(levels: Image, *, order: int = 3, cells: int = 96) -> tuple[Image, Mask]:
    """Return the grey levels less a smooth surface fitted to the ground, as shares of the light where that is lit.

    And a mask of glare: saturated where the surface is not.

    The surface is a polynomial of total degree ``order`` fitted to block medians by iterated reweighting (Tukey's
    biweight), so that a tube on less than about a third of the blocks does not lift it.
    """
    from scipy.ndimage import uniform_filter

    rows, columns = levels.shape
    block = max(max(rows, columns) // cells, 1)
    tall, wide = rows // block, columns // block
    blocks = levels[: tall * block, : wide * block].reshape(tall, block, wide, block)
    coarse = np.median(blocks[:, :: max(block // 5, 1), :, :: max(block // 5, 1)], axis=(1, 3)).astype(float)
    y = (np.arange(tall) + 0.5) * block / rows * 2 - 1
    x = (np.arange(wide) + 0.5) * block / columns * 2 - 1
    powers = [(i, j) for i in range(order + 1) for j in range(order + 1 - i)]
    basis = np.stack([np.outer(y**i, x**j).ravel() for i, j in powers], axis=1)
    target = coarse.ravel()
    top = float(levels.max())
    weight = np.ones_like(target)
    coefficients = np.zeros(len(powers))
    for _ in range(15):
        weighted = basis * weight[:, None]
        coefficients = np.linalg.lstsq(weighted.T @ basis, weighted.T @ target, rcond=None)[0]
        residual = target - basis @ coefficients
        spread = max(1.4826 * float(np.median(np.abs(residual))), 1e-3 * float(np.ptp(target)), 1e-6)
        weight = np.clip(1 - (residual / (4.685 * spread)) ** 2, 0, 1) ** 2
        weight[(target >= top) & (residual < -1e-3 * top)] = 0.0  # saturated: the light is brighter than can be seen
    full_y = ((np.arange(rows) + 0.5) / rows * 2 - 1).astype(np.float32)
    full_x = ((np.arange(columns) + 0.5) / columns * 2 - 1).astype(np.float32)
    matrix = np.zeros((order + 1, order + 1), dtype=np.float32)
    for (i, j), value in zip(powers, coefficients, strict=True):
        matrix[i, j] = value
    y_powers, x_powers = (np.vander(full, order + 1, increasing=True).astype(np.float32) for full in (full_y, full_x))
    ground: Image = np.asarray(y_powers @ matrix @ x_powers.T, dtype=np.float32)
    np.minimum(ground, np.float32(top), out=ground)
    flat: Image = levels - ground
    glare: Mask = (uniform_filter(levels, 5) >= 0.985 * top) & (ground < 0.94 * top)
    middle = float(np.median(ground[:: max(rows // 200, 1), :: max(columns // 200, 1)]))
    if middle > 0.35 * top:  # a lit ground: a silhouette is a share of its light
        flat /= np.maximum(ground, 0.2 * middle)
    return flat, glare


def _polarities(difference: Image) -> Iterator[tuple[Mask, float, float]]:
    """Give where the difference over its local contrast stands out, its sign and how much; the stronger first."""
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(difference, 1.0)
    sample = smooth[:: max(smooth.shape[0] // 500, 1), :: max(smooth.shape[1] // 500, 1)]
    most = max(float(smooth.max()), -float(smooth.min()))
    noise = max(1.4826 * float(np.median(np.abs(sample - np.median(sample)))), 1e-7 * most)
    floor = np.float32(NOISE_FACTOR * noise)
    found = []
    for sign in (-1.0, 1.0):
        seen = np.abs(smooth[smooth * np.float32(sign) > NOISE_FACTOR * noise])
        if seen.size >= 64:
            found.append((float(seen.sum()), sign, float(np.percentile(seen, 75))))
        del seen  # it may be most of the photograph
    for weight, sign, typical in sorted(found, key=lambda one: -one[0]):
        yield _standing_out(np.float32(sign) * smooth, typical, floor), sign, weight


def _standing_out(contrast: Image, typical: float, floor: np.float32) -> Mask:
    local = _local_contrast(contrast, typical)
    return np.asarray(contrast / np.maximum(local, floor / np.float32(SHARE)) > SHARE)


def _local_contrast(contrast: Image, typical: float, *, cells: int = 64) -> Image:
    """Return the strongest contrast near each pixel, between half and twice the typical one."""
    from scipy.ndimage import gaussian_filter, maximum_filter, zoom

    rows, columns = contrast.shape
    block = max(max(rows, columns) // cells, 1)
    tall, wide = -(-rows // block), -(-columns // block)
    padded = np.full((tall * block, wide * block), -np.inf, dtype=np.float32)
    padded[:rows, :columns] = contrast
    peaks = padded.reshape(tall, block, wide, block).max(axis=(1, 3))
    near = maximum_filter(peaks, size=7)
    near = gaussian_filter(np.clip(near, 0.5 * typical, 1.5 * typical), 2.0)
    full = zoom(near, block, order=1, mode="nearest", grid_mode=True)
    return np.asarray(full[:rows, :columns], dtype=np.float32)


def _one_tube(mask: Mask, contrast: Image, glare: Mask) -> Silhouette:
    rows = np.flatnonzero(mask.any(axis=1))
    columns = np.flatnonzero(mask.any(axis=0))
    if rows.size < 3 or columns.size < 3 or mask.mean() > 0.6:
        raise _no_tube()
    left, top = int(columns[0]), int(rows[0])
    crop = mask[top : rows[-1] + 1, left : columns[-1] + 1]
    shrink, radius = _shrink_factor(crop)
    crop, radius = _shrunk(crop, shrink), radius / shrink
    # Twice, because the first radius is that of the rings between open notches.
    closed = _closed(crop, 2.2 * radius)
    closed = _closed(crop, max(1.2 * _ridge_radius(closed), radius))
    return Silhouette(_slender_component(closed, shrink), left, top, shrink, contrast, glare)


def _shrink_factor(mask: Mask) -> tuple[int, float]:
    """Return how far the mask may shrink until the tube is about twelve pixels across, and its radius now."""
    coarse = max(int(np.sqrt(mask.size / 1_000_000)), 1)
    radius = coarse * _ridge_radius(_shrunk(mask, coarse)) if coarse > 1 else 0.0
    if radius < 4 * coarse:
        radius = _ridge_radius(mask)
    return max(int(radius / (0.7 * WORKING_RADIUS)), 1), radius


def _ridge(mask: Mask) -> Floats:
    """Return the distance to the edge along the skeleton of a mask, without what is thinner than two pixels."""
    from skimage.morphology import skeletonize

    padded = np.pad(mask, 1)
    ridge: Floats = edge_distance(padded)[skeletonize(padded)]
    thick = ridge[ridge > 1.0]
    return thick if thick.size > 20 else np.maximum(ridge, 1.0)


def _ridge_radius(mask: Mask) -> float:
    """Return half the width of what most of the mask's length belongs to: a high percentile along its medial ridge."""
    ridge = _ridge(mask)
    return float(np.percentile(ridge, 75)) if ridge.size else 1.0


def _shrunk(mask: Mask, factor: int) -> Mask:
    if factor == 1:
        return mask
    tall, wide = -(-mask.shape[0] // factor), -(-mask.shape[1] // factor)
    padded = np.zeros((tall * factor, wide * factor), dtype=np.float32)
    padded[: mask.shape[0], : mask.shape[1]] = mask
    return np.asarray(padded.reshape(tall, factor, wide, factor).mean(axis=(1, 3)) >= 0.5)


def _closed(mask: Mask, radius: float) -> Mask:
    """Morphological closing by a disc (two distance transforms), and holes no larger than a few discs filled."""
    from scipy.ndimage import binary_fill_holes, label

    margin = int(radius) + 2
    padded = np.pad(mask, margin)
    grown = edge_distance(~padded) <= radius
    closed = edge_distance(grown) > radius
    holes, count = label(binary_fill_holes(closed) & ~closed)
    if count:
        small = np.bincount(holes.ravel()) < 30 * radius**2
        small[0] = False
        closed |= small[holes]
    return np.asarray(closed[margin:-margin, margin:-margin] | mask)


def _slender_component(mask: Mask, shrink: int) -> Mask:
    """Return the one long thin component of a mask with filled notches."""
    from scipy.ndimage import find_objects, label

    labels, count = label(mask, structure=np.ones((3, 3)))
    area = np.bincount(labels.ravel(), minlength=count + 1)
    area[0] = 0
    boxes = find_objects(labels)
    tubes: list[tuple[float, float, int]] = []  # length, width, label
    for index in np.argsort(area)[::-1][:8]:
        if area[index] < 12:
            break
        ridge = _ridge(labels[boxes[index - 1]] == index)
        width = 2 * float(np.median(ridge))
        length = area[index] / width
        uneven = float(np.median(np.abs(2 * ridge - width))) / width
        if length > SLENDER * width and uneven < 0.25:
            tubes.append((length, width, int(index)))
    if not tubes:
        raise _no_tube()
    tubes.sort(reverse=True)
    length, width, main = tubes[0]
    rivals = [tube for tube in tubes[1:] if tube[0] > max(0.25 * length, 5 * width) and tube[1] > 0.5 * width]
    if rivals:
        gap = float(edge_distance(labels != main)[labels == rivals[0][2]].min()) * shrink
        message = f"two long thin objects are seen, {gap:.0f} pixels apart where they are nearest"
        raise BadFrame("two-tubes", message, hint="Crop to one tube; if it is one, shade the glare that breaks it.")
    return np.asarray(labels == main)
