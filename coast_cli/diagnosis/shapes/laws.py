"""Laws without a name for shapes: which one the photographs ask for, how often noise alone would, and its fit.

As for joints: a closed-form screen of every cell (`unnamed.evidence`), the leading ones refitted with the base, and the points
that no fit saw decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from coast_cli.diagnosis.contest import Contest, Hypothesis
from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.thresholds import (
    LACK_OF_FIT,
    LAW_NATS,
    LAW_TIE,
    OWN_FORM_NATS,
    REFUSING_NATS,
)
from coast_cli.diagnosis.unnamed.evidence import linear_evidence, orthonormal
from coast_cli.effects.effect import Effect
from coast_cli.effects.unnamed_shape import Adds, ShapeLaw, ShapePlace
from coast_cli.mechanics.section import FloatArray

DRAWS = 200
_COUNTS = (1, 2, 4, 8)
_MOST_TERMS = {"curvature": 8, "compliance": 8, "force": 8, "height": 8}
# One unit of each law as it is looked at, in its own unit: small beside what bends a tube.
_UNIT = {"curvature": 0.3, "compliance": 0.05, "force": 0.02, "height": 1e-4}
_WAVES = (1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0)
_LARGEST_SPREAD = 0.7  # of ln of the noise level, that a draw has
_LIMIT = 20.0  # times the amplitude that the screen found
_REFITTED = 4
_LEAST_SHARE = 0.6  # of the leader's evidence, below which a cell is not refitted
# Where the names of shapes stand, for whether a law stands elsewhere.
_AT: dict[str, ShapePlace] = {
    "base_tilt": "environment",
    "tip_load": "environment",
    "clipped_weight": "environment",
    "gravity": "environment",
    "camera_scale": "camera",
    "camera_tilt": "camera",
    "lens_distortion": "camera",
}


@dataclass(frozen=True, slots=True)
class ShapeLawFit:
    """A law with what it leaves: nats that the fitted points say against it, its price included."""

    law: ShapeLaw
    fit: Fit
    surprise: float

    @property
    def kind(self) -> tuple[Adds, float, bool]:
        """What it adds, to which tube, and whether it is a wave."""
        return self.law.adds, self.law.tube, self.law.period > 0.0


@dataclass(frozen=True, slots=True)
class LawsAsked:
    """Laws with their evidence, most first; and how often noise alone asks as loudly."""

    laws: tuple[tuple[float, ShapeLaw], ...]
    p_value: float


def shape_cells(problem: ShapeProblem) -> Iterator[ShapeLaw]:
    """Yield every law at unit amplitudes that the photographs can hold, of as many terms as are looked at."""
    scene = problem.scene
    tubes = [0.0, *sorted(map(float, scene.alone))] if len(scene.tubes) > 1 else [0.0]
    for tube in tubes:
        for adds in ("curvature", "compliance") if not tube else ("curvature",):
            yield _unit(adds, scene.length, _MOST_TERMS[adds], tube)
    yield _unit("force", scene.length, _MOST_TERMS["force"])
    yield _unit("height", scene.length, _MOST_TERMS["height"])
    for waves in _WAVES:
        yield _unit("curvature", scene.length, 2, 0.0, scene.length / waves)


def _unit(adds: Adds, length: float, count: int, tube: float = 0.0, period: float = 0.0) -> ShapeLaw:
    return ShapeLaw(adds, length, (_UNIT[adds],) * count, tube, period)


def ask_for_laws(problem: ShapeProblem, fitted: Fit, *, draws: int = DRAWS, seed: int = 0) -> LawsAsked:
    """Return the laws that what a fit leaves asks for, and how often noise alone asks as loudly."""
    level, colour = problem.level, problem.colour
    bank = problem.bank
    whole = list(shape_cells(problem))
    points, owners = [], []
    for index, law in enumerate(whole):
        for term in range(len(law.weights)):
            weights = tuple(w if k == term else 0.0 for k, w in enumerate(law.weights))
            one = ShapeLaw(law.adds, law.high, weights, law.tube, law.period, number=9)
            points.append((fitted.coordinates, problem.ordered((*fitted.effects, one))))
            owners.append(index)
    here, *moved = problem.residuals([(fitted.coordinates, fitted.effects), *points])
    columns = bank.whiten(np.stack([(here - one) / level for one in moved], axis=1), colour)
    basis = orthonormal(bank.whiten(fitted.jacobian / level, colour))

    def rest(values: FloatArray) -> FloatArray:
        return np.asarray(values - basis @ (basis.T @ values))

    norms = np.sqrt(np.mean(columns**2, axis=0))
    starts = np.searchsorted(owners, np.arange(len(whole)))
    slices, shown = [], []
    for index, law in enumerate(whole):
        most = len(law.weights)
        for count in (2,) if law.period else [c for c in _COUNTS if c <= most]:
            slices.append(slice(int(starts[index]), int(starts[index]) + count))
            shown.append((law, count))
    rng = np.random.default_rng(seed)
    spread = min(problem.doubt, _LARGEST_SPREAD)
    noise = rng.standard_normal((here.size, draws)) * np.exp(spread * np.abs(rng.standard_normal(draws)))
    residuals = np.column_stack([bank.whiten(here / level, colour), noise])
    evidence, amplitudes = linear_evidence(rest(columns), norms, slices, rest(residuals))
    by_chance = evidence[:, 1:].max(axis=0)
    order = np.argsort(-evidence[:, 0], kind="stable").tolist()
    found = []
    for i in order:
        law, _ = shown[i]
        own = amplitudes[i] * _UNIT[law.adds]
        limit = _LIMIT * max(float(np.max(np.abs(own))), 1e-9)
        values = tuple(float(value) for value in own)
        found.append((float(evidence[i, 0]), ShapeLaw(law.adds, law.high, values, law.tube, law.period, limit)))
    p_value = (1 + int(np.sum(by_chance >= found[0][0]))) / (1 + draws)
    return LawsAsked(tuple(found), p_value)


@dataclass(frozen=True)
class ShapeWorld:
    """The contest's leader beside laws without a name."""

    problem: ShapeProblem
    contest: Contest

    @cached_property
    def asked(self) -> LawsAsked:
        """What the leading names leave to be explained."""
        return ask_for_laws(self.problem, self.contest.leading.fit)

    @property
    def is_complete(self) -> bool:
        """Whether noise alone asks as loudly for more as what the leading names leave."""
        return self.asked.p_value > LACK_OF_FIT

    @cached_property
    def laws(self) -> tuple[ShapeLawFit, ...]:
        """Laws in place of any name, as fitted with the base, least surprise first."""
        base = self.contest.base.fit
        asked = ask_for_laws(self.problem, base) if self.contest.leading.ids else self.asked
        found = []
        for _, law in _best_of_each(asked)[:_REFITTED]:
            fitted = fit(
                self.problem, self.problem.ordered((*base.effects, law)), base.coordinates, steps=6, until="fine"
            )
            mine = next(effect for effect in fitted.effects if isinstance(effect, ShapeLaw))
            found.append(ShapeLawFit(mine, fitted, self.surprise(fitted)))
        return tuple(sorted(found, key=lambda one: (one.surprise, one.kind)))

    def misfit(self, fitted: Fit) -> float:
        """Return the mean squared whitened residual of a fit on the fitted points, 1 at the noise."""
        white = self.problem.bank.whiten(fitted.residual / self.problem.level, self.problem.colour)
        return float(np.mean(white**2))

    def surprise(self, fitted: Fit) -> float:
        """Return what the fitted points say against a fit, and what its numbers cost, nats."""
        count = max(self.problem.size, 1)
        price = 0.5 * sum(len(effect.parameters) for effect in fitted.effects) * np.log(count)
        return float(0.5 * self.misfit(fitted) * count + price)

    def left_over(self, fitted: Fit) -> float:
        """Return what a fit leaves beyond the noise on the points that were fitted, in noise widths."""
        return float(np.sqrt(max(self.misfit(fitted) - 1.0, 0.0)))

    @cached_property
    def scale(self) -> float:
        """Variance that even the closest law leaves, in the noise's: nats count by it."""
        return max([1.0, *(self.misfit(law.fit) for law in self.laws[:1])])

    @cached_property
    def preferred(self) -> ShapeLawFit | None:
        """The law that stands in place of the leading names, or None where they stand."""
        leading = self.contest.leading
        if self.is_complete or not self.laws:
            return None
        best = self.laws[0]
        least = LAW_NATS
        if leading.ids:
            least = OWN_FORM_NATS if _stands_with(best.law, leading) else REFUSING_NATS
        return best if (self.surprise(leading.fit) - best.surprise) / self.scale > least else None

    def alike(self, law: ShapeLawFit) -> tuple[ShapeLaw, ...]:
        """Return the leading law and those that the photographs cannot tell from it."""
        close = [one.law for one in self.laws if one.surprise <= law.surprise + LAW_TIE * self.scale]
        return (law.law, *(one for one in close if one is not law.law))

    @cached_property
    def nearest(self) -> tuple[tuple[str, float], ...]:
        """Single names by what each leaves, in noise widths, least first."""
        found: dict[str, float] = {}
        for one in self.contest.tried:
            if len(one.ids) == 1:
                left = round(self.left_over(one.fit), 3)
                found[one.ids[0]] = min(left, found.get(one.ids[0], left))
        return tuple(sorted(found.items(), key=lambda one: (one[1], one[0]))[:3])


def _stands_with(law: ShapeLaw, leading: Hypothesis) -> bool:
    return any(_AT.get(identifier, "tube") == law.place for identifier in leading.ids)


def _best_of_each(asked: LawsAsked) -> Sequence[tuple[float, ShapeLaw]]:
    """Return the most promising law of each kind, most evidence first."""
    best: dict[tuple[Adds, float, bool], tuple[float, ShapeLaw]] = {}
    for evidence, law in asked.laws:
        if evidence >= _LEAST_SHARE * asked.laws[0][0]:
            best.setdefault((law.adds, law.tube, law.period > 0.0), (evidence, law))
    return list(best.values())


def names_of(effects: Sequence[Effect]) -> tuple[str, ...]:
    """Return the ids of effects that have a name."""
    return tuple(effect.id for effect in effects if not isinstance(effect, ShapeLaw))
