"""A whole exploration: its blocks in order, the refinements of the front, and the front as rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.explore import (
    CHUNK,
    Block,
    Columns,
    costs_of,
    curvature_sources,
    explore_block,
    joint_pair_figures,
    refine,
    tasks,
)
from coast_cli.design.figures import FIGURES, POINT_FIGURES
from coast_cli.design.front import Front
from coast_cli.design.rank import Ranking, Rigidity, rank
from coast_cli.design.references import objective_scores
from coast_cli.design.space import KEYS
from coast_cli.design.work import results_in_order
from coast_cli.rows import Drawn, Rows
from coast_cli.spec.config import Config

Row = dict[str, Any]
Save = Callable[[Columns, Mapping[str, NDArray[Any]]], None]
_COUNTS = ("pairs", "impossible", "passing")
_CURVATURE_NOTE = (
    "natural curvature is that of the depth alone, linear between the measured samples; what cut, uncut and diameters do "
    "to it was not measured."
)


@dataclass(frozen=True)
class Beginning:
    """What an earlier, interrupted run has done: its blocks, and the state it saved with the last."""

    blocks: int = 0
    state: Mapping[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Exploration(Rows, Drawn):
    """The front of a design space.

    Attributes:
        config: whose space it is. rows: the pairs of the front, best score first; units are in the names.
        notes: how many pairs were tried, and what the front leaves open.
    """

    config: Config
    rows: tuple[Row, ...]
    notes: tuple[str, ...]

    def _table(self) -> tuple[Row, ...]:
        return self.rows

    @property
    def rigidity(self) -> Rigidity:
        """Which rigidity the objectives are of."""
        return "mean" if self.config.explore is None else self.config.explore.rigidity

    @property
    def bench(self) -> Ranking:
        """The pairs of the configuration itself, to see the front beside."""
        return rank(self.config)


def explore(
    config: Config,
    *,
    executor: tuple[Executor | None, int] = (None, 1),
    beginning: Beginning = Beginning(),  # it is frozen
    save: Save | None = None,
    advance: Callable[[], object] = lambda: None,
    every: bool = False,
    chunk: int = CHUNK,
) -> Exploration:
    r"""Pair every outer with every middle tube of the ``[explore]`` ranges and return the Pareto front; units are in the names.

    Args:
        config: as read, with an ``[explore]`` table; workers read its text anew.
        executor: from ``work.workers``. beginning: what an earlier run has done.
        save: takes the pairs of each block and the state that the next run must know.
        advance: called after every block and refinement. every: whether ``save`` wants the pairs, or the state alone.
        chunk: tubes of a role in one block.

    Raises:
        BadInput: no tube of the ranges can be made, or no pair of them goes together.

    Example:
        >>> text = coast.REFERENCE.read_text(encoding="utf-8")
        >>> space = "[explore]\ntubes = 4\nrefinements = 0\n[explore.outer]\ndepth_mm = { min = 0.35, max = 0.40 }\n"
        >>> found = coast.explore(coast.load_config_text(text + space))
        >>> len(found.rows) >= 1
        True
    """
    text = text_of(config)
    rounds = 0 if config.explore is None else config.explore.refinements
    blocks, front, counts = tasks(text, config.source, chunk, every=every), Front(), dict.fromkeys(_COUNTS, 0)
    if beginning.blocks:
        front, counts = _restored(beginning.state)
    for block in results_in_order(*executor, explore_block, blocks[beginning.blocks :]):
        _count(block, counts)
        front.add(block.costs, block.front)
        if save is not None:
            save(block.columns, _saved(front, counts))
        advance()
    if counts["pairs"] == 0:
        message = "the ranges hold no pair that can be made and assembled: walls, notch depths and nesting rule out all"
        raise config.refuse(("explore",), message)
    sampled = front.size
    tried = dict.fromkeys(_COUNTS, 0)
    for number in range(1, rounds + 1):
        for found in refine(text, config.source, front, number):
            _count(found, tried)
            front.add(found.costs, found.front)
        advance()
    return Exploration(config, tuple(_rows(config, text, front)), _notes(config, text, front, (counts, tried, sampled)))


def text_of(config: Config) -> str:
    """Return the text that a configuration was read from.

    Raises:
        BadInput: it was made in Python, and has none.
    """
    if not config.origin.text:
        raise config.refuse(
            (), "a design space is explored from the text of a configuration", allowed="one that was read"
        )
    return config.origin.text


def steps(config: Config) -> int:
    """Return how many blocks and refinements there are."""
    return len(tasks(text_of(config), config.source)) + (0 if config.explore is None else config.explore.refinements)


def _count(block: Block, counts: dict[str, int]) -> None:
    for name in _COUNTS:
        counts[name] += getattr(block, name)


def _saved(front: Front, counts: Mapping[str, int]) -> dict[str, NDArray[Any]]:
    known = {f"front.{name}": column for name, column in front.columns.items()}
    costs = {} if front.costs is None else {"costs": front.costs}
    return {
        "counts": np.array([counts[name] for name in _COUNTS]),
        "thinned": np.array(front.thinned),
        **costs,
        **known,
    }


def _restored(state: Mapping[str, NDArray[Any]]) -> tuple[Front, dict[str, int]]:
    known = {name.removeprefix("front."): column for name, column in state.items() if name.startswith("front.")}
    counts = dict(zip(_COUNTS, state["counts"].tolist(), strict=True))
    return Front(state.get("costs"), known, bool(state["thinned"])), counts


def _rows(config: Config, text: str, front: Front) -> list[Row]:
    if front.costs is None or front.size == 0:
        return []
    score = objective_scores(config, front.costs)
    order = np.lexsort((*front.costs.T, score))
    columns = {name: values[order] for name, values in front.columns.items() if not name.startswith("share_")}
    named: dict[str, Any] = {"pair": [f"E{number}" for number in range(1, front.size + 1)]}
    for role in ("outer", "middle"):
        for key in KEYS:
            values = columns[f"{role}_{key}"]
            named[f"{role}_{key}"] = values.astype(int).tolist() if key == "count" else values.tolist()
    named["natural_curvature"] = curvature_sources(text, config.source, columns).tolist()
    for name in (*FIGURES, *POINT_FIGURES):
        named[name] = columns[name].tolist() if name in columns else [None] * front.size
    named["score"] = score[order].tolist()
    named["dominates_joint_pair"] = _dominating(config, text, front.costs[order])
    return [dict(zip(named, values, strict=True)) for values in zip(*named.values(), strict=True)]


def _dominating(config: Config, text: str, costs: Any) -> list[bool | None]:  # noqa: ANN401
    known = joint_pair_figures(text, config.source)
    if known is None:
        return [None] * len(costs)
    own = costs_of(text, config.source, known[1])[0]
    better = np.all(costs <= own, axis=1) & np.any(costs < own, axis=1)
    return [bool(value) for value in better]


def _notes(
    config: Config, text: str, front: Front, counted: tuple[Mapping[str, int], Mapping[str, int], int]
) -> tuple[str, ...]:
    counts, tried, sampled = counted
    solved = f"{counts['pairs']} pairs solved, {counts['passing']} of them pass the checks"
    notes = [
        f"{solved}; {counts['impossible']} more cannot be made or assembled.",
        f"front: {sampled} pairs as sampled, {front.size} after {tried['pairs']} more were tried round it.",
        _CURVATURE_NOTE,
    ]
    if front.thinned:
        notes.append("the front grew too long: of near neighbours one stands for all.")
    known = joint_pair_figures(text, config.source)
    if known is not None and front.costs is not None:
        count = sum(bool(value) for value in _dominating(config, text, front.costs))
        objectives = ", ".join(config.explore.objectives) if config.explore else ""
        notes.append(
            f"{count} pairs of the front are better than {known[0]} in all of {objectives}."
            if count
            else f"no pair of these ranges is better than {known[0]} in all of {objectives}."
        )
    return tuple(notes)
