"""The plane of a path of points in space: the robot bends in one plane only, which its stage turns to by its roll."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

FLAT = 1e-4  # m; how far a point may lie out of the plane, a tenth of what the model knows of the tip
_STEEPEST = 1.0 - 1e-9  # of the start along z, where left has no meaning


def in_plane(points: Floats) -> tuple[Floats, float, Floats]:
    """Return points in the plane through the start's tangent that is nearest to them, its roll, and how far off they are.

    Args:
        points: (n, 3), m, four or more, no two neighbours alike.

    Returns:
        (n, 2) m, along the start's tangent and across; the roll of the plane (rad, -90 to 90 degrees) from the direction
        to the left of the start, level in x and y; and the distance of each point from the plane, (n,) m.
    """
    from scipy.interpolate import CubicSpline

    knots = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    ahead = CubicSpline(knots, points)(0.0, 1)
    ahead = ahead / np.linalg.norm(ahead)
    upright = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < _STEEPEST else np.array([0.0, 1.0, 0.0])
    left = np.cross(upright, ahead)
    left = left / np.linalg.norm(left)
    across = (points - points[0]) @ np.column_stack((left, np.cross(ahead, left)))
    values, directions = np.linalg.eigh(across.T @ across)
    side = directions[:, 1] if values[1] > 0.0 else np.array([1.0, 0.0])
    if side[0] < 0.0 or (side[0] == 0.0 and side[1] < 0.0):
        side = -side
    beside = across @ np.array([-side[1], side[0]])
    plane = np.column_stack(((points - points[0]) @ ahead, across @ side))
    return plane, float(np.arctan2(side[1], side[0])), np.abs(beside)
