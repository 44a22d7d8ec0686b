"""The cells of the grammar that a recording can hold: stage x variable x memory, with the settings that are looked at."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.effects.effect import History
from coast_cli.effects.unnamed import Memory, Place, UnnamedLaw, Variable, basis, remember, rubbing, variable_of
from coast_cli.mechanics.section import FloatArray

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem

# What is looked at to first order, and then set free: plays as fractions of the drive's range, lags of a run's duration.
PLAYS = (0.02, 0.08, 0.25)
LAGS = (0.01, 0.03, 0.1, 0.3, 1.0)
MOST_PERIODS = 160
STEPS = 40
_FEWEST_CYCLES = 2.0
_SAMPLES_A_CYCLE = 6.0
_SPREADS = 0.02  # of its largest value, for a variable to be one
_TERMS = {"none": 8, "friction": 3, "relaxation": 2, "maximum": 3, "path": 3, "step": 1, "period": 2}


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell: ``play`` is the half width (in the drive's unit) at which friction is looked at to first order."""

    place: Place
    variable: Variable
    memory: Memory
    setting: float
    low: float
    high: float
    count: int
    play: float = 0.0

    @property
    def kind(self) -> tuple[Place, Variable, Memory]:
        """The cell without its setting."""
        return self.place, self.variable, self.memory

    def law(self, weights: FloatArray, limit: float, number: int = 1) -> UnnamedLaw:
        """Return the law with these amplitudes."""
        values = tuple(float(value) for value in weights)
        setting = self.play if self.memory == "friction" else self.setting
        return UnnamedLaw(self.place, self.variable, self.memory, setting, self.low, self.high, values, limit, number)


class Scene:
    """Variables of a recording as a model predicts them, at every row of every run.

    Args:
        problem: the recording. responses, tensions: of the model, for every run (n, k) and (n,).
    """

    def __init__(self, problem: JointProblem, responses: list[FloatArray], tensions: list[FloatArray]) -> None:
        self.problem, self.responses, self.tensions = problem, responses, tensions
        self.histories = [
            History(
                None if run.time is None else run.time - problem.first_time,
                run.stroke,
                run.tension if run.stroke is None else None,
                run.bending_length,
                run=index,
            )
            for index, run in enumerate(problem.runs)
        ]
        earlier: dict[str, float] = {}
        for index, run in enumerate(problem.runs):
            self.histories[index] = replace(self.histories[index], earlier_tension=earlier.get(run.pair, 0.0))
            largest = float(np.max(tensions[index], initial=0.0))
            earlier[run.pair] = max(earlier.get(run.pair, 0.0), largest)
        self.range = max(float(np.ptp(run.drive)) for run in problem.runs)
        self._kept: dict[tuple[str, str, int, int, int], FloatArray] = {}

    def series(self, variable: Variable, place: Place, memory: Memory, run: int, column: int) -> FloatArray:
        """Return a variable at every row of a run, SI, (n,)."""
        key = (variable, "sensor" if place == "sensor" else "", int(memory == "friction"), run, column)
        if key not in self._kept:
            self._kept[key] = self._series(variable, place, memory, run, column)
        return self._kept[key]

    def _series(self, variable: Variable, place: Place, memory: Memory, run: int, column: int) -> FloatArray:
        history, response = self.histories[run], self.responses[run]
        if variable == "position":
            pitch = self.pitch(run)
            return np.full(response.shape[0], (column + 0.5) * pitch)
        here = response[:, column]
        if place != "sensor":
            here = self.curvature(run, column)
        return variable_of(variable, history, self.tensions[run], here, memory)

    def pitch(self, run: int) -> float:
        """Return the mean pitch of a run's middle tube, m."""
        return float(np.mean(self.problem.joints[self.problem.runs[run].pair].middle.pitch))

    def curvature(self, run: int, column: int) -> FloatArray:
        """Return the curvature (1/m) that a response column stands for."""
        kind, response = self.problem.runs[run].kind, self.responses[run][:, column]
        if kind == "bend" and self.problem.device is None:
            return np.asarray(response / self.problem.runs[run].bending_length)
        return response / self.pitch(run) if kind == "notch" else response

    def remembered(self, cell: Cell, run: int, column: int) -> FloatArray:
        """Return the remembered variable of a cell at every row of a run, (n,)."""
        series = self.series(cell.variable, cell.place, cell.memory, run, column)
        return remember(series, self.histories[run], cell.memory, cell.setting)

    def block(self, cell: Cell, run: int, column: int) -> FloatArray:
        """Return what the cell's functions add at every row of a run, at unit amplitude, (n, k)."""
        remembered = self.remembered(cell, run, column)
        found = basis(remembered, cell.low, cell.high, cell.count, cell.memory, cell.setting, cell.place)
        if cell.memory != "friction":
            return found
        way = rubbing(self.histories[run], cell.play)
        sign = 1.0 if cell.place in ("structure", "transmission") else -1.0
        return np.asarray(sign * way[:, np.newaxis] * found)

    def extent(self, variable: Variable, place: Place, memory: Memory, setting: float) -> tuple[float, float] | None:
        """Return the range of a remembered variable over what is fitted, or None where it hardly varies."""
        lows, highs = [], []
        for run, column, rows in self.problem.sequences:
            if rows.size:
                series = self.series(variable, place, memory, run, column)
                seen = remember(series, self.histories[run], memory, setting)[rows]
                lows.append(float(seen.min()))
                highs.append(float(seen.max()))
        if not lows:
            return None
        low, high = min(lows), max(highs)
        return (low, high) if high - low > _SPREADS * max(abs(low), abs(high), 1e-300) else None


def cells_of(scene: Scene) -> Iterator[Cell]:
    """Yield every cell that the recording can hold; a device without tubes has a drive and a sensor only."""
    found = _cells_of(scene)
    return found if scene.problem.device is None else (cell for cell in found if cell.place in ("drive", "sensor"))


def _cells_of(scene: Scene) -> Iterator[Cell]:
    problem = scene.problem
    driven, clock = problem.runs[0].stroke is not None, problem.holds["time"]
    released, notches = problem.holds["release"], problem.runs[0].kind == "notch"
    drive: Variable = "stroke" if driven else "tension"
    smooth: list[tuple[Place, Variable]] = [
        ("drive", drive),
        ("structure", "curvature"),
        ("structure", "bending_length"),
        ("transmission", "bending_length"),
        ("transmission", "curvature"),
        ("sensor", "curvature"),
        ("sensor", drive),
        ("sensor", "bending_length"),
    ]
    smooth += [("tendon", "tension")] if driven else []
    smooth += [("structure", "position")] if notches else []
    if clock:
        smooth += [(place, "time") for place in ("drive", "structure", "transmission", "sensor")]
        smooth += [(place, "rate") for place in ("drive", "structure", "sensor")] if problem.holds["rates"] else []
    if problem.tension_noise is not None:
        smooth += [("load_cell", "tension"), ("load_cell", "time")] if clock else [("load_cell", "tension")]
    for place, variable in smooth:
        yield from _cells(scene, place, variable, "none", (0.0,))
    if released:
        plays = tuple(part * scene.range for part in PLAYS)
        rubbed: list[tuple[Place, Variable]] = [
            ("drive", drive),
            ("structure", "curvature"),
            ("transmission", "curvature"),
            ("sensor", "curvature"),
        ]
        rubbed += [("tendon", "tension")] if driven else []
        rubbed += [("drive", "time"), ("transmission", "time")] if clock else []
        rubbed += [("transmission", "rate")] if clock and problem.holds["rates"] else []
        for place, variable in rubbed:
            yield from _cells(scene, place, variable, "friction", plays)
    kept: list[tuple[Place, Variable]] = [("structure", "curvature"), ("drive", drive)]
    kept += [("tendon", "tension")] if driven else []
    for place, variable in (*kept, ("transmission", "curvature")):
        carried = (0.0, 1.0) if variable == "tension" and len(problem.runs) > 1 else (0.0,)
        yield from _cells(scene, place, variable, "maximum", carried)
    for place in ("drive", "structure", "sensor"):
        yield from _cells(scene, place, drive, "path", (0.0,))
    if clock:
        longest = max(float(np.ptp(run.time)) for run in problem.runs if run.time is not None)
        lags = tuple(part * longest for part in LAGS)
        for place, variable in (*kept, ("sensor", "curvature")):
            yield from _cells(scene, place, variable, "relaxation", lags)
        yield from _steps(scene)
        yield from _periods(scene, "time", ("drive", "structure", "sensor"))
    if driven:
        yield from _periods(scene, "stroke", ("drive", "structure", "sensor"))


def _cells(
    scene: Scene, place: Place, variable: Variable, memory: Memory, settings: tuple[float, ...]
) -> Iterator[Cell]:
    for setting in settings:
        kept = 0.0 if memory == "friction" else setting
        extent = scene.extent(variable, place, memory, kept)
        if extent is None:
            continue
        most = _TERMS[memory]
        if variable == "bending_length":
            lengths = np.unique(np.concatenate([run.bending_length for run in scene.problem.runs]).round(4))
            most = min(most, lengths.size)
        if variable in ("rate", "position"):
            most = 3
        play = setting if memory == "friction" else 0.0
        for count in sorted({1, min(2, most), min(5, most), most}):
            yield Cell(place, variable, memory, kept, *extent, count, play)


def _steps(scene: Scene) -> Iterator[Cell]:
    times = np.concatenate([h.time for h in scene.histories if h.time is not None])
    for moment in np.unique(np.quantile(times, (np.arange(STEPS) + 0.5) / STEPS)).tolist():
        for place in ("drive", "structure", "sensor"):
            yield Cell(place, "time", "step", moment, 0.0, 1.0, 1)


def _periods(scene: Scene, variable: Variable, places: tuple[Place, ...]) -> Iterator[Cell]:
    """Periods from half the range down to what the samples resolve, half a cycle of the range apart."""
    extent = scene.extent(variable, "drive", "none", 0.0)
    if extent is None:
        return
    span = extent[1] - extent[0]
    rows = max(len(run) for run in scene.problem.runs)
    finest = max(rows / _SAMPLES_A_CYCLE, 2.0 * _FEWEST_CYCLES)
    cycles = np.arange(_FEWEST_CYCLES, finest, 0.5)
    if cycles.size > MOST_PERIODS:
        cycles = np.geomspace(_FEWEST_CYCLES, finest, MOST_PERIODS)
    for count in cycles.tolist():
        for place in places:
            yield Cell(place, variable, "period", span / count, *extent, 2)
