"""What is fitted to what: photographs, the base model's free parameters, and the residuals between them.

Free are the modulus of every material and the natural curvature of every tube that was photographed alone; a pair shows only
the rigidity-weighted mean of two natural curvatures, so those stay as configured. Where a notch end effect takes part,
each tube's may differ from the table by ``END_EFFECT_SPREAD``. Nothing else moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.noise_model import NoiseBank
from coast_cli.diagnosis.shapes.forward import Forward, Job, State, misfit
from coast_cli.diagnosis.shapes.photograph import Photograph, photographs, usual_sign
from coast_cli.effects.shapes.catalogue import build_shape_effects, in_order
from coast_cli.effects.shapes.effect import Scene, ShapeEffect
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.units import GIGAPASCAL, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.model import ShapeRun
    from coast_cli.spec.config import Config

Booleans = NDArray[np.bool_]
_MODULUS_PRIOR = 0.5  # of the logarithm
_MODULUS_RANGE = 8.0
_CURVATURE_PRIOR = 0.5  # of the configured value, and at least ...
_CURVATURE_TURN = 0.3  # ... this turn of the whole tube, rad


# Standard deviation, from tube to tube, of the end effect about the table of sharp-cornered periodic cells: tubes solved
# whole as 3-D solids need 1.00 to 1.10 of their cells' (examples/solid), and the corners of a laser's cut are round.
END_EFFECT_SPREAD = 0.06


@dataclass(frozen=True, slots=True)
class BaseParameter:
    """A free number of the base model by its key in the file; fitted as a logarithm where it is a modulus.

    Attributes:
        key: dotted, e.g. ``materials.nitinol.youngs_modulus_gpa``. value: configured. prior: standard deviation.
        tubes: numbers of the tubes it belongs to. quantity: a spread is that of a tube's end effect, and no key of a file.
    """

    key: str
    value: float
    low: float
    high: float
    prior: float
    tubes: tuple[int, ...]
    quantity: Literal["modulus", "curvature", "spread"]

    @property
    def logarithmic(self) -> bool:
        """Whether the fit moves the logarithm."""
        return self.quantity == "modulus"


@dataclass(frozen=True)
class Problem:
    """Photographs, ready to be fitted.

    Attributes:
        forward: the model. calibratable: numbers that photographs can free. train: which points of each are fitted, (n,).
        modulus, natural: Pa, and natural curvature towards its own side, 1/m, as configured, by tube number.
        stock: every tube of the configuration, photographed or not, by its number, with its table there.
        fixed_effects: corrections that the configuration already carries.
    """

    forward: Forward
    calibratable: tuple[BaseParameter, ...]
    train: tuple[Booleans, ...]
    modulus: Mapping[int, float]
    natural: Mapping[int, float]
    stock: Mapping[int, tuple[str, NotchedTube]]
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

    @property
    def free(self) -> int:
        """How many of them the base model has by itself."""
        return sum(parameter.quantity != "spread" for parameter in self.base)

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
        return {p.key: float(np.exp(c)) if p.logarithmic else c for p, c in pairs if p.quantity != "spread"}

    def spreads(self, coordinates: FloatArray) -> dict[int, float]:
        """Return by tube number by how much its end effect differs from the table's, as a share of it."""
        pairs = zip(self.base, coordinates.tolist(), strict=True)
        return {p.tubes[0]: c for p, c in pairs if p.quantity == "spread"}

    def corrected_tubes(
        self, coordinates: FloatArray, effects: Sequence[ShapeEffect]
    ) -> dict[str, float | list[float]]:
        """Return what effects change in the tubes as numbers of the configuration, by key: depths, and extra cut lengths.

        Effects that are ``of_stock`` are in these numbers; the others are not.
        """
        spread, found = self.spreads(coordinates), {}
        for number, (key, tube) in self.stock.items():
            whole = rest = tube
            for effect in in_order((*self.fixed_effects, *effects)):
                if effect.acts_on(number):
                    whole = effect.spread(spread.get(number, 0.0)).geometry(whole)
                    stays = effect in self.fixed_effects or not effect.of_stock
                    rest = effect.geometry(rest) if stays else rest
            if np.any(whole.depth != rest.depth):
                found[f"{key}.depth_mm"] = _number((tube.depth + whole.depth - rest.depth) / MILLIMETRE)
            # What is left to corrections multiplies the length that bends.
            factor = (rest.cut + rest.end_length) / (tube.cut + tube.end_length)
            extra = (whole.cut + whole.end_length) / factor - tube.cut
            if np.any(np.abs(extra - tube.end_length) > 1e-9 * tube.cut):
                found[f"{key}.end_effect"] = _number(np.maximum(extra, 0.0) / MILLIMETRE)
        return found

    @property
    def carried(self) -> set[str]:
        """Effects that the configuration already has, in its corrections or in the tubes themselves."""
        found = {effect.id for effect in self.fixed_effects}
        if any(np.any(np.asarray(tube.end_length) > 0.0) for _, tube in self.stock.values()):
            found.add("notch_end_effect")
        return found

    def state(self, coordinates: FloatArray, effects: Sequence[ShapeEffect]) -> State:
        """Return one set of parameters."""
        modulus, natural, spread = dict(self.modulus), dict(self.natural), {}
        for parameter, value in zip(self.base, coordinates.tolist(), strict=True):
            for tube in parameter.tubes:
                if parameter.quantity == "modulus":
                    modulus[tube] = float(np.exp(value)) * GIGAPASCAL
                elif parameter.quantity == "curvature":
                    natural[tube] = value
                else:
                    spread[tube] = value
        return State(modulus, natural, (*self.fixed_effects, *effects), spread)

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
            index
            for index, photograph in enumerate(self.photographs)
            if (photograph.is_pair or not effect.on_pairs)
            and any(effect.acts_on(number) for number, _ in photograph.tubes)
        ]

    def touched_by_base(self, place: int, effects: Sequence[ShapeEffect]) -> list[int]:
        """Return the photographs that a base parameter changes, where these effects take part."""
        if self.base[place].quantity == "spread" and not any(getattr(effect, "by_tube", 0.0) for effect in effects):
            return []
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
        calibratable=(
            *_moduli(config, seen),
            *_curvatures(config, alone, natural, {n: t.length for n, t in tubes.items()}),
            *_spreads({number: tubes[number].name for number in sorted(alone)}),
        ),
        train=tuple(np.ones(len(run), dtype=bool) for run in runs),
        modulus={number: tube.youngs_modulus for number, tube in tubes.items()},
        natural=natural,
        stock={
            number: (f"{'outer' if number <= len(design.outer) else 'middle'}.samples.{tube.name}", tube)
            for number, tube in tubes.items()
        },
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
            found.append(BaseParameter(key, given.value, given.min, given.max, prior, tuple(numbers), "modulus"))
        else:
            low, high = max(given / _MODULUS_RANGE, 0.001), min(given * _MODULUS_RANGE, 1e4)
            found.append(BaseParameter(key, given, low, high, _MODULUS_PRIOR, tuple(numbers), "modulus"))
    return found


def _curvatures(
    config: Config, alone: set[int], natural: Mapping[int, float], lengths: Mapping[int, float]
) -> list[BaseParameter]:
    outer = 0 if config.outer is None else len(config.outer.samples)
    found = []
    for number in sorted(alone):
        role, stock, place = (
            ("outer", config.outer, number - 1) if number <= outer else ("middle", config.middle, number - 1 - outer)
        )
        name = "" if stock is None else stock.samples[place].name
        value = natural[number]
        prior = max(_CURVATURE_PRIOR * abs(value), _CURVATURE_TURN / lengths[number])
        reach = 8.0 * prior + abs(value)
        low, high = max(value - reach, -1000.0), min(value + reach, 1000.0)
        key = f"{role}.samples.{name}.natural_curvature_per_m"
        found.append(BaseParameter(key, value, low, high, prior, (number,), "curvature"))
    return found


def _number(values: FloatArray) -> float | list[float]:
    """Return one number where all notches have the same, else a list, one for each."""
    listed: list[float] = np.atleast_1d(values).tolist()
    return listed[0] if len(set(listed)) == 1 else listed


def _spreads(alone: Mapping[int, str]) -> list[BaseParameter]:
    """Return the spread of each tube's end effect; by one tube alone it is a part of the effect itself."""
    most = 2.0 * END_EFFECT_SPREAD
    return [
        BaseParameter(f"{name}.end_effect_spread", 0.0, -most, most, END_EFFECT_SPREAD, (number,), "spread")
        for number, name in alone.items()
        if len(alone) > 1
    ]
