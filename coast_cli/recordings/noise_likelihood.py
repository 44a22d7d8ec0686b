"""Level and colour of the noise on a smooth signal, by the likelihood of what no smooth signal can hold.

A record is cut into short blocks. In each one the response is a quadratic plus a thrice integrated Wiener process of
unknown amplitude (the signal: smooth, as rough as the block asks for) plus stationary noise, an AR(1) part and a white
part. The quadratic is projected out (restricted likelihood: Patterson and Thompson, Biometrika 58, 1971), the amplitude
is averaged over block by block, so that a kink costs one block and not the estimate; level and colour are shared and
get a posterior on a grid. The integrated Wiener process is Wahba's smoothing-spline prior (J. R. Stat. Soc. B 40,
1978).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Form = tuple[Floats, Floats, int]

MEMORY = (0.0, 0.15, 0.3, 0.45, 0.6, 0.7, 0.8, 0.87, 0.92, 0.95, 0.97, 0.985, 0.992, 0.996)
WHITE_SHARE = (0.0, 0.25, 0.5, 0.75)
COLOURS = tuple((memory, white) for memory in MEMORY for white in (WHITE_SHARE if memory else (0.0,)))
AMPLITUDES = np.concatenate(([0.0], 10.0 ** np.arange(-5.0, 2.25, 0.5)))
SMOOTHER_FIRST = np.exp(-0.1 * np.arange(len(AMPLITUDES)))
HINGED = np.array([0, 5, 7, 9])
HINGE_INFORMATION = 100.0
HINGES_ALIKE = 2.0
MOST_HINGES = 64
HINGE_SHARE = 0.3
WHITE_FIRST = 3.0
LOG_SIGNAL_PRIOR = np.log(
    np.concatenate(
        (
            (1.0 - HINGE_SHARE) * SMOOTHER_FIRST / SMOOTHER_FIRST.sum(),
            HINGE_SHARE * SMOOTHER_FIRST[HINGED] / SMOOTHER_FIRST[HINGED].sum(),
        )
    )
)
LOG_COLOUR_PRIOR = np.array(
    [np.log(WHITE_FIRST) if memory == 0.0 else -np.log(len(WHITE_SHARE)) for memory, _ in COLOURS]
)
UNEVENNESS = np.array([0.0, 0.35, 0.7, 1.2, 2.0])
UNEVENNESS_PRIOR = np.array([0.6, 0.1, 0.1, 0.1, 0.1])
LEVELS = 64
FOLLOWS_KINKS = 24  # samples of a block from which on its kinks are told from its noise
MEMORY_IN_SAMPLES = np.array([-1.0 / np.log(memory) if memory else 0.0 for memory, _ in COLOURS])


@dataclass(frozen=True, eq=False)
class NoiseBlock:
    """Neighbouring samples of one smooth stretch.

    Attributes:
        values: [m].
        coordinate: [m], where the samples stand along what the signal is smooth in, about 1 apart; None if evenly.
        degree: of the polynomial that the signal may hold at no cost: 2 in a move, 0 or 1 in a hold or a repeat.
    """

    values: Floats
    coordinate: Floats | None = None
    degree: int = 2


@dataclass(frozen=True)
class Posterior:
    """What the blocks say of the noise.

    Attributes:
        log_level, log_level_std: of the root mean square over all samples, natural logarithm.
        log_low, log_high: what holds it with a probability of 90 %.
        unevenness: standard deviation of the logarithm of the level from block to block.
        memory, memory_std: coefficient of the AR(1) part.
        lag_one: correlation between neighbouring samples.
    """

    log_level: float
    log_level_std: float
    log_low: float
    log_high: float
    unevenness: float
    memory: float
    memory_std: float
    lag_one: float

    def of_every_sample(self, step: int) -> Posterior:
        """Return what holds of all samples, where this is of every so-manieth."""
        slower = self.memory ** (1.0 / step) if self.memory > 0.0 else 0.0
        change = slower / (step * self.memory) if self.memory > 0.0 else 1.0
        white = 1.0 - self.lag_one / self.memory if self.memory > 0.0 else 1.0
        return replace(self, memory=slower, memory_std=self.memory_std * change, lag_one=slower * (1.0 - white))


@dataclass(frozen=True, eq=False)
class _Basis:
    """What the likelihood of a block needs, for each of its colours.

    Attributes:
        transform: map to independent coordinates, [colour, r, m].
        total: their variance for each amplitude of the signal, [colour, amplitude, r], noise counting as 1.
        half_log_determinant: [colour, amplitude].
        hinges: the same coordinates of a unit change of slope at each inner sample, [colour, r, place].
        hinge_information: squared length of each, [colour, hinge amplitude, place].
    """

    transform: Floats
    total: Floats
    half_log_determinant: Floats
    hinges: Floats
    hinge_information: Floats


def noise_posterior(
    blocks: Sequence[NoiseBlock], start: float, longest_memory: float = np.inf, quantum: float = 0.0
) -> Posterior:
    """Return the posterior of level and colour, shared by all blocks; ``start`` is a rough level, greater than 0.

    The level of a block scatters about the shared one by an unevenness that is averaged over too: a device that sticks
    and slips is noisier where it moves than where it rests, and the level is the root mean square over blocks. In short
    blocks kinks of the signal look like that, so there the level is the usual one, unless the response is rounded to
    steps (``quantum``) that hide the noise of quiet blocks; the interval reaches up to the root mean square. Memories longer
    than ``longest_memory`` samples are not considered: by them any signal could be noise.
    """
    groups = _grouped(blocks)
    forms = [_quadratic_forms(group, basis) for group, basis in groups]
    sizes = np.concatenate([np.full(len(group), len(group[0].values)) for group, _ in groups])
    coarse = _grid_posterior(forms, np.log(start) + np.linspace(-3.0, 4.5, LEVELS), longest_memory)
    reach = 4.5 * max(coarse.std, 0.03) + 3.0 * coarse.unevenness
    fine = _grid_posterior(forms, np.linspace(coarse.mean - reach, coarse.mean + reach, LEVELS), longest_memory)
    average = fine.mean if fine.unevenness < UNEVENNESS[1] else _root_mean_square(fine, sizes)
    follows = float(np.median(sizes)) >= FOLLOWS_KINKS or np.exp(fine.mean) < quantum
    level = average if follows else fine.mean
    memory, white = np.array(COLOURS).T
    mean_memory = float(fine.by_colour @ memory)
    return Posterior(
        log_level=level,
        log_level_std=fine.std,
        log_low=level + fine.low - fine.mean,
        log_high=max(level + fine.high - fine.mean, average),
        unevenness=fine.unevenness,
        memory=mean_memory,
        memory_std=float(np.sqrt(max(float(fine.by_colour @ memory**2) - mean_memory**2, 0.0))),
        lag_one=float(fine.by_colour @ (memory * (1.0 - white))),
    )


@dataclass(frozen=True, eq=False)
class _GridPosterior:
    """Likelihood of each block [block, colour, level] on a grid of log levels, and what all blocks say together."""

    by_block: Floats
    log_levels: Floats
    by_colour: Floats
    mean: float
    std: float
    low: float
    high: float
    unevenness: float


def _grid_posterior(forms: list[Form], log_levels: Floats, longest_memory: float) -> _GridPosterior:
    by_block = _block_likelihoods(forms, log_levels)
    weight = _weights(by_block, log_levels, longest_memory)
    by_level = weight.sum(axis=(0, 2))
    mean = float(by_level @ log_levels)
    std = float(np.sqrt(by_level @ (log_levels - mean) ** 2))
    unevenness = float(weight.sum(axis=(0, 1)) @ UNEVENNESS)
    low, high = np.interp((0.05, 0.95), np.cumsum(by_level) - 0.5 * by_level, log_levels)
    return _GridPosterior(by_block, log_levels, weight.sum(axis=(1, 2)), mean, std, float(low), float(high), unevenness)


def _grouped(blocks: Sequence[NoiseBlock]) -> list[tuple[list[NoiseBlock], _Basis]]:
    even: dict[tuple[int, int], list[NoiseBlock]] = {}
    groups: list[tuple[list[NoiseBlock], _Basis]] = []
    for block in blocks:
        if block.coordinate is None:
            even.setdefault((len(block.values), block.degree), []).append(block)
        else:
            groups.append(([block], _basis(block.coordinate, block.degree)))
    groups.extend((group, _even_basis(*shape)) for shape, group in even.items())
    return groups


@lru_cache(maxsize=128)
def _even_basis(size: int, degree: int) -> _Basis:
    return _basis(np.arange(size, dtype=np.float64), degree)


def _basis(coordinate: Floats, degree: int) -> _Basis:
    size = len(coordinate)
    start = coordinate - coordinate.min()
    polynomial = np.vander(start / start.max(), degree + 1)
    contrast = np.linalg.qr(polynomial, mode="complete")[0][:, degree + 1 :]
    spline = contrast.T @ _integrated_wiener(start) @ contrast
    lag = np.abs(np.subtract.outer(np.arange(size), np.arange(size)))
    noise = np.array([(1.0 - white) * memory**lag + white * np.eye(size) for memory, white in COLOURS])
    root = np.linalg.cholesky(contrast.T @ noise @ contrast)
    inverse = np.linalg.inv(root)
    variance, vectors = np.linalg.eigh(inverse @ spline @ inverse.transpose(0, 2, 1))
    transform = vectors.transpose(0, 2, 1) @ inverse @ contrast.T
    total = 1.0 + AMPLITUDES[:, None] ** 2 * np.maximum(variance, 0.0)[:, None, :]
    half = np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1)[:, None] + 0.5 * np.log(total).sum(axis=2)
    places = np.interp(np.arange(1.5, size - 2.0, max(0.5, size / MOST_HINGES)), np.arange(size), start)
    hinges = transform @ np.maximum(start[:, None] - places, 0.0)
    information = (1.0 / total[:, HINGED]) @ hinges**2
    return _Basis(transform, total, half, hinges, information)


def _integrated_wiener(at: Floats) -> Floats:
    """Return the covariance of the thrice integrated Wiener process that starts at rest at 0."""
    low, gap = np.minimum.outer(at, at), np.abs(np.subtract.outer(at, at))
    covariance: Floats = 0.25 * (low**5 / 5.0 + gap * low**4 / 2.0 + gap**2 * low**3 / 3.0)
    return covariance


def _quadratic_forms(group: list[NoiseBlock], basis: _Basis) -> Form:
    """Return (quadratic form [colour, signal, block], half log determinant [colour, signal], degrees of freedom).

    The signals are those of each amplitude, then those of some amplitudes with one change of slope besides, at the
    place that fits best, at the price of a size (unit information) and of a place among those that are unlike.
    """
    values = basis.transform @ np.column_stack([block.values for block in group])
    precision = 1.0 / basis.total
    quadratic = precision @ values**2
    weighted = precision[:, HINGED, :, None] * values[:, None]
    along = basis.hinges.transpose(0, 2, 1)[:, None] @ weighted
    gained = (along**2 / basis.hinge_information[..., None]).max(axis=2)
    hinged = np.maximum(quadratic[:, HINGED] - gained, 0.0)
    price = 0.5 * np.log1p(HINGE_INFORMATION) + np.log(max(basis.hinges.shape[2] / HINGES_ALIKE, 1.0))
    half = basis.half_log_determinant
    return (
        np.concatenate((quadratic, hinged), axis=1),
        np.concatenate((half, half[:, HINGED] + price), axis=1),
        basis.total.shape[2],
    )


def _block_likelihoods(forms: list[Form], log_levels: Floats) -> Floats:
    """Return the log likelihood of each block, averaged over its signals, [block, colour, level]."""
    precision = np.exp(-2.0 * log_levels)
    likelihoods = []
    for quadratic, half, degrees in forms:
        for column in np.moveaxis(quadratic, 2, 0):
            exponent = LOG_SIGNAL_PRIOR[:, None] - half[:, :, None] - 0.5 * column[:, :, None] * precision
            top = exponent.max(axis=1)
            likelihoods.append(top + np.log(np.exp(exponent - top[:, None]).sum(axis=1)) - degrees * log_levels)
    return np.array(likelihoods)


def _weights(by_block: Floats, log_levels: Floats, longest_memory: float) -> Floats:
    """Return the posterior weight of each colour, shared level and unevenness, [colour, level, unevenness]."""
    top = by_block.max(axis=2, keepdims=True)
    scaled = np.exp(by_block - top)
    away = np.subtract.outer(log_levels, log_levels)
    total = np.empty((*by_block.shape[1:], len(UNEVENNESS)))
    for index, spread in enumerate(UNEVENNESS):
        kernel = np.exp(-0.5 * (away / spread) ** 2) if spread > 0.0 else np.eye(len(log_levels))
        mixed = scaled @ (kernel / kernel.sum(axis=0))
        total[:, :, index] = (top + np.log(np.maximum(mixed, 1e-300))).sum(axis=0)
    total += LOG_COLOUR_PRIOR[:, None, None] + np.log(UNEVENNESS_PRIOR)
    total[longest_memory < MEMORY_IN_SAMPLES] = -np.inf
    weight = np.exp(total - total.max())
    normal: Floats = weight / weight.sum()
    return normal


def _root_mean_square(posterior: _GridPosterior, sizes: Floats) -> float:
    """Return the log of the root mean square level over all samples, each block drawn to the shared level."""
    log_levels = posterior.log_levels
    likelihood = posterior.by_block[:, int(np.argmax(posterior.by_colour))]
    drawn = likelihood - 0.5 * ((log_levels - posterior.mean) / posterior.unevenness) ** 2
    share = np.exp(drawn - drawn.max(axis=1, keepdims=True))
    square = np.exp(2.0 * (share @ log_levels) / share.sum(axis=1))
    return float(0.5 * np.log((sizes * square).sum() / sizes.sum()))
