"""Two notched tubes as one: the curvature they settle on and the rigidity they have, equation (8) of P.

P puts each tube's *separately sagged* curvature into (8); that is ``separate``. Ratio and total of the flexural
rigidity come in two measures: ``mean`` along the tube (P), and ``series``, the one that bends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from coast_cli.mechanics.beam import BeamSolution, solve_beam
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.verdict import Verdict

Assembly = Literal["separate", "coupled"]
LeadingTube = Literal["outer", "middle"]


@dataclass(frozen=True, slots=True)
class PairFigures:
    """What a pair is ranked by.

    Attributes:
        total_precurvature: integral of |kappa_final| over the overlap, rad.
        signed_precurvature: integral of kappa_final, rad; positive where the outer tube leads.
        ratio_mean, ratio_series: rigidity of the outer over that of the middle tube.
        total_mean, total_series: rigidity of both tubes together over the overlap, N m^2; in series it is the uniform
            pair that bends as far under one moment, a little more than the sum of the tubes' own series rigidities.
        leading_tube: whose bend the pair follows; snapping was seen where the outer tube leads.
        verdict: of the beam solves beneath.
    """

    total_precurvature: float
    signed_precurvature: float
    ratio_mean: float
    ratio_series: float
    total_mean: float
    total_series: float
    leading_tube: LeadingTube
    verdict: Verdict


def pair_figures(outer: NotchedTube, middle: NotchedTube, gravity: float) -> PairFigures:
    """Return the figures of one pair, each tube sagging by itself (P's assembly); gravity in m/s^2."""
    solved = (solve_beam(outer, gravity), solve_beam(middle, gravity))
    length, rigidity, bend = combined_bend((outer, middle), solved)
    signed = float(bend.sum())
    failed = [solution.verdict for solution in solved if not solution.verdict.converged]
    return PairFigures(
        total_precurvature=float(np.abs(bend).sum()),
        signed_precurvature=signed,
        ratio_mean=outer.rigidity_mean / middle.rigidity_mean,
        ratio_series=outer.rigidity_series / middle.rigidity_series,
        total_mean=float(rigidity @ length / length.sum()),
        total_series=float(length.sum() / np.sum(length / rigidity)),
        leading_tube="outer" if signed > 0.0 else "middle",
        verdict=failed[0] if failed else Verdict(converged=True),
    )


def combined_bend(
    tubes: tuple[NotchedTube, NotchedTube], solved: tuple[BeamSolution, BeamSolution]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return length (m), rigidity (N m^2) and bend (rad) of each common piece of the overlap: (8) integrated exactly.

    On a piece where both rigidities are constant the integral of (8) is the rigidity-weighted mean of the tubes' own
    changes of angle, so no quadrature is needed.
    """
    ends = [np.cumsum(tube.segments.length) for tube in tubes]
    overlap = min(end[-1] for end in ends)
    breaks = np.unique(np.concatenate(ends))
    breaks = np.concatenate(([0.0], breaks[breaks < overlap * (1.0 - 1e-12)], [overlap]))
    middle_of = 0.5 * (breaks[1:] + breaks[:-1])
    # Not added in place: sensitivities are complex.
    weighted: FloatArray = np.zeros(middle_of.size)
    total: FloatArray = np.zeros(middle_of.size)
    for tube, solution, end in zip(tubes, solved, ends, strict=True):
        rigidity = tube.segments.rigidity[np.minimum(np.searchsorted(end, middle_of), end.size - 1)]
        weighted = weighted + rigidity * np.diff(np.interp(breaks, solution.s, solution.angle))
        total = total + rigidity
    return np.diff(breaks), total, weighted / total
