"""The design space explored: every outer with every middle tube, block by block, then refined round its front.

A block is a function of the configuration's text and its number alone, so any process on any machine can do it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.figures import pair_columns
from coast_cli.design.front import Front
from coast_cli.design.limits import assembles, at_the_point, limits
from coast_cli.design.space import Space, space
from coast_cli.errors import NotConverged
from coast_cli.mechanics.pairs import BentTubes, bent, every_pair, listed_pairs
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tubes import Rows, Tubes, block_size, tubes_of
from coast_cli.spec.build import Design, build
from coast_cli.spec.config import Config
from coast_cli.spec.explore import Explore
from coast_cli.spec.load import load_config_text
from coast_cli.spec.tubes import Role

CHUNK = 128  # tubes of a role in one block
_KEPT_BYTES = 128e6  # of solved chunks of a role that a process keeps
_PARENTS, _CHILDREN = 128, 16  # of the front in one refinement, and the pairs tried round each
_FIRST_BOX, _SHRINKING = 0.25, 0.5  # width of the box as a share of each range, and its factor from round to round
ROLES: tuple[Role, ...] = ("outer", "middle")
Columns = dict[str, NDArray[Any]]
_FIGURE_OF = {
    "total_precurvature": "total_precurvature_rad",
    "rigidity_ratio": "rigidity_ratio_{}",
    "total_rigidity": "total_rigidity_{}_n_m2",
    "stroke": "stroke_mm",
    "tendon_strain": "tendon_strain",
    "web_strain": "web_strain",
    "notch_closure": "closure_curvature_per_m",
}


@dataclass(frozen=True)
class Task:
    """One block of pairs: the configuration as text, its file's name, tubes in a chunk, and which chunks meet.

    Attributes:
        every: whether the figures of every pair are wanted, or the front alone.
    """

    text: str
    name: str
    size: int
    outer: int
    middle: int
    every: bool


@dataclass(frozen=True)
class Block:
    """The pairs of one block, and its part of the front.

    Attributes:
        columns: of every pair that can be assembled, in order, where they are wanted; the number of each tube, its
            varied keys, figures, ``passes``.
        pairs, passing: how many pairs were solved, and how many of them pass the checks.
        costs, front: objectives of the passing pairs that no other of the block beats, and what is known of them.
        impossible: pairs that cannot be made or assembled, or whose beams were not solved.
    """

    columns: Columns
    costs: FloatArray
    front: Columns
    pairs: int
    passing: int
    impossible: int


def tasks(text: str, name: str, size: int = CHUNK, *, every: bool = True) -> list[Task]:
    """Return the blocks of a configuration in their order, of at most ``size`` tubes of a role."""
    found = _study(text, name)
    size = min(size, found.tubes_in_block(size))
    counts = [-(-len(found.shares(role)) // size) for role in ROLES]
    return [Task(text, name, size, one, two, every) for one in range(counts[0]) for two in range(counts[1])]


def explore_block(task: Task) -> Block:
    """Return the figures of one block."""
    study = _study(task.text, task.name)
    outer, middle = study.chunk("outer", task.outer, task.size), study.chunk("middle", task.middle, task.size)
    if outer.rows.size == 0 or middle.rows.size == 0:
        return _nothing(outer.size * middle.size)
    second, first = (index.ravel() for index in np.indices((middle.rows.size, outer.rows.size)))
    figures = pair_columns(every_pair(outer.bent, middle.bent))
    return study.block((outer, middle), (first, second), figures, outer.size * middle.size, every=task.every)


def refine(text: str, name: str, front: Front, round_number: int) -> Iterator[Block]:
    """Yield pairs tried in boxes round the front, half as wide in each round; none where nothing is to refine."""
    study = _study(text, name)
    axes = study.space.outer.axes + study.space.middle.axes
    if front.size == 0:
        return
    from scipy.stats import qmc

    order = np.lexsort((front.costs if front.costs is not None else np.zeros((0, 1))).T)
    parents = order[np.linspace(0, order.size - 1, min(order.size, _PARENTS)).round().astype(int)]
    centre = np.stack([front.columns[f"share_{axis}"][parents] for axis in range(axes)], axis=1).astype(float)
    seed = study.space.explore.seed + 1000 * round_number
    moves = qmc.Sobol(axes, seed=seed).random(_PARENTS * _CHILDREN)[: len(parents) * _CHILDREN] - 0.5
    width = _FIRST_BOX * _SHRINKING ** (round_number - 1)
    shares = np.clip(np.repeat(centre, _CHILDREN, axis=0) + width * moves, 0.0, 1.0)
    step = study.tubes_in_block(len(shares))
    for first in range(0, len(shares), step):
        yield study.pairs(shares[first : first + step])


class _Study:
    """A configuration ready to be explored; a process keeps the last few it met."""

    def __init__(self, config: Config) -> None:
        self.config = config
        self.design: Design = build(config)
        self.space: Space = space(config)
        self.limits = limits(config)
        self._shares: dict[Role, FloatArray] = {}
        self._chunks: dict[tuple[Role, int, int], _Chunk] = {}

    def shares(self, role: Role) -> FloatArray:
        """Return the shares of every sampled tube of a role, like patterns together: a block then merges few pieces."""
        if role not in self._shares:
            part, explore = self.space.role(role), self.space.explore
            sampled = explore.sampling == "sobol" and part.axes > 0
            found = _sobol(part.axes, explore, role) if sampled else part.grid()
            values = part.values(found)
            self._shares[role] = found[np.lexsort([values[key] for key in ("uncut_mm", "cut_mm", "count")])]
        return self._shares[role]

    def tubes_in_block(self, most: int) -> int:
        """Return how many tubes of either role are solved at a time."""
        counts = [self.space.role(role).values(self.shares(role))["count"].max() for role in ROLES]
        return block_size(int(sum(counts)), most)

    def chunk(self, role: Role, number: int, size: int) -> _Chunk:
        """Return one chunk of a role, solved; some are kept: of the middle tubes, which come round, the first ones."""
        key = role, number, size
        if key not in self._chunks:
            rows = slice(number * size, (number + 1) * size)
            solved = self._solve(role, self.shares(role)[rows], number * size)
            most = max(1, int(_KEPT_BYTES / max(solved.bytes, 1)))
            mine = [other for other in self._chunks if other[0] == role]
            if len(mine) >= most:
                del self._chunks[mine[-1] if role == "middle" else mine[0]]
            self._chunks[key] = solved
        return self._chunks[key]

    def _solve(self, role: Role, shares: FloatArray, first: int) -> _Chunk:
        part = self.space.role(role)
        values = part.values(shares)
        tubes = part.tubes(values)
        rows = np.flatnonzero(tubes.possible)
        return self._chunk_of(tubes.picked(rows), values, shares, rows, first)

    def _chunk_of(
        self, tubes: Tubes, values: dict[str, FloatArray], shares: FloatArray, rows: Rows, first: int
    ) -> _Chunk:
        solved = bent(tubes, self.design.gravity) if rows.size else None
        known = {key: column[rows] for key, column in values.items()}
        return _Chunk(len(shares), first + rows, shares[rows], known, tubes, solved)

    def pairs(self, shares: FloatArray) -> Block:
        """Return the figures of pairs row by row; shares of the outer and then of the middle tube."""
        parts = shares[:, : self.space.outer.axes], shares[:, self.space.outer.axes :]
        values = self.space.outer.values(parts[0]), self.space.middle.values(parts[1])
        tubes = self.space.outer.tubes(values[0]), self.space.middle.tubes(values[1])
        rows = np.flatnonzero(tubes[0].possible & tubes[1].possible)
        if rows.size == 0:
            return _nothing(len(shares))
        outer, middle = (
            self._chunk_of(made.picked(rows), known, part, rows, 0)
            for made, known, part in zip(tubes, values, parts, strict=True)
        )
        every = np.arange(rows.size)
        figures = pair_columns(listed_pairs(outer.bent, middle.bent, (every, every)))
        return self.block((outer, middle), (every, every), figures, len(shares), every=False)

    def block(
        self,
        chunks: tuple[_Chunk, _Chunk],
        pairs: tuple[Rows, Rows],
        figures: dict[str, FloatArray],
        asked: int,
        *,
        every: bool,
    ) -> Block:
        """Return a block of pairs of two chunks: held to the limits, and its own front found."""
        outer, middle = (chunk.tubes.picked(row) for chunk, row in zip(chunks, pairs, strict=True))
        figures = figures | at_the_point(self.design, outer, middle)
        good = assembles(self.config, outer, middle) & np.isfinite(figures["total_precurvature_rad"])
        passes = np.logical_and.reduce([good, *(limit.holds(figures) for limit in self.limits)])
        front, rows = Front(), np.flatnonzero(passes)
        front.add(self.costs({name: column[rows] for name, column in figures.items()}), {"row": rows})
        best = front.columns.get("row", rows)
        known: Columns = {name: column[best] for name, column in figures.items()}
        first, second = (pair[best] for pair in pairs)
        for chunk, role, row in zip(chunks, ROLES, (first, second), strict=True):
            known |= {f"{role}_{key}": column[row] for key, column in chunk.values.items()}
        shares = np.concatenate((chunks[0].shares[first], chunks[1].shares[second]), axis=1)
        known |= {f"share_{axis}": column for axis, column in enumerate(shares.T)}
        costs = np.zeros((0, 1)) if front.costs is None else front.costs
        table = self._table(chunks, pairs, figures | {"passes": passes}, good) if every else {}
        solved = int(np.count_nonzero(good))
        return Block(table, costs, known, solved, rows.size, asked - solved)

    def _table(
        self,
        chunks: tuple[_Chunk, _Chunk],
        pairs: tuple[Rows, Rows],
        figures: Mapping[str, NDArray[Any]],
        good: NDArray[np.bool_],
    ) -> Columns:
        """Return the columns of every good pair, the numbers of its tubes and their varied keys first."""
        kept = [pair[good] for pair in pairs]
        table: Columns = {role: chunk.rows[row] + 1 for role, chunk, row in zip(ROLES, chunks, kept, strict=True)}
        for role, chunk, row in zip(ROLES, chunks, kept, strict=True):
            counted = ("count",) if self.space.role(role).tube.length_mm else ()
            table |= {f"{role}_{key}": chunk.values[key][row] for key in (*self.space.role(role).ranges, *counted)}
        return table | {name: column[good] for name, column in figures.items()}

    def costs(self, figures: Mapping[str, FloatArray]) -> FloatArray:
        """Return what each objective counts, shape (pairs, objectives); smaller is better."""
        explore = self.space.explore
        columns = []
        for objective in explore.objectives:
            values = figures[_FIGURE_OF[objective].format(explore.rigidity)]
            if objective == "rigidity_ratio":
                values = np.abs(np.log(values))
            columns.append(-values if objective == "notch_closure" else values)
        return np.stack(columns, axis=1)


@dataclass(frozen=True)
class _Chunk:
    """Tubes of one role that can be made: rows in the whole sample, shares, values in mm, and solved.

    Attributes:
        size: tubes asked for.
    """

    size: int
    rows: NDArray[np.int64]
    shares: FloatArray
    values: dict[str, FloatArray]
    tubes: Tubes
    solved: BentTubes | None

    @property
    def bytes(self) -> int:
        """Memory of the solved tubes, about."""
        return 0 if self.solved is None else 6 * self.solved.rigidity.nbytes

    @property
    def bent(self) -> BentTubes:
        """The solved tubes; asked for only where there are any."""
        if self.solved is None:
            raise NotConverged("no tube of this chunk can be made.")
        return self.solved


def _nothing(asked: int) -> Block:
    return Block({}, np.zeros((0, 1)), {}, 0, 0, asked)


def _sobol(axes: int, explore: Explore, role: Role) -> FloatArray:
    from scipy.stats import qmc

    sequence = qmc.Sobol(axes, seed=explore.seed + (0 if role == "outer" else 500))
    whole: FloatArray = sequence.random_base2((explore.tubes - 1).bit_length())
    return whole[: explore.tubes]


@lru_cache(maxsize=2)
def _study(text: str, name: str) -> _Study:
    return _Study(load_config_text(text, name))


def costs_of(text: str, name: str, figures: Mapping[str, FloatArray]) -> FloatArray:
    """Return the objectives of pairs from their figures; smaller is better."""
    return _study(text, name).costs(figures)


def joint_pair_figures(text: str, name: str) -> tuple[str, dict[str, FloatArray]] | None:
    """Return the configuration's own pair and its figures, or None where it names none of two tubes."""
    study = _study(text, name)
    pair = study.design.joint_pair
    if pair is None or "/" not in pair:
        return None
    outer, middle = (tubes_of([study.design.tube(tube)]) for tube in pair.split("/"))
    solved = bent(outer, study.design.gravity), bent(middle, study.design.gravity)
    return pair, pair_columns(every_pair(*solved)) | at_the_point(study.design, outer, middle)


def curvature_sources(text: str, name: str, columns: Columns) -> NDArray[np.str_]:
    """Return how well known the natural curvatures of a pair are: the worse of both tubes."""
    parts = _study(text, name).space
    order = ("measured", "interpolated", "held")
    found = [part.source({"depth_mm": columns[f"{part.role}_depth_mm"]}) for part in (parts.outer, parts.middle)]
    return np.array(
        [max(pair, key=order.index) for pair in zip(*(table.tolist() for table in found), strict=True)], dtype=str
    )
