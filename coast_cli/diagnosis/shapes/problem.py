"""What is fitted to what: photographs, the base model's free parameters, and the residuals between them.

Free are the modulus of every material and the natural curvature of every tube that was photographed alone; a pair shows only
the rigidity-weighted mean of two natural curvatures, so those stay as configured. Nothing else moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.likelihood import NoiseBank
from coast_cli.diagnosis.shapes.forward import Forward, Job, State, misfit
from coast_cli.diagnosis.shapes.photograph import Photograph, photographs, usual_sign
from coast_cli.effects.shapes.catalogue import build_shape_effects
from coast_cli.effects.shapes.effect import Scene, ShapeEffect
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import GIGAPASCAL

if TYPE_CHECKING:
    from coast_cli.recordings.model import ShapeRun
    from coast_cli.spec.config import Config

Booleans = NDArray[np.bool_]
_MODULUS_PRIOR = 0.5  # of the logarithm
_MODULUS_RANGE = 8.0
_CURVATURE_PRIOR = 0.5  # of the configured value, and at least ...
_CURVATURE_TURN = 0.3  # ... this turn of the whole tube, rad


@dataclass(frozen=True, slots=True)
class BaseParameter:
    """A free number of the base model by its key in the file; fitted as a logarithm where it is a modulus.

    Attributes:
        key: dotted, e.g. ``materials.nitinol.youngs_modulus_gpa``. value: configured. prior: standard deviation.
        tubes: numbers of the tubes it belongs to.
    """

    key: str
    value: float
    low: float
    high: float
    prior: float
    tubes: tuple[int, ...]
    logarithmic: bool


@dataclass(frozen=True)
class Problem:
    """Photographs, ready to be fitted.

    Attributes:
        forward: the model. calibratable: numbers that photographs can free. train: which points of each are fitted, (n,).
        numbers: natural curvature (towards its own side, 1/m) and modulus (Pa) as configured, by tube number.
        fixed_effects: corrections that the configuration already carries.
    """

    forward: Forward
    calibratable: tuple[BaseParameter, ...]
    train: tuple[Booleans, ...]
    modulus: Mapping[int, float]
    natural: Mapping[int, float]
    names: Mapping[int, str]
    fixed_effects: tuple[ShapeEffect, ...]

    @property
    def photographs(self) -> tuple[Photograph, ...]:
        """The photographs."""
        return self.forward.photographs

    @cached_property
    def base(self) -> tuple[BaseParameter, ...]:
        """The free parameters: of tubes that are fitted; those of tubes held out stay as configured."""
        pairs = zip(self.photographs, self.train, strict=True)
        fitted = {number for photograph, train in pairs if train.any() for number, _ in photograph.tubes}
        return tuple(parameter for parameter in self.calibratable if fitted & set(parameter.tubes))

    @cached_property
    def scene(self) -> Scene:
        """What there is to choose starts from."""
        tubes = {number: tube for photograph in self.photographs for number, tube in photograph.tubes}
        weights = [float(t.segments.weight @ t.segments.length) * self.forward.gravity for t in tubes.values()]
        return Scene(
            tubes={number: tubes[number].name for number in sorted(tubes)},
            alone=frozenset(photograph.tubes[0][0] for photograph in self.photographs if not photograph.is_pair),
            length=max(photograph.length for photograph in self.photographs),
            weight=max(*weights, 1e-12),
            pairs=any(photograph.is_pair for photograph in self.photographs),
        )

    @cached_property
    def rows(self) -> tuple[tuple[Booleans, Booleans], ...]:
        """For each photograph which residuals across and along the line are fitted."""
        return tuple(
            (train, train[photograph.placed]) for photograph, train in zip(self.photographs, self.train, strict=True)
        )

    @cached_property
    def bank(self) -> NoiseBank:
        """Noise models of the fitted residuals, photograph by photograph."""
        return NoiseBank(self.sequences)

    @cached_property
    def sequences(self) -> list[NDArray[np.int64]]:
        """Point numbers of each sequence of residuals: across, then along the line."""
        found = []
        for photograph, (across, along) in zip(self.photographs, self.rows, strict=True):
            found += [np.flatnonzero(across), np.flatnonzero(photograph.placed)[along]]
        return found

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Where each photograph's residuals stand."""
        ends = np.cumsum([0, *(int(across.sum() + along.sum()) for across, along in self.rows)])
        return tuple(slice(int(low), int(high)) for low, high in pairwise(ends))

    @cached_property
    def along(self) -> Booleans:
        """Which fitted residuals lie along the line: of the tips, and of points whose place is known."""
        parts = [np.arange(int(a.sum() + b.sum())) >= int(a.sum()) for a, b in self.rows]
        found: Booleans = np.concatenate(parts)
        return found

    @property
    def size(self) -> int:
        """Number of fitted residuals."""
        return int(self.slices[-1].stop)

    def configured(self) -> FloatArray:
        """Return the base parameters as configured, in fit coordinates."""
        return np.array([np.log(p.value) if p.logarithmic else p.value for p in self.base])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the bounds of the base parameters, in fit coordinates."""
        low = np.array([np.log(p.low) if p.logarithmic else p.low for p in self.base])
        high = np.array([np.log(p.high) if p.logarithmic else p.high for p in self.base])
        return low, high

    def values(self, coordinates: FloatArray) -> dict[str, float]:
        """Return the base parameters by key, in the unit of the file."""
        pairs = zip(self.base, coordinates.tolist(), strict=True)
        return {p.key: float(np.exp(c)) if p.logarithmic else c for p, c in pairs}

    def state(self, coordinates: FloatArray, effects: Sequence[ShapeEffect]) -> State:
        """Return one set of parameters."""
        modulus, natural = dict(self.modulus), dict(self.natural)
        for parameter, value in zip(self.base, coordinates.tolist(), strict=True):
            for tube in parameter.tubes:
                if parameter.logarithmic:
                    modulus[tube] = float(np.exp(value)) * GIGAPASCAL
                else:
                    natural[tube] = value
        return State(modulus, natural, (*self.fixed_effects, *effects))

    def residuals(self, jobs: Sequence[Job]) -> list[FloatArray]:
        """Return the fitted residuals of each job's photograph, observed less model, m."""
        found = []
        for (index, _), line in zip(jobs, self.forward.lines(jobs), strict=True):
            across, along = misfit(self.photographs[index], line)
            rows = self.rows[index]
            found.append(np.concatenate((across[0][rows[0]], along[0][rows[1]])))
        return found

    def residual(self, coordinates: FloatArray, effects: Sequence[ShapeEffect] = ()) -> FloatArray:
        """Return all fitted residuals of one set of parameters, m."""
        state = self.state(coordinates, effects)
        return np.concatenate(self.residuals([(index, state) for index in range(len(self.photographs))]))

    def touched(self, effect: ShapeEffect) -> list[int]:
        """Return the photographs that an effect changes."""
        return [
            index for index, photograph in enumerate(self.photographs)
            if (photograph.is_pair or not effect.on_pairs)
            and any(effect.acts_on(number) for number, _ in photograph.tubes)
        ]  # fmt: skip

    def touched_by_base(self, place: int) -> list[int]:
        """Return the photographs that a base parameter changes."""
        tubes = set(self.base[place].tubes)
        return [i for i, p in enumerate(self.photographs) if tubes & {number for number, _ in p.tubes}]

    def with_train(self, train: Sequence[Booleans]) -> Problem:
        """Return the same with other points fitted."""
        return replace(self, train=tuple(train))


def build_problem(config: Config, runs: Sequence[ShapeRun]) -> Problem:
    """Return the problem that runs pose to a configuration, all points fitted.

    Raises:
        BadInput: a tube is unknown, or the points cannot be its shape.
    """
    from coast_cli.spec.build import build

    design = build(config)
    taken = photographs(design, runs)
    tubes = {place + 1: tube for place, tube in enumerate((*design.outer, *design.middle))}
    natural = {number: usual_sign(design, tube) * tube.natural_curvature for number, tube in tubes.items()}
    seen = {number for photograph in taken for number, _ in photograph.tubes}
    alone = {photograph.tubes[0][0] for photograph in taken if not photograph.is_pair}
    return Problem(
        forward=Forward(taken, design.gravity),
        calibratable=(*_moduli(config, seen), *_curvatures(config, alone, natural, {n: t.length for n, t in tubes.items()})),
        train=tuple(np.ones(len(run), dtype=bool) for run in runs),
        modulus={number: tube.youngs_modulus for number, tube in tubes.items()},
        natural=natural,
        names={number: tube.name for number, tube in tubes.items()},
        fixed_effects=build_shape_effects(config.corrections),
    )


def _moduli(config: Config, seen: set[int]) -> list[BaseParameter]:
    from coast_cli.spec.tubes import bench_tubes
    from coast_cli.spec.values import Calibrated

    materials: dict[str, list[int]] = {}
    for place, tube in enumerate((*bench_tubes(config, "outer"), *bench_tubes(config, "middle"))):
        if place + 1 in seen:
            materials.setdefault(tube.material, []).append(place + 1)
    found = []
    for name, numbers in materials.items():
        given = config.materials[name].youngs_modulus_gpa
        key = f"materials.{name}.youngs_modulus_gpa"
        if isinstance(given, Calibrated):
            prior = max(float(np.log(given.max / given.min)) / 4.0, 1e-9)
            found.append(BaseParameter(key, given.value, given.min, given.max, prior, tuple(numbers), logarithmic=True))
        else:
            low, high = max(given / _MODULUS_RANGE, 0.001), min(given * _MODULUS_RANGE, 1e4)
            found.append(BaseParameter(key, given, low, high, _MODULUS_PRIOR, tuple(numbers), logarithmic=True))
    return found


def _curvatures(
    config: Config, alone: set[int], natural: Mapping[int, float], lengths: Mapping[int, float]
) -> list[BaseParameter]:
    outer = 0 if config.outer is None else len(config.outer.samples)
    found = []
    for number in sorted(alone):
        role, stock, place = ("outer", config.outer, number - 1) if number <= outer else (
            "middle", config.middle, number - 1 - outer)  # fmt: skip
        name = "" if stock is None else stock.samples[place].name
        value = natural[number]
        prior = max(_CURVATURE_PRIOR * abs(value), _CURVATURE_TURN / lengths[number])
        reach = 8.0 * prior + abs(value)
        low, high = max(value - reach, -1000.0), min(value + reach, 1000.0)
        key = f"{role}.samples.{name}.natural_curvature_per_m"
        found.append(BaseParameter(key, value, low, high, prior, (number,), logarithmic=False))
    return found
