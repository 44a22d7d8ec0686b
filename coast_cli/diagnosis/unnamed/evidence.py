"""The evidence of linear models in closed form, of many residuals at once: Bayesian regression with a few prior widths.

MacKay, Neural Computation 4 (1992) 415.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from coast_cli.mechanics.section import FloatArray

# Sizes of a law, in noise widths, over which its prior is spread.
AMPLITUDES = (1.0, 4.0, 16.0, 64.0)


def linear_evidence(
    columns: FloatArray, norms: FloatArray, slices: Sequence[slice], residuals: FloatArray
) -> tuple[FloatArray, list[FloatArray]]:
    """Return the evidence of every cell for residuals (n, b), (c, b), and the amplitudes for the first of them.

    Args:
        columns: whitened functions of all cells (n, k), what others follow taken out. norms: of the functions before
            that (k,), RMS, over which the priors of amplitudes are spread. slices: columns of each cell.
    """
    products = columns.T @ residuals
    found, weights = np.zeros((len(slices), residuals.shape[1])), []
    for index, part in enumerate(slices):
        own, scale = columns[:, part], np.where(norms[part] > 0.0, norms[part], 1.0)
        gram = own.T @ own
        best, kept = np.full(residuals.shape[1], -np.inf), np.zeros(part.stop - part.start)
        for amplitude in AMPLITUDES:
            width = amplitude / scale / (1.0 + np.arange(scale.size))
            width = np.where(norms[part] > 0.0, width, 0.0)
            values, vectors = np.linalg.eigh(gram * np.outer(width, width))
            values = np.maximum(values, 0.0)
            along = vectors.T @ (width[:, np.newaxis] * products[part])
            nats = 0.5 * np.sum(along**2 / (1.0 + values)[:, np.newaxis], axis=0)
            nats -= 0.5 * float(np.sum(np.log1p(values)))
            if nats[0] > best[0]:
                kept = width * (vectors @ (along[:, 0] / (1.0 + values)))
            best = np.maximum(best, nats)
        found[index] = best
        weights.append(kept)
    return found, weights


def orthonormal(columns: FloatArray) -> FloatArray:
    """Return an orthonormal basis of the directions that columns (n, q) see."""
    norms = np.linalg.norm(columns, axis=0)
    seen = columns[:, norms > 0.0] / norms[norms > 0.0]
    if seen.shape[1] == 0:
        return np.zeros((columns.shape[0], 0))
    left, values, _ = np.linalg.svd(seen, full_matrices=False)
    return np.asarray(left[:, values > 1e-7 * values[0]])
