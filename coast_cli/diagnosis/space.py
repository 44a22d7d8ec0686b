"""The numbers that a fit moves: bounds, priors, and the one Jacobian.

A base parameter belongs to the model as configured, the others to the effects of a hypothesis. A fit moves coordinates: the
number itself, or its logarithm. Every coordinate has a prior width, which Occam's factor compares with what the recording
says; where physics expects a value the prior draws towards it, elsewhere it only holds what nothing else determines.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from coast_cli.effects.effect import Effect
from coast_cli.mechanics.section import FloatArray

Booleans = NDArray[np.bool_]
Point = tuple[FloatArray, tuple[Effect, ...]]

_DIFFERENCE = 1e-3  # of a coordinate's scale: wide enough to see past the kinks of tables and knees
# Prior widths by which a coordinate is held, at least its null and at most its range: it moves nothing that is seen.
_HOLD = 4.0


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One number that a fit moves.

    Attributes:
        name: as users know it. value: where it stands, low, high: bounds, all in its own unit.
        width: prior standard deviation, as a coordinate. scale: size over which it matters, for differences.
        mean: its prior's middle, as a coordinate; None where nothing is expected. null: where it is held.
        reach: longest step of a fit. logarithmic: whether the coordinate is the logarithm.
        late: says how an effect acts, not how strongly; a fit moves it after the others.
        pays: whether evidence charges for it.
    """

    name: str
    value: float
    low: float
    high: float
    width: float
    scale: float
    mean: float | None = None
    null: float = 0.0
    reach: float = np.inf
    logarithmic: bool = False
    late: bool = False
    pays: bool = True

    def inner(self, value: float) -> float:
        """Return the coordinate of a value."""
        return float(np.log(value)) if self.logarithmic else value


@dataclass(frozen=True)
class BaseParameter:
    """One number of the base model that a fit may move: as configured, its bounds, its prior's standard deviation.

    ``start``: from where fits begin, where that is not as configured.
    """

    name: str
    value: float
    low: float
    high: float
    prior: float
    logarithmic: bool = False
    start: float | None = None

    @property
    def inner(self) -> float:
        """The configured value as a coordinate."""
        return float(np.log(self.value)) if self.logarithmic else self.value

    def outer(self, coordinate: float) -> float:
        """Return the value of a coordinate."""
        return float(np.exp(coordinate)) if self.logarithmic else float(coordinate)


def configured_coordinates(base: Sequence[BaseParameter]) -> FloatArray:
    """Return base parameters as configured, in fit coordinates (p,)."""
    return np.array([parameter.inner for parameter in base])


def bounds_of(base: Sequence[BaseParameter]) -> tuple[FloatArray, FloatArray]:
    """Return lower and upper bounds of base parameters in fit coordinates, each (p,)."""
    ends = [(np.log(p.low), np.log(p.high)) if p.logarithmic else (p.low, p.high) for p in base]
    return np.array([low for low, _ in ends]), np.array([high for _, high in ends])


@dataclass(frozen=True)
class ParameterSpace:
    """The vector (q,) of base coordinates and then each effect's, and how it becomes effects.

    Attributes:
        base: coordinates of the base model. effects: in the order in which they act. owned: coordinates of each effect.
    """

    base: tuple[Coordinate, ...]
    effects: tuple[Effect, ...]
    owned: tuple[tuple[Coordinate, ...], ...]

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """All coordinates in order."""
        return (*self.base, *chain.from_iterable(self.owned))

    @cached_property
    def low(self) -> FloatArray:
        """Lower bounds (q,)."""
        return np.array([c.inner(c.low) for c in self.coordinates])

    @cached_property
    def high(self) -> FloatArray:
        """Upper bounds (q,)."""
        return np.array([c.inner(c.high) for c in self.coordinates])

    @cached_property
    def width(self) -> FloatArray:
        """Prior standard deviations (q,)."""
        return np.array([c.width for c in self.coordinates])

    @cached_property
    def reach(self) -> FloatArray:
        """Longest steps of a fit (q,)."""
        return np.array([c.reach for c in self.coordinates])

    @cached_property
    def scale(self) -> FloatArray:
        """Size over which each coordinate matters (q,)."""
        return np.array([c.scale for c in self.coordinates])

    def grid(self, share: float) -> FloatArray:
        """Return a spacing (q,) of about this share of the scale, a power of two so that rounding to it is exact."""
        return np.asarray(2.0 ** np.floor(np.log2(share * np.maximum(self.scale, 1e-300))))

    @cached_property
    def moving(self) -> Booleans:
        """Which coordinates have room to move (q,)."""
        return self.high > self.low

    @cached_property
    def late(self) -> Booleans:
        """Which coordinates a fit moves after the others (q,)."""
        return np.array([c.late for c in self.coordinates], dtype=bool)

    @cached_property
    def pays(self) -> Booleans:
        """Which coordinates evidence charges for (q,)."""
        return np.array([c.pays for c in self.coordinates], dtype=bool)

    @cached_property
    def expected(self) -> Booleans:
        """Which coordinates a prior draws towards a value (q,)."""
        return np.array([c.mean is not None for c in self.coordinates], dtype=bool)

    @cached_property
    def _mean(self) -> FloatArray:
        return np.array([c.null if c.mean is None else c.mean for c in self.coordinates])

    @cached_property
    def spread(self) -> FloatArray:
        """Standard deviation of what draws or holds each coordinate (q,)."""
        span = self.high - self.low
        hold = np.maximum(_HOLD * self.width, np.where(self._mean != 0.0, np.abs(self._mean), span))
        hold = np.where(span > 0.0, np.minimum(hold, span), hold)
        return np.asarray(np.where(self.expected, self.width, np.maximum(hold, 1e-300)))

    def joined(self, base: FloatArray) -> FloatArray:
        """Return the vector of base coordinates and of the effects as they stand, inside the bounds."""
        own = [c.inner(c.value) for c in chain.from_iterable(self.owned)]
        joined: FloatArray = np.clip(np.concatenate([base, own]), self.low, self.high)
        return joined

    def split(self, vector: FloatArray) -> Point:
        """Return base coordinates and effects of a vector."""
        at, effects = len(self.base), []
        for effect, owned in zip(self.effects, self.owned, strict=True):
            values = {}
            for place, c in enumerate(owned, start=at):
                value = float(np.exp(vector[place])) if c.logarithmic else float(vector[place])
                values[c.name] = float(np.clip(value, c.low, c.high))
            effects.append(effect.with_numbers(values))
            at += len(owned)
        return vector[: len(self.base)], tuple(effects)

    def pull(self, vector: FloatArray) -> FloatArray:
        """Return how far each coordinate lies from what draws or holds it, in standard deviations (q,)."""
        pull: FloatArray = (vector - self._mean) / self.spread
        return pull

    @property
    def pull_slopes(self) -> FloatArray:
        """Derivative of ``pull`` (q, q)."""
        return np.diag(1.0 / self.spread)

    def log_prior(self, vector: FloatArray) -> float:
        """Return the log prior of the coordinates that are expected somewhere, without its constant."""
        return -0.5 * float(np.sum(self.pull(vector)[self.expected] ** 2))

    def touching(self, vector: FloatArray) -> tuple[bool, ...]:
        """Return which coordinates lie on a bound."""
        margin = 1e-6 * (self.high - self.low)
        on = ((vector <= self.low + margin) | (vector >= self.high - margin)) & self.moving
        return tuple(bool(one) for one in on)

    def jacobian(
        self,
        residuals: Callable[[Sequence[FloatArray]], Sequence[FloatArray]],
        vector: FloatArray,
        here: FloatArray,
        moving: Booleans,
        *,
        central: bool = True,
    ) -> FloatArray:
        """Return the derivative (n, q) of a residual in one batch, zero where a coordinate does not move.

        Args:
            residuals: vectors -> their residuals, each (n,). vector: where (q,). here: the residual there (n,).
            central: differences to both sides where both lie inside the bounds; else to one.
        """
        ahead, behind = np.array(vector), np.array(vector)
        scale = self.scale * _DIFFERENCE
        ahead = np.where(vector + scale <= self.high, vector + scale, vector)
        behind = np.where((vector - scale >= self.low) & (central | (ahead == vector)), vector - scale, vector)
        places = [(p, end) for p in np.flatnonzero(moving).tolist() for end in (ahead, behind) if end[p] != vector[p]]
        batch = []
        for place, end in places:
            moved = vector.copy()
            moved[place] = end[place]
            batch.append(moved)
        slopes = np.zeros((here.size, vector.size))
        found: dict[int, list[FloatArray]] = {}
        for (place, _), residual in zip(places, residuals(batch) if batch else [], strict=True):
            found.setdefault(place, []).append(residual)
        for place, ends in found.items():
            span = ahead[place] - behind[place]
            slopes[:, place] = (ends[0] - (ends[1] if len(ends) == 2 else here)) / span
            if len(ends) == 1 and ahead[place] == vector[place]:
                slopes[:, place] *= -1.0
        return slopes


def inverse(precision: FloatArray) -> FloatArray:
    """Return the inverse (q, q) of a symmetric precision with a positive diagonal, finite for every one.

    What rounding leaves of a direction is taken as its rounding error: a recording without noise fixes one combination of
    parameters so much better than another that the lesser one is lost, and the matrix singular.
    """
    unit = 1.0 / np.sqrt(np.diag(precision))
    values, vectors = np.linalg.eigh(precision * np.outer(unit, unit))
    values = np.maximum(values, unit.size * np.finfo(float).eps)
    found: FloatArray = (vectors / values) @ vectors.T * np.outer(unit, unit)
    return found
