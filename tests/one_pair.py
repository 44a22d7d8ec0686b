"""A second route to the figures of a pair, for tests alone: equation (8) of P summed over merged pieces, one pair at a time."""

from types import SimpleNamespace

import numpy as np

from coast_cli.mechanics.beam import solve_beam


def pair_figures(outer, middle, gravity):
    """Figures of one pair, each tube sagging by itself; named as in ``PairTable``."""
    ends = [np.cumsum(tube.segments.length) for tube in (outer, middle)]
    overlap = min(end[-1] for end in ends)
    breaks = np.unique(np.concatenate(ends))
    breaks = np.concatenate(([0.0], breaks[breaks < overlap * (1.0 - 1e-12)], [overlap]))
    length, inside = np.diff(breaks), 0.5 * (breaks[1:] + breaks[:-1])
    bend, rigidity = np.zeros(length.size), np.zeros(length.size)
    for tube, end in zip((outer, middle), ends, strict=True):
        own = tube.segments.rigidity[np.searchsorted(end, inside)]
        solution = solve_beam(tube, gravity)
        bend += own * np.diff(np.interp(breaks, solution.s, solution.angle))
        rigidity += own
    bend /= rigidity
    return SimpleNamespace(
        total_precurvature=float(np.abs(bend).sum()),
        signed_precurvature=float(bend.sum()),
        ratio_mean=outer.rigidity_mean / middle.rigidity_mean,
        ratio_series=outer.rigidity_series / middle.rigidity_series,
        total_mean=float(rigidity @ length / overlap),
        total_series=float(overlap / np.sum(length / rigidity)),
    )
