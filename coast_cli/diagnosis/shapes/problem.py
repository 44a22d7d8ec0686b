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
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.noise_model import NoiseBank, nearest_colour
from coast_cli.diagnosis.problem import Channel, Contender, Effort, Variant
from coast_cli.diagnosis.shapes.forward import Forward, Job, State, missed_by
from coast_cli.diagnosis.shapes.photograph import Photograph
from coast_cli.diagnosis.space import (
    BaseParameter,
    Booleans,
    Coordinate,
    ParameterSpace,
    Point,
    configured_coordinates,
)
from coast_cli.diagnosis.thresholds import (
    EFFECT_NATS,
    ENOUGH_EXPLAINED,
    SMALLEST,
    SMALLEST_PART,
)
from coast_cli.effects.catalogue import effects_of, in_order
from coast_cli.effects.effect import RecordingKind, acting, declared
from coast_cli.effects.shape_stages import OnPair, OnShapes, Photographed
from coast_cli.effects.stages import OnTubes
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.recordings.noise import NoiseEstimate
from coast_cli.units import GIGAPASCAL, MILLIMETRE

_REACH = 8.0  # prior widths that one step of a fit may go


_EFFORT = Effort(
    fitted=(9, 4),
    finished=(9, 4),
    starts=1,
    steps=4,
    far_behind=25.0,
    least_gain=1.0,
    least_share=0.2,
    enough=ENOUGH_EXPLAINED,
    exchanges=True,
)
_LOOSENED = 0.3
_REMEMBERED = 4096


@dataclass(frozen=True)
class TubeParameter(BaseParameter):
    """A free number of the base model by its key in the file, e.g. ``materials.nitinol.youngs_modulus_gpa``.

    Attributes:
        tubes: numbers of the tubes it belongs to. quantity: a spread is that of a tube's end effect, and no key of a file.
    """

    tubes: tuple[int, ...] = ()
    quantity: Literal["modulus", "curvature", "spread"] = "modulus"


@dataclass(frozen=True)
class ShapeProblem:
    """Photographs, ready to be fitted.

    Attributes:
        forward: the model. calibratable: numbers that photographs can free. train: which points of each are fitted, (n,).
        modulus, natural: Pa, and natural curvature towards its own side, 1/m, as configured, by tube number.
        stock: every tube of the configuration, photographed or not, by its number, with its table there.
        fixed_effects: corrections that the configuration already carries.
        noise: of the points, m, generous by its own uncertainty. concealed: ids of effects that are neither named nor rivals.
        estimate: of the noise; None before it is made.
    """

    forward: Forward
    calibratable: tuple[TubeParameter, ...]
    train: tuple[Booleans, ...]
    modulus: Mapping[int, float]
    natural: Mapping[int, float]
    stock: Mapping[int, tuple[str, NotchedTube]]
    fixed_effects: tuple[OnShapes, ...]
    noise: float = 1e-4
    concealed: frozenset[str] = frozenset()
    estimate: NoiseEstimate | None = None

    @property
    def level(self) -> float:
        """The noise of the points itself, m."""
        return self.noise if self.estimate is None else max(self.estimate.level, 1e-15)

    @property
    def correlation(self) -> float:
        """Of the noise between neighbouring points."""
        return 0.0 if self.estimate is None else self.estimate.correlation

    @property
    def colour(self) -> int:
        """The noise model's colour that is nearest to that of the points."""
        return 0 if self.estimate is None else nearest_colour(self.estimate)

    @property
    def doubt(self) -> float:
        """Standard deviation of the logarithm of the noise."""
        return 0.0 if self.estimate is None else float(np.nan_to_num(self.estimate.log_level_std, posinf=10.0))

    @property
    def recording(self) -> RecordingKind:
        """Which side of an effect shows."""
        return "shapes"

    @property
    def photographs(self) -> tuple[Photograph, ...]:
        """The photographs."""
        return self.forward.photographs

    @cached_property
    def base(self) -> tuple[TubeParameter, ...]:
        """The free parameters: of tubes that are fitted; those of tubes held out stay as configured."""
        pairs = zip(self.photographs, self.train, strict=True)
        fitted = {number for photograph, train in pairs if train.any() for number, _ in photograph.tubes}
        return tuple(parameter for parameter in self.calibratable if fitted & set(parameter.tubes))

    @property
    def free(self) -> int:
        """How many of them the base model has by itself."""
        return sum(parameter.quantity != "spread" for parameter in self.base)

    @cached_property
    def scene(self) -> Photographed:
        """What there is to choose starts from."""
        tubes = {number: tube for photograph in self.photographs for number, tube in photograph.tubes}
        mass = max(float(t.segments.weight @ t.segments.length) for t in tubes.values())
        return Photographed(
            tubes={number: tubes[number].name for number in sorted(tubes)},
            alone=frozenset(photograph.tubes[0][0] for photograph in self.photographs if not photograph.is_pair),
            length=max(photograph.length for photograph in self.photographs),
            weight=max(mass * self.forward.gravity, 1e-12),
            mass=max(mass, 1e-12),
            pairs=any(photograph.is_pair for photograph in self.photographs),
            natural=max((abs(self.natural[number]) for number in tubes), default=0.0),
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
        return configured_coordinates(self.base)

    def values(self, coordinates: FloatArray) -> dict[str, float]:
        """Return the base parameters by key, in the unit of the file."""
        pairs = zip(self.base, coordinates.tolist(), strict=True)
        return {p.name: p.outer(c) for p, c in pairs if p.quantity != "spread"}

    def spreads(self, coordinates: FloatArray) -> dict[int, float]:
        """Return by tube number by how much its end effect differs from the table's, as a share of it."""
        pairs = zip(self.base, coordinates.tolist(), strict=True)
        return {p.tubes[0]: c for p, c in pairs if p.quantity == "spread"}

    def corrected_tubes(self, coordinates: FloatArray, effects: Sequence[OnShapes]) -> dict[str, float | list[float]]:
        """Return what effects change in the tubes as numbers of the configuration, by key: depths, and extra cut lengths.

        Effects that are ``of_stock`` are in these numbers; the others are not.
        """
        spread, found = self.spreads(coordinates), {}
        for number, (key, tube) in self.stock.items():
            whole = rest = tube
            for effect in acting(in_order((*self.fixed_effects, *effects)), OnTubes):
                if effect.acts_on(number):
                    whole = effect.differing(spread.get(number, 0.0)).geometry(whole)
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

    def state(self, coordinates: FloatArray, effects: Sequence[Any]) -> State:
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

    def residuals(self, points: Sequence[Point]) -> list[FloatArray]:
        """Return the fitted residuals at each point, recorded less predicted, m; beams that are known are not solved again."""
        wanted = [self._jobs(coordinates, effects) for coordinates, effects in points]
        fresh = {key: job for jobs in wanted for key, job in jobs if key not in self._known}
        lines = self.forward.lines(list(fresh.values()))
        found: dict[tuple[object, ...], FloatArray] = {}
        for (key, (index, _)), line in zip(fresh.items(), lines, strict=True):
            across, along = missed_by(self.photographs[index], line)
            rows = self.rows[index]
            found[key] = np.concatenate((across[0][rows[0]], along[0][rows[1]]))
        parts = [[found[key] if key in found else self._known[key] for key, _ in jobs] for jobs in wanted]
        if len(self._known) + len(found) > _REMEMBERED:
            self._known.clear()
        self._known.update(found)
        return [np.concatenate(one) for one in parts]

    @cached_property
    def _known(self) -> dict[tuple[object, ...], FloatArray]:
        """Residuals of photographs by what they depend on."""
        return {}

    def _jobs(self, coordinates: FloatArray, effects: Sequence[Any]) -> list[tuple[tuple[object, ...], Job]]:
        """Return for each photograph what its line depends on, and the state that gives it."""
        state = self.state(coordinates, effects)
        found: list[tuple[tuple[object, ...], Job]] = []
        for index, photograph in enumerate(self.photographs):
            acting = tuple(effect for effect in state.effects if _touches(effect, photograph))
            by_tube = any(getattr(effect, "by_tube", 0.0) for effect in acting)
            numbers = tuple(
                (n, state.modulus[n], state.natural[n], state.spread.get(n, 0.0) if by_tube else 0.0)
                for n, _ in photograph.tubes
            )
            found.append(((index, numbers, acting), (index, replace(state, effects=acting))))
        return found

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Where points miss the line, across it and, of those whose place is known, along it."""
        return (Channel(slice(0, self.size), self.bank, self.noise, _LOOSENED),)

    @property
    def effort(self) -> Effort:
        """How wide to search."""
        return _EFFORT

    @property
    def noise_floor(self) -> float:
        """The noise of the points, m."""
        return self.noise

    @property
    def misfit(self) -> float:
        """Factor on variances of parameters."""
        return 1.0

    def space(self, effects: Sequence[Any]) -> ParameterSpace:
        """Return what a fit of these effects moves; the spread of end effects pays where an effect lets tubes differ."""
        by_tube = any(getattr(effect, "by_tube", 0.0) for effect in effects)
        base = tuple(
            Coordinate(
                name=p.name,
                value=p.value,
                low=p.low,
                high=p.high,
                width=p.prior,
                scale=p.prior,
                mean=p.inner,
                reach=_REACH * p.prior,
                logarithmic=p.logarithmic,
                pays=by_tube and p.quantity == "spread",
            )
            for p in self.base
        )
        return ParameterSpace(base, tuple(effects), tuple(self._owned(effect) for effect in effects))

    def _owned(self, effect: OnShapes) -> tuple[Coordinate, ...]:
        found = []
        numbers = zip(effect.fitted(), effect.fitted_values(), effect.widths(self.scene).tolist(), strict=True)
        for p, value, width in numbers:
            found.append(
                Coordinate(
                    name=p.name,
                    value=float(value),
                    low=p.low,
                    high=p.high,
                    width=width,
                    scale=width,
                    mean=None if p.expected is None else p.expected[0],
                    null=float(np.log(value)) if p.logarithmic else p.null,
                    reach=_REACH * width,
                    logarithmic=p.logarithmic,
                )
            )
        return tuple(found)

    def candidates(self, parent: Sequence[Any]) -> list[Contender]:
        """Return what may be added to a set: of each effect the starts that let tubes differ stand by themselves."""
        taken = {effect.id for effect in parent} | self.carried | self.concealed
        found = []
        for kind in shape_effects():
            if kind.id in taken or (issubclass(kind, OnPair) and not self.scene.pairs):
                continue
            groups: dict[float, list[OnShapes]] = {}
            for start in kind.starts(self.scene):
                groups.setdefault(float(getattr(start, "by_tube", 0.0)), []).append(start)
            found += [
                Contender(tuple(starts), expected=declared(kind, "shapes").unlikely < 0.0) for starts in groups.values()
            ]
        return found

    def ordered(self, effects: Sequence[Any]) -> tuple[Any, ...]:
        """Return effects in the order in which they act."""
        return in_order(effects)

    def variant(self, effect: Any) -> Variant:  # noqa: ANN401
        """Return an effect's id, and the tube it sits on or whether tubes differ."""
        identifier, chosen = effect.variant
        return identifier, float(chosen)

    def two_sided(self, effect: Any) -> bool:  # noqa: ANN401
        """Return whether the effect can be turned round."""
        return not effect.one_sided()

    def scaled(self, effect: Any, amount: float) -> Any:  # noqa: ANN401
        """Return an effect made ``amount`` times as strong, inside its ranges."""
        return effect.scaled(amount)

    def prior_penalty_nats(self, effects: Sequence[Any]) -> float:
        """Return by how much a set starts behind; that tubes differ from what all have is one more thing to be believed."""
        chosen = sum(1 for effect in effects if getattr(effect, "tube", 0.0))
        penalty = chosen * float(np.log(max(len(self.scene.tubes), 1)))
        return penalty + float(
            sum(declared(e, "shapes").unlikely + EFFECT_NATS * getattr(e, "by_tube", 0.0) for e in effects)
        )

    def most_effects(self) -> int:
        """Return how many effects can be supported: as many as are asked for."""
        return len(shape_effects())

    def is_needed(self, larger: Fit, smaller: Fit, base: Fit) -> bool:
        """Return whether a larger set changes the shape enough, or the few residuals along it."""
        change = (larger.residual - smaller.residual) ** 2
        along = float(np.mean(change[self.along])) if self.along.any() else 0.0
        least = max(SMALLEST * larger.evidence.level, SMALLEST_PART * base.rmse)
        return float(np.sqrt(max(float(np.mean(change)), along))) >= least

    def only(self, train: Sequence[Booleans]) -> ShapeProblem:
        """Return the same with other points fitted."""
        return replace(self, train=tuple(train))


def shape_effects() -> list[type[OnShapes]]:
    """Return the effects that photographs can show, in the order in which they act."""
    return [kind for kind in effects_of("shapes").values() if issubclass(kind, OnShapes)]


def _touches(effect: OnShapes, photograph: Photograph) -> bool:
    """Return whether an effect changes a photograph."""
    if isinstance(effect, OnPair) and not photograph.is_pair:
        return False
    return any(effect.acts_on(number) for number, _ in photograph.tubes)


def _number(values: FloatArray) -> float | list[float]:
    """Return one number where all notches have the same, else a list, one for each."""
    listed: list[float] = np.atleast_1d(values).tolist()
    return listed[0] if len(set(listed)) == 1 else listed
