"""Distances to the edge of a mask, strip by strip, so that a large photograph takes a quarter of the memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

STRIP = 1_000_000  # pixels, each of forty bytes while it is measured
_MARGIN = 64  # rows beside a strip; wider where the distances are longer


def edge_distance(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the distance of each True pixel to the nearest False one, pixels, 0 on those; exactly as of the whole mask.

    Args:
        mask: shape (rows, columns).
    """
    rows, columns = mask.shape
    distance = np.empty(mask.shape)
    tall = max(STRIP // max(columns, 1), 1)
    for first in range(0, rows, tall):
        last, margin = min(first + tall, rows), _MARGIN
        while not _fill(distance, mask, (first, last), margin):
            margin *= 4
    return distance


def _fill(distance: NDArray[np.float64], mask: NDArray[np.bool_], strip: tuple[int, int], margin: int) -> bool:
    """Fill rows of the distance, and return whether the margin beside them was wide enough for that."""
    from scipy.ndimage import distance_transform_edt

    first, last = strip
    top, bottom = max(first - margin, 0), min(last + margin, len(mask))
    seen = mask[top:bottom]
    whole = seen.shape == mask.shape
    if not whole and seen.all():
        return False
    distance[first:last] = distance_transform_edt(seen)[first - top : last - top]
    return whole or bool(distance[first:last].max() <= margin)
