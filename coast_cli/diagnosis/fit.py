"""Fit a set of effects together with the base model's own parameters, and say how likely what is left is as noise.

Three passes: a rough one at the white level of the recording; a fine one at the level and colour that it left; and, for
what is compared closely or printed, a tight one by central differences, to where a further step gains nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from coast_cli.diagnosis.noise_model import NoiseEvidence
from coast_cli.diagnosis.problem import Problem
from coast_cli.diagnosis.space import Booleans, ParameterSpace, inverse
from coast_cli.effects.effect import Effect
from coast_cli.mechanics.least_squares import Descent, descend
from coast_cli.mechanics.section import FloatArray

ROUGH_STEPS = 14
_FINE_STEPS = 5
_TIGHT_STEPS = 20
_SIZES_FIRST = 3  # steps in which what only shapes an effect stays where it starts
# Share of the cost that a further step may still gain where a pass has settled: each only leads to the next.
_ROUGH, _FINE, _TIGHT = 5e-4, 2e-4, 1e-10
# Share of a parameter's scale to which each pass rounds its steps: what is finer is not printed, and differs by processor.
_COARSE_GRID, _FINE_GRID = 1e-5, 1e-6
_SMALLEST_LEVEL = 1e-15
Pass = Literal["rough", "fine", "tight"]


@dataclass(frozen=True, slots=True)
class Fit:
    """A fitted hypothesis.

    Attributes:
        effects: with their fitted parameters. coordinates: base parameters in fit coordinates (p,).
        covariance: of base and then effect parameters, in fit coordinates (q, q).
        evidences: of each channel's residual as noise. residuals: recorded less predicted, of each channel.
        jacobian: of the whole residual by every parameter (n, q).
        log_likelihood: of all channels, plus the log prior of what is expected somewhere.
        at_bound: for each of the q parameters. converged: whether the fit settled before its step limit.
    """

    effects: tuple[Effect, ...]
    coordinates: FloatArray
    covariance: FloatArray
    evidences: tuple[NoiseEvidence, ...]
    residuals: tuple[FloatArray, ...]
    jacobian: FloatArray
    log_likelihood: float
    at_bound: tuple[bool, ...]
    converged: bool

    @property
    def ids(self) -> tuple[str, ...]:
        """Effect ids in the order in which they act."""
        return tuple(effect.id for effect in self.effects)

    @property
    def parameter_count(self) -> int:
        """Number of effect parameters that were fitted."""
        return len(self.at_bound) - self.coordinates.size

    @property
    def residual(self) -> FloatArray:
        """Residual of the response."""
        return self.residuals[0]

    @property
    def evidence(self) -> NoiseEvidence:
        """NoiseEvidence of the response's residual."""
        return self.evidences[0]

    @property
    def rmse(self) -> float:
        """RMS of the response's residual, SI."""
        return rms(self.residual)

    @property
    def stacked(self) -> FloatArray:
        """The whole residual."""
        return np.concatenate(self.residuals)


def rms(values: FloatArray) -> float:
    """Return the root mean square; 0 of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0


def fit(
    problem: Problem,
    effects: Sequence[Effect] = (),
    start: FloatArray | None = None,
    *,
    steps: int = ROUGH_STEPS,
    until: Pass = "tight",
) -> Fit:
    """Fit base parameters and the parameters of ``effects`` from their current values.

    Args:
        start: base coordinates to start from; as configured by default.
        steps: limit of the rough pass; none where the start is a fit already. until: the last pass that is made.
    """
    space = problem.space(effects)
    base = np.array([c.inner(c.value) for c in space.base]) if start is None else start
    weighing = _Weighing(problem, space)
    grid = space.grid(_COARSE_GRID)
    vector = np.clip(np.rint(space.joined(base) / grid) * grid, space.low, space.high)
    weighing.white(weighing.residual(vector))
    first = min(steps, _SIZES_FIRST) if np.any(space.late & space.moving) else 0
    if first:
        vector = weighing.descend(vector, first, _ROUGH, ~space.late).x
    found = weighing.descend(vector, steps - first, _ROUGH, space.moving)
    if until != "rough":
        weighing.coloured(_evidences(problem, weighing.unstacked(found)))
        found = weighing.descend(found.x, _FINE_STEPS, _FINE, space.moving)
    if until == "tight":
        found = weighing.descend(found.x, _TIGHT_STEPS, _TIGHT, space.moving, central=True)
    return _finished(weighing, found)


class _Weighing:
    """The residual of a problem in noise levels, decorrelated, with the priors below it; remembers the latest residual."""

    def __init__(self, problem: Problem, space: ParameterSpace) -> None:
        self.problem, self.space = problem, space
        self.levels: list[float] = []
        self.colours: list[int] = []
        self._latest: tuple[FloatArray, FloatArray] | None = None
        self.slopes: FloatArray | None = None

    def white(self, start: FloatArray) -> None:
        """Weigh by the rough noise, white."""
        channels = self.problem.channels
        self.levels = [max(c.level, c.loosened * rms(start[c.rows]), _SMALLEST_LEVEL) for c in channels]
        self.colours = [0 for _ in channels]

    def coloured(self, evidences: Sequence[NoiseEvidence]) -> None:
        """Weigh by what a residual is as noise."""
        self.levels = [max(evidence.level, _SMALLEST_LEVEL) for evidence in evidences]
        self.colours = [evidence.colour for evidence in evidences]

    def residual(self, vector: FloatArray) -> FloatArray:
        """Return the raw residual at a vector."""
        if self._latest is None or not np.array_equal(self._latest[0], vector):
            self._latest = vector.copy(), self.problem.residuals([self.space.split(vector)])[0]
        return self._latest[1]

    def unstacked(self, found: Descent) -> tuple[FloatArray, ...]:
        """Return the raw residual of each channel where a descent ended."""
        raw = self.residual(found.x)
        return tuple(raw[channel.rows] for channel in self.problem.channels)

    def raw_slopes(self, vector: FloatArray, moving: Booleans, *, central: bool) -> FloatArray:
        """Return the raw Jacobian, and remember it."""

        def residuals(vectors: Sequence[FloatArray]) -> list[FloatArray]:
            return self.problem.residuals([self.space.split(one) for one in vectors])

        self.slopes = self.space.jacobian(residuals, vector, self.residual(vector), moving, central=central)
        return self.slopes

    def weighted(self, raw: FloatArray) -> FloatArray:
        """Return values (n,) or (n, q) in noise levels, decorrelated."""
        return np.concatenate(
            [
                channel.bank.whiten(raw[channel.rows] / level, colour)
                for channel, level, colour in zip(self.problem.channels, self.levels, self.colours, strict=True)
            ]
        )

    def descend(
        self, vector: FloatArray, steps: int, tolerance: float, moving: Booleans, *, central: bool = False
    ) -> Descent:
        """Descend from a vector with the weights as they are."""
        space = self.space
        pull_slopes = space.pull_slopes * moving

        def residual(x: FloatArray) -> FloatArray:
            return np.concatenate([self.weighted(self.residual(x)), space.pull(x)])

        def jacobian(x: FloatArray, _: FloatArray) -> FloatArray:
            raw = self.raw_slopes(x, moving, central=central)
            return np.concatenate([self.weighted(raw), pull_slopes])

        return descend(
            residual,
            jacobian,
            vector,
            space.low,
            space.high,
            steps=steps,
            tolerance=tolerance,
            reach=space.reach,
            grid=space.grid(_FINE_GRID if central else _COARSE_GRID),
        )


def _finished(weighing: _Weighing, found: Descent) -> Fit:
    problem, space = weighing.problem, weighing.space
    residuals = weighing.unstacked(found)
    evidences = _evidences(problem, residuals)
    # That of the last step: where a fit has settled it is the one here.
    raw = weighing.slopes if weighing.slopes is not None else weighing.raw_slopes(found.x, space.moving, central=False)
    weighing.coloured(evidences)
    slopes = weighing.weighted(raw)[:, space.moving]
    precision = slopes.T @ slopes / problem.misfit + np.diag(1.0 / space.spread[space.moving] ** 2)
    covariance = np.zeros((found.x.size, found.x.size))
    covariance[np.ix_(space.moving, space.moving)] = inverse(precision)
    coordinates, effects = space.split(found.x)
    return Fit(
        effects=effects,
        coordinates=coordinates,
        covariance=covariance,
        evidences=evidences,
        residuals=residuals,
        jacobian=raw,
        log_likelihood=sum(evidence.log_likelihood for evidence in evidences) + space.log_prior(found.x),
        at_bound=space.touching(found.x),
        converged=found.converged,
    )


def _evidences(problem: Problem, residuals: Sequence[FloatArray]) -> tuple[NoiseEvidence, ...]:
    return tuple(channel.bank.evidence(residual) for channel, residual in zip(problem.channels, residuals, strict=True))
