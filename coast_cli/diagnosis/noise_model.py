"""How likely residuals are as noise whose level and colour are not known: AR(1) plus white, both fitted.

A hypothesis that leaves a smooth misfit behind must pay for it as coloured noise, and one that explains it earns only
what coloured noise could not have done by itself. Comparing hypotheses at one fixed white level instead calls physics on
most clean recordings. Colours form a grid; residual sequences are cut into chunks whose covariances are factorised once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.noise import NoiseEstimate

Integers = NDArray[np.int64]

# (memory of the AR(1) part, share of white noise in the variance)
NOISE_COLOURS: tuple[tuple[float, float], ...] = (
    (0.0, 1.0),
    *((memory, white) for memory in (0.3, 0.5, 0.7, 0.8, 0.87, 0.92, 0.96, 0.99) for white in (0.0, 0.3, 0.6, 0.85)),
)
# (length over which a smooth curve bends, in samples, white share): the null's rival in ``structure``
SMOOTH_COLOURS: tuple[tuple[float, float], ...] = tuple(
    (length, white) for length in (4.0, 8.0, 16.0, 32.0) for white in (0.9, 0.7, 0.4, 0.15, 0.05, 0.015, 0.003)
)
Kernel = Literal["rough", "smooth"]
_CHUNK = 96


@dataclass(frozen=True, slots=True)
class NoiseEvidence:
    """The best colour of a residual: log likelihood, level (standard deviation), and index into ``NOISE_COLOURS``."""

    log_likelihood: float
    level: float
    colour: int

    @property
    def memory(self) -> float:
        """Lag-one correlation of the noise."""
        memory, white = NOISE_COLOURS[self.colour]
        return memory * (1.0 - white)


class NoiseBank:
    """Covariance factors of every chunk of a set of residual sequences, for every colour.

    Args:
        sequences: for each sequence the row numbers of its samples (gaps are dropped frames), each (n_i,); residual
            vectors are these sequences one after the other.
        kernel: "rough" for AR(1) noise (``NOISE_COLOURS``), "smooth" for curves that noise does not draw (``SMOOTH_COLOURS``).
        slowest: largest memory that noise is believed to have.
    """

    def __init__(self, sequences: Sequence[Integers], kernel: Kernel = "rough", *, slowest: float = 1.0) -> None:
        self._kernel: Kernel = kernel
        self._believed = np.array([kernel == "smooth" or memory <= slowest for memory, _ in _colours(kernel)])
        groups: dict[bytes, list[Integers]] = {}
        start = 0
        for rows in sequences:
            pieces = max(1, -(-rows.size // _CHUNK))
            for piece in np.array_split(np.arange(rows.size), pieces):
                if piece.size:
                    key = (rows[piece] - rows[piece[0]]).astype(np.int64).tobytes()
                    groups.setdefault(key, []).append(start + piece)
            start += rows.size
        self.size = start
        self._chunks: list[tuple[Integers, FloatArray]] = []
        log_determinant = np.zeros(len(_colours(kernel)))
        for key, places in groups.items():
            inverse, chunk_log_determinant = _factors(key, kernel)
            self._chunks.append((np.stack(places), inverse))
            log_determinant += len(places) * chunk_log_determinant
        self._log_determinant = log_determinant

    def evidence(self, residual: FloatArray) -> NoiseEvidence:
        """Return the likelihood of a residual (n,) with level and colour fitted."""
        if self.size == 0:
            return NoiseEvidence(0.0, 0.0, 0)
        quadratic = np.zeros(len(_colours(self._kernel)))
        for places, inverse in self._chunks:
            quadratic += np.sum((inverse @ residual[places].T) ** 2, axis=(1, 2))
        variance = np.maximum(quadratic / self.size, 1e-300)
        log_likelihood = -0.5 * self.size * (np.log(2.0 * np.pi * variance) + 1.0) - 0.5 * self._log_determinant
        best = int(np.argmax(np.where(self._believed, log_likelihood, -np.inf)))
        return NoiseEvidence(float(log_likelihood[best]), float(np.sqrt(variance[best])), best)

    def white_share(self, colour: int) -> float:
        """Return the share of white noise in the variance of a colour."""
        return _colours(self._kernel)[colour][1]

    def whiten(self, values: FloatArray, colour: int) -> FloatArray:
        """Return values (n,) or (n, p) decorrelated under a colour, at unit level."""
        if colour == 0:
            return values
        out = np.empty_like(values)
        for places, inverse in self._chunks:
            out[places] = np.einsum("ij,cj...->ci...", inverse[colour], values[places])
        return out


_CACHE: dict[tuple[bytes, Kernel], tuple[FloatArray, FloatArray]] = {}


def _colours(kernel: Kernel) -> tuple[tuple[float, float], ...]:
    return NOISE_COLOURS if kernel == "rough" else SMOOTH_COLOURS


def _factors(key: bytes, kernel: Kernel) -> tuple[FloatArray, FloatArray]:
    """Return the inverse Cholesky factors (colours, m, m) and log determinants (colours,) of one chunk."""
    found = _CACHE.get((key, kernel))
    if found is None:
        rows = np.frombuffer(key, dtype=np.int64)
        lag = np.abs(rows[:, np.newaxis] - rows)
        alone = np.eye(rows.size)
        covariance = np.stack(
            [
                (1.0 - white) * _correlation(lag, parameter, kernel) + white * alone
                for parameter, white in _colours(kernel)
            ]
        )
        factor = np.linalg.cholesky(covariance)
        log_determinant = 2.0 * np.sum(np.log(np.diagonal(factor, axis1=1, axis2=2)), axis=1)
        found = np.linalg.inv(factor), log_determinant
        if len(_CACHE) > 256:
            _CACHE.clear()
        _CACHE[key, kernel] = found
    return found


def _correlation(lag: Integers, parameter: float, kernel: Kernel) -> FloatArray:
    if kernel == "rough":
        return np.asarray(parameter**lag)
    return np.exp(-0.5 * (lag / parameter) ** 2)


def nearest_colour(estimate: NoiseEstimate) -> int:
    """Return the noise model's colour that is nearest to an estimate."""
    wanted = estimate.correlation, 1.0 - estimate.white_share if estimate.memory > 0.0 else 0.0
    memory = estimate.memory
    distance = [
        abs(m * (1.0 - w) - wanted[0]) + 0.3 * abs((1.0 - w) - wanted[1]) * (m > 0.0) + 0.1 * abs(m - memory)
        for m, w in NOISE_COLOURS
    ]
    return int(np.argmin(distance))
