"""Sobol indices: which share of a figure's variance each input makes, alone and with all that it interacts with.

Saltelli et al., Computer Physics Communications 181 (2010), on a scrambled Sobol sequence; the estimators are scipy's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from coast_cli.mechanics.section import FloatArray

_EDGE = 1e-9  # probabilities stay this far inside 0..1, where a normal error is finite
_CONSTANT = 1e-12  # relative spread below which a figure does not vary


@dataclass(frozen=True, slots=True)
class Indices:
    """For each figure that varies: first-order and total indices, (inputs,) each; and samples that had no value."""

    indices: Mapping[str, tuple[FloatArray, FloatArray]]
    replaced: int


def sobol_indices_of(
    figures: Callable[[FloatArray], Mapping[str, FloatArray]], inputs: int, samples: int, seed: int
) -> Indices:
    """Return the indices of every figure.

    Args:
        figures: from probabilities, shape (m, inputs), to columns of shape (m,); NaN counts as the mean.
        samples: a power of two; ``figures`` is asked for (inputs + 2) times as many rows.
    """
    from scipy.stats import qmc, sobol_indices

    if inputs == 0:
        return Indices({}, 0)
    table = np.clip(qmc.Sobol(2 * inputs, seed=seed).random(samples), _EDGE, 1.0 - _EDGE)
    one, two = table[:, :inputs], table[:, inputs:]
    mixed = np.repeat(one[None], inputs, axis=0)
    each = np.arange(inputs)
    mixed[each, :, each] = two.T
    columns = figures(np.concatenate((one, two, mixed.reshape(-1, inputs))))
    values = np.stack(list(columns.values()))
    lost = ~np.isfinite(values)
    centre = np.nanmean(values, axis=1, keepdims=True)
    size = np.nanstd(values, axis=1, keepdims=True)
    moved = (size > _CONSTANT * np.abs(centre)).ravel()
    # Scaled, since the estimators of figures far from zero cancel.
    scaled = np.where(lost, 0.0, (values - centre) / np.where(size > 0.0, size, 1.0))[moved]
    rest = scaled[:, 2 * samples :].reshape(-1, inputs, samples).transpose(1, 0, 2)
    tables: Any = {"f_A": scaled[:, :samples], "f_B": scaled[:, samples : 2 * samples], "f_AB": rest}
    result = sobol_indices(func=tables, n=samples)
    names = np.array(list(columns))[moved].tolist()
    orders = np.atleast_2d(result.first_order), np.atleast_2d(result.total_order)  # scipy drops the axis of one figure
    found = zip(names, zip(*orders, strict=True), strict=True)
    return Indices(dict(found), int(np.count_nonzero(np.any(lost, axis=0))))
