"""A pair as made, sample by sample: each with its own errors of manufacture, solved in blocks that are always alike.

The errors of a sample follow from the seed and its number alone, so the figures are the same bytes however the blocks are
shared out. What stays in memory are the figures; tubes and beams go with their block.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.figures import FIGURES, pair_columns
from coast_cli.design.limits import Limit, assembles, at_the_point, limits, point_figure_names
from coast_cli.design.variation import Variation, variation
from coast_cli.design.work import results_in_order
from coast_cli.mechanics.pairs import bent, listed_pairs
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import block_size
from coast_cli.spec.build import Design

BLOCK = 2048  # samples at most; fewer where tubes have many notches, so that memory is bounded
_COMPILED_BLOCK = 256  # samples whose tables stay in the cache; the kernel loses nothing by short rows
WORTH_COMPILING = 15_000_000  # notches of all samples, from which on the kernel of [fast] is worth its loading
Keep = Callable[[Mapping[str, FloatArray]], None]


@dataclass(frozen=True)
class Made:
    """Samples of one pair as made: its figures, shape (m,) each, NaN where the tubes are impossible or not solved."""

    columns: Mapping[str, FloatArray]
    limits: tuple[Limit, ...]

    @property
    def possible(self) -> NDArray[np.bool_]:
        """Whether each sample could be made, assembled and solved."""
        return np.isfinite(self.columns["total_precurvature_rad"])

    @property
    def passes(self) -> NDArray[np.bool_]:
        """Whether every check holds; an impossible pair does not pass."""
        held = [limit.holds(self.columns) for limit in self.limits]
        return np.asarray(np.logical_and.reduce([self.possible, *held]))


@dataclass(frozen=True)
class SampleTask:
    """One block of samples: of which design and pair, with which seed, the first of them and how many."""

    design: Design
    pair: tuple[str, str]
    seed: int
    first: int
    count: int
    compiled: bool


def samples_in_block(tubes: Iterable[NotchedTube]) -> int:
    """Return how many samples of tubes are solved at a time."""
    return block_size(sum(tube.count for tube in tubes), BLOCK)


def sampled(
    design: Design,
    pair: tuple[str, str],
    *,
    samples: int,
    seed: int,
    executor: tuple[Executor | None, int],
    beginning: Mapping[str, FloatArray],
    keep: Keep,
) -> Made:
    """Return the figures of random samples of a pair.

    Args:
        executor: from ``work.workers``. beginning: figures of the first samples, which an earlier run left behind.
        keep: takes the figures so far after every block, as views.
    """
    done = next((column.size for column in beginning.values()), 0)
    columns = {name: np.empty(samples) for name in _names(design)}
    for name, values in beginning.items():
        columns[name][:done] = values
    step = samples_in_block(design.tube(name) for name in pair)
    compiled = samples * sum(design.tube(name).count for name in pair) >= WORTH_COMPILING
    tasks = (
        SampleTask(design, pair, seed, first, min(step, samples - first), compiled)
        for first in range(done, samples, step)
    )
    for block in results_in_order(*executor, solve_block, tasks):
        count = block["total_precurvature_rad"].size
        for name, values in block.items():
            columns[name][done : done + count] = values
        done += count
        keep({name: column[:done] for name, column in columns.items()})
    return Made(columns, limits(design.config))


def solve_block(task: SampleTask) -> Mapping[str, FloatArray]:
    """Return the figures of one block of samples."""
    design, (outer, middle) = task.design, (task.design.tube(name) for name in task.pair)
    varied = variation(design.config, (outer, middle))
    draws = shares(task.seed, len(varied.inputs), task.first, task.count)
    return make_pairs(design, varied, (outer, middle), draws, compiled=task.compiled)


def shares(seed: int, inputs: int, first: int, count: int) -> FloatArray:
    """Return uniform random numbers, shape (count, inputs): rows ``first`` and on of the one table of a seed."""
    stream = np.random.PCG64(seed)
    stream.advance(first * inputs)
    return np.random.Generator(stream).random((count, inputs))


def make_pairs(
    design: Design,
    varied: Variation,
    tubes: tuple[NotchedTube, NotchedTube],
    draws: FloatArray,
    *,
    compiled: bool = False,
) -> Mapping[str, FloatArray]:
    """Return the figures of a pair for each row of probabilities, shape (m, inputs), block by block."""
    step = min(samples_in_block(tubes), _COMPILED_BLOCK if compiled else BLOCK)
    parts = [
        make_pair(design, varied, tubes, draws[first : first + step], compiled=compiled).columns
        for first in range(0, len(draws), step)
    ]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def make_pair(
    design: Design,
    varied: Variation,
    tubes: tuple[NotchedTube, NotchedTube],
    draws: FloatArray,
    *,
    compiled: bool = False,
) -> Made:
    """Return a pair as made for each row of probabilities, shape (m, inputs); ``compiled`` as for ``bent``."""
    outer, middle = (varied.tube(tube, draws) for tube in tubes)
    rows = np.flatnonzero(assembles(design.config, outer, middle))
    columns = {name: np.full(len(draws), np.nan) for name in _names(design)}
    if rows.size:
        outer, middle = outer.picked(rows), middle.picked(rows)
        roll = varied.roll(draws)[rows]
        solved = (
            bent(outer, design.gravity, roll=roll, compiled=compiled),
            bent(middle, design.gravity, compiled=compiled),
        )
        every = np.arange(rows.size)
        known = pair_columns(listed_pairs(*solved, (every, every))) | at_the_point(design, outer, middle)
        for name, values in known.items():
            columns[name][rows] = values
    return Made(columns, limits(design.config))


def _names(design: Design) -> Iterator[str]:
    yield from FIGURES
    yield from point_figure_names(design.config)
