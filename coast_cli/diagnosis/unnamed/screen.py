"""Which law a residual asks for, in closed form, and how often noise alone would ask as loudly.

A law adds, to first order, its functions times what the model answers to one unit at its stage. Base parameters and those of
the effects already there follow to first order too. The evidence of every cell is that of a Bayesian linear model (MacKay,
Neural Computation 4 (1992) 415); its distribution under no law at all comes from noise of the recording's own level and
colour sent through the very same cells, so that the rate of false alarms is set and not hoped for.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.noise_model import nearest_colour
from coast_cli.diagnosis.unnamed.cells import Cell, Scene, cells_of
from coast_cli.diagnosis.unnamed.evidence import linear_evidence, orthonormal
from coast_cli.effects.effect import Effect, History, Segment
from coast_cli.effects.stages import OnBranches, OnDrive, OnLoadCell, OnSensor, OnStructure, OnTransmission
from coast_cli.effects.unnamed import Place
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem

DRAWS = 200
_LARGEST_SPREAD = 0.7  # of ln of the noise level, that a bootstrap draws
_PROBES: dict[Place, float] = {
    "drive": 1e-3,
    "tendon": 1e-3,
    "transmission": 1e-3,
    "structure": 1e-2,
    "sensor": 1.0,
    "load_cell": 1.0,
}


_STAGES: Mapping[Place, tuple[type[Effect], ...]] = {
    "drive": (OnDrive,),
    "tendon": (OnDrive,),
    "transmission": (OnTransmission, OnBranches),
    "structure": (OnStructure, OnBranches),
    "sensor": (OnSensor,),
    "load_cell": (OnLoadCell,),
}


@dataclass(frozen=True)
class Probe(OnDrive, OnTransmission, OnStructure, OnSensor, OnLoadCell):
    """One unit added at a stage, for derivatives."""

    place: Place
    amount: float

    id = "probe"
    title = component = equation = source = decided_by = ""
    stage = "structure"
    parameters = ()

    def acts_at(self, stage: type[Effect]) -> bool:
        """Return whether the probe acts at a stage: its own place alone."""
        return stage in _STAGES[self.place]

    def drive(self, history: History) -> History:
        """Add to the stroke (mm), or to the tension where that drives."""
        if history.stroke is not None:
            return replace(history, stroke=history.stroke + self.amount * MILLIMETRE)
        return replace(history, tension=history.drive + self.amount)

    def friction(self, direction: int, joint: Joint, bending_length: float) -> float:
        """Add to ln of the tension ratio."""
        return self.amount

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Add the moment of one 1/m."""
        return moment + self.amount * segment.rigidity

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Add to the response."""
        return response + self.amount

    def weigh(self, tension: FloatArray, history: History) -> FloatArray:
        """Add to the tension read."""
        return tension + self.amount


@dataclass(frozen=True, slots=True)
class Candidate:
    """A cell with its evidence (nats above no law) and the amplitudes that go with it, in its stage's unit."""

    cell: Cell
    evidence: float
    weights: FloatArray
    size: float

    def scale(self) -> float:
        """Return the largest amplitude."""
        return float(np.max(np.abs(self.weights), initial=1e-9))


@dataclass(frozen=True, slots=True)
class Screened:
    """Candidates, most evidence first, and what noise alone reaches.

    Attributes:
        evidence: the largest of any cell, nats. by_chance: the largest of each draw of noise alone, sorted, (b,).
    """

    candidates: tuple[Candidate, ...]
    by_chance: FloatArray

    @property
    def evidence(self) -> float:
        """The largest evidence of any cell, nats."""
        return self.candidates[0].evidence if self.candidates else 0.0

    @property
    def p_value(self) -> float:
        """How often noise alone asks as loudly for a law."""
        return float((1 + np.sum(self.by_chance >= self.evidence)) / (1 + self.by_chance.size))


def noise_colour(problem: JointProblem) -> int:
    """Return the noise model's colour that is nearest to what the recording itself shows."""
    return nearest_colour(problem.noise_estimate)


def screen_laws(problem: JointProblem, fitted: Fit, *, draws: int = DRAWS, seed: int = 0) -> Screened:
    """Return the laws that what a fit leaves asks for.

    Args:
        problem: whose fitted rows are looked at. fitted: base and effects that are there already.
        draws: of noise alone. seed: of them.
    """
    design = CellDesign(problem, fitted)
    rng = np.random.default_rng(seed)
    spread = min(float(np.nan_to_num(problem.noise_estimate.log_level_std, posinf=_LARGEST_SPREAD)), _LARGEST_SPREAD)
    noise = rng.standard_normal((design.size, draws)) * np.exp(spread * np.abs(rng.standard_normal(draws)))
    evidence, weights = design.evidence(np.column_stack([design.residual, noise]))
    order = np.argsort(-evidence[:, 0], kind="stable")
    candidates = tuple(
        Candidate(
            design.cells[i],
            float(evidence[i, 0]),
            weights[i],
            float(np.sqrt(np.mean(design.drawn(i, weights[i]) ** 2))),
        )
        for i in order
    )
    by_chance = np.sort(evidence[:, 1:].max(axis=0)) if len(design.cells) else np.zeros(draws)
    return Screened(candidates, by_chance)


class CellDesign:
    """Every cell's functions as columns over the fitted rows, whitened, with what other parameters follow taken out."""

    def __init__(self, problem: JointProblem, fitted: Fit) -> None:
        self.problem = problem
        self.colours = noise_colour(problem), fitted.evidences[-1].colour
        self.levels = (
            max(problem.noise_estimate.level, 1e-15),
            max(problem.tension_noise or 1.0, 1e-15),
        )
        predictions = problem.predict(fitted.coordinates, fitted.effects)
        self.origin = problem.fitted(predictions)
        scene = Scene(problem, [p.response for p in predictions], [p.tension for p in predictions])
        self.cells = list(cells_of(scene))
        gains = {place: self._gain(fitted, place) for place in {cell.place for cell in self.cells}}
        size = problem.observed.size
        self._basis = orthonormal(self.white((fitted.jacobian[:size], fitted.jacobian[size:])))
        residual = self.white(
            (
                (problem.observed - self.origin[0])[:, np.newaxis],
                (problem.observed_tension - self.origin[1])[:, np.newaxis],
            )
        )
        self.residual = self._rest(residual)[:, 0]
        self.size = self.residual.size
        blocks = [self._block(scene, cell, gains[cell.place]) for cell in self.cells]
        edges = np.cumsum([0, *(cell.count for cell in self.cells)])
        self._slices = [slice(int(a), int(b)) for a, b in itertools.pairwise(edges)]
        columns = np.concatenate([self.white(block) for block in blocks], axis=1) if self.cells else None
        self._columns = np.zeros((self.size, 0)) if columns is None else columns
        self._norms = np.sqrt(np.mean(self._columns**2, axis=0))
        self._columns = self._rest(self._columns)

    def white(self, parts: tuple[FloatArray, FloatArray]) -> FloatArray:
        """Return responses and tensions (n, k) as columns of unit white noise."""
        response = self.problem.bank.whiten(parts[0] / self.levels[0], self.colours[0])
        tension = self.problem.tension_bank.whiten(parts[1] / self.levels[1], self.colours[1])
        return np.concatenate([response, tension])

    def drawn(self, index: int, weights: FloatArray) -> FloatArray:
        """Return what a cell with these amplitudes adds to the whitened rows, what others can follow taken out, (n,)."""
        return np.asarray(self._columns[:, self._slices[index]] @ weights)

    def evidence(self, residuals: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
        """Return for residuals (n, b) the evidence of every cell, (c, b), and the amplitudes for the first of them."""
        return linear_evidence(self._columns, self._norms, self._slices, self._rest(residuals))

    def _rest(self, columns: FloatArray) -> FloatArray:
        return np.asarray(columns - self._basis @ (self._basis.T @ columns))

    def _gain(self, fitted: Fit, place: Place) -> tuple[FloatArray, FloatArray]:
        """Return what one unit at a stage adds to every fitted response and tension."""
        amount = _PROBES[place]
        moved = self.problem.fitted(self.problem.predict(fitted.coordinates, (*fitted.effects, Probe(place, amount))))
        sign = -1.0 if place == "tendon" else 1.0
        return sign * (moved[0] - self.origin[0]) / amount, sign * (moved[1] - self.origin[1]) / amount

    def _block(self, scene: Scene, cell: Cell, gain: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
        problem = self.problem
        response = _stacked([scene.block(cell, i, c)[rows] for i, c, rows in problem.sequences], cell.count)
        tension = _stacked([scene.block(cell, i, 0)[rows] for i, rows in problem.tension_sequences], cell.count)
        return response * gain[0][:, np.newaxis], tension * gain[1][:, np.newaxis]


def _stacked(parts: Sequence[FloatArray], count: int) -> FloatArray:
    return np.concatenate(parts) if parts else np.zeros((0, count))
