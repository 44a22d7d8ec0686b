"""Draw photographs of notched tubes whose centreline is known: the ground truth of the tracing tests.

It shares nothing with the tracer: a shape is integrated from its curvature, the silhouette is sampled in (arc length,
normal) coordinates and its area is summed into pixels, which is exact anti-aliasing up to the sampling.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import gaussian_filter, zoom


@dataclass(frozen=True)
class Tube:
    """A tube to draw, all lengths in pixels; curvature in 1/pixel, positive towards the top of the image."""

    width: float
    length: float
    curvature: float | np.ndarray
    start: tuple[float, float]
    angle: float = 0.0  # of the clamp tangent, positive towards the top
    pitch: float = 1.2  # lengths of a notch pattern in tube widths, as in 0.6 mm on 0.5 mm
    cut: float = 0.6
    depth: float = 0.7
    notch_side: int = 1  # +1: cut from the left of the direction of travel, -1: from the right, 0: both (a pair)

    def axis(self, step=0.05):
        s = np.arange(0.0, self.length, step) + step / 2
        along = np.atleast_1d(np.asarray(self.curvature, float))
        curvature = np.interp(s, np.linspace(0, self.length, along.size), along)
        angle = self.angle + np.cumsum(curvature) * step - curvature * step / 2
        x = self.start[0] + np.cumsum(np.cos(angle)) * step - np.cos(angle) * step / 2
        y = self.start[1] - np.cumsum(np.sin(angle)) * step + np.sin(angle) * step / 2
        return s, x, y, angle, curvature


@dataclass(frozen=True)
class Scene:
    """A photograph: its tubes, light and faults. Grey levels run from 0 to 255."""

    shape: tuple[int, int]
    tubes: tuple[Tube, ...]
    light: float = 220.0
    tube_level: float = 0.12  # of the light behind a backlit tube
    gradient: tuple[float, float] = (0.0, 0.0)  # change of light across the image, as a share, in x and y
    blur: float = 0.8
    noise: float = 2.0
    bright: bool = False  # a lit tube before a dark ground
    streak: float = 0.0  # a specular line along the tube, as a share of the light
    glare: tuple[float, float, float] | None = None  # x, y, radius of a saturated spot
    blocks: tuple[tuple[float, float, float, float], ...] = field(default=())  # left, top, right, bottom: fixtures
    seed: int = 0

    def image(self):
        rng = np.random.default_rng(self.seed)
        rows, columns = self.shape
        cover = np.zeros(self.shape)
        shine = np.zeros(self.shape)
        for tube in self.tubes:
            tube_cover, tube_shine = _splat(tube, self.shape)
            cover = np.maximum(cover, tube_cover)
            shine = np.maximum(shine, tube_shine)
        yy, xx = np.mgrid[0:rows, 0:columns]
        for left, top, right, bottom in self.blocks:
            cover[(xx >= left) & (xx <= right) & (yy >= top) & (yy <= bottom)] = 1.0
        light = 1 + self.gradient[0] * (xx / columns - 0.5) + self.gradient[1] * (yy / rows - 0.5)
        light *= self.light
        level = self.tube_level + self.streak * shine
        picture = light * ((1 - cover) * self.tube_level + cover if self.bright else 1 - cover * (1 - level))
        if self.glare is not None:
            x, y, radius = self.glare
            picture += 400 * np.exp(-((((xx - x) ** 2 + (yy - y) ** 2) / radius**2) ** 2))
        picture = gaussian_filter(np.clip(picture, 0, 400), self.blur, mode="nearest")
        picture += rng.normal(0, self.noise, self.shape)
        return np.clip(np.round(picture), 0, 255).astype(np.uint8)


def texture(shape, seed, *, size=40, amplitude=6.0):
    """Return a smooth random texture, for photograph-like backgrounds."""
    rng = np.random.default_rng(seed)
    coarse = rng.normal(0, amplitude, (shape[0] // size + 2, shape[1] // size + 2))
    return zoom(coarse, size, order=3)[: shape[0], : shape[1]]


def _splat(tube, shape, step=0.1):
    s, x, y, angle, curvature = tube.axis(step)
    count = max(round(tube.width / step), 8)
    n = (np.arange(count) + 0.5) / count * tube.width - tube.width / 2  # to the left of the travel
    ring = np.mod(s, tube.pitch * tube.width) < (tube.pitch - tube.cut) * tube.width
    limit = tube.width / 2 - tube.depth * tube.width
    cover = np.zeros(shape)
    shine = np.zeros(shape)
    for offset in n:
        left = offset > limit and tube.notch_side >= 0
        right = -offset > limit and tube.notch_side <= 0
        if tube.notch_side == 0:  # the inner tube fills the middle of each cut
            left, right = offset > 0.35 * tube.width, -offset > 0.35 * tube.width
            other = np.mod(s + 0.37 * tube.pitch * tube.width, tube.pitch * tube.width)
            keep = (ring | (not left)) & ((other < (tube.pitch - tube.cut) * tube.width) | (not right))
        else:
            keep = ring | (not (left or right))
        px = x[keep] - offset * np.sin(angle[keep])
        py = y[keep] - offset * np.cos(angle[keep])
        area = (1 - curvature[keep] * offset) * step * (tube.width / count)
        for target, weight in ((cover, area), (shine, area * np.exp(-((offset / (0.12 * tube.width)) ** 2)))):
            _deposit(target, px, py, weight)
    return np.clip(cover, 0, 1), np.clip(shine, 0, 1)


def _deposit(target, x, y, weight):
    rows, columns = target.shape
    i, j = np.floor(y + 0.5).astype(int), np.floor(x + 0.5).astype(int)
    inside = (i >= 0) & (i < rows) & (j >= 0) & (j < columns)
    flat = i[inside] * columns + j[inside]
    if flat.size:
        low, high = flat.min(), flat.max() + 1
        target.ravel()[low:high] += np.bincount(flat - low, weight[inside], high - low)
