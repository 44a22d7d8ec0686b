"""What tolerances do to a pair: distributions of its figures, the chance of every check, and what to tighten first.

Plain random samples, so that every probability carries its binomial interval.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.figures import FIGURES, POINT_FIGURES, pair_columns
from coast_cli.design.indices import sobol_indices_of
from coast_cli.design.limits import assembles, at_the_point, limits
from coast_cli.design.rank import RankOptions, scores_of
from coast_cli.design.references import rank_references
from coast_cli.design.samples import Keep, Made, make_pair, make_pairs, sampled, samples_in_block, shares
from coast_cli.design.variation import Variation, variation
from coast_cli.errors import NotConverged
from coast_cli.mechanics.pairs import BentTubes, bent, listed_pairs
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import Tubes
from coast_cli.spec.build import Design

Row = dict[str, Any]
INDEX_SAMPLES = 512  # the model runs (inputs + 2) times as often
_NO_EFFECT = 0.01  # total index; smaller ones are noise of the estimate
MOST_RANKED = 1000  # samples of the whole bench
_COLUMNS = (
    "kind",
    "name",
    "input",
    "nominal",
    "limit",
    "mean",
    "std",
    "low_90",
    "median",
    "high_90",
    "probability",
    "probability_low",
    "probability_high",
    "first_order",
    "total_effect",
)


def tolerance_rows(
    design: Design,
    pair: str | tuple[str, str],
    *,
    samples: int,
    seed: int,
    ranked: bool = True,
    index_samples: int = INDEX_SAMPLES,
    executor: tuple[Executor | None, int] = (None, 1),
    beginning: Mapping[str, FloatArray] = MappingProxyType({}),
    keep: Keep = lambda _: None,
) -> tuple[list[Row], tuple[str, ...], Mapping[str, FloatArray]]:
    """Return rows, notes and the sampled figures of one pair; units are in the names.

    Args:
        design: from ``build``. pair: ``OUTER/MIDDLE``, or both names.
        samples: of the pair. seed: of the random numbers. ranked: also sample the whole bench for the ranking.
        index_samples: base samples of the Sobol indices, a power of two.
        executor, beginning, keep: as for ``samples.sampled``.

    Raises:
        NotConverged: no sample of the pair can be assembled and solved.

    Example:
        >>> design = coast.build(coast.load_config(coast.REFERENCE))
        >>> rows, notes, sampled = coast.tolerance_rows(design, "OT4/MT1", samples=64, seed=0, ranked=False, index_samples=2)
        >>> sampled["total_precurvature_rad"].shape
        (64,)
    """
    if isinstance(pair, str):
        first, second = design.pair(pair)
        pair = (first or "", second)
    outer, middle = (design.tube(name) for name in pair)
    varied = variation(design.config, (outer, middle))
    made = sampled(design, pair, samples=samples, seed=seed, executor=executor, beginning=beginning, keep=keep)
    share = 1.0 - float(np.mean(made.possible))
    if share == 1.0:
        raise NotConverged(f"{'/'.join(pair)}: with these tolerances no sample can be assembled: give smaller ones.")
    nominal = make_pair(design, varied, (outer, middle), np.full((1, len(varied.inputs)), 0.5)).columns
    rows = [*_distributions(made, nominal), *_checks(made, nominal)]
    rows.append(_row("check", "impossible", **_probability(~made.possible)))
    if ranked:
        rows += _first_places(design, seed, min(samples, MOST_RANKED))
    indices, dropped = _indices(design, varied, (outer, middle), (index_samples, seed))
    notes = _notes(design, varied, share, dropped)
    return [*rows, *indices], notes, made.columns


def chances(
    design: Design, options: RankOptions, *, samples: int, seed: int
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return whether each pair (middle-major) passes all checks, and ranks first, in each sample; shape (pairs, samples).

    The bench is sampled as a whole: a tube has the same errors in every pair that it is part of.
    """
    bench = (*design.outer, *design.middle)
    varied, step = variation(design.config, bench), samples_in_block(bench)
    made = [
        _bench_as_made(design, options, varied, shares(seed, len(varied.inputs), first, min(step, samples - first)))
        for first in range(0, samples, step)
    ]
    passing, costs = (np.concatenate([block[index] for block in made], axis=-1) for index in (0, 1))
    scores = scores_of(costs, options.weights, [reference.value for reference in rank_references(design.config)])
    best = np.argmin(scores, axis=0)
    return passing.astype(bool), (np.arange(len(costs))[:, None] == best) & np.isfinite(scores)


def _bench_as_made(
    design: Design, options: RankOptions, varied: Variation, draws: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return for each pair and sample whether it passes all checks, and its costs, shape (pairs, 3, samples)."""
    config = design.config
    nominal = np.append(draws, np.full((1, draws.shape[1]), 0.5), axis=0)  # the last row, which is a tube
    roll = varied.roll(nominal)
    tubes = {tube.name: varied.tube(tube, nominal) for tube in (*design.outer, *design.middle)}
    solved = {tube.name: _solved(design, tubes[tube.name], roll) for tube in design.outer}
    solved |= {tube.name: _solved(design, tubes[tube.name], 0.0 * roll) for tube in design.middle}
    bounds = limits(config)
    every = np.arange(len(draws))
    tubes = {name: made.picked(every) for name, made in tubes.items()}
    costs, passing = [], []
    for two in design.middle:
        for one in design.outer:
            pair = tubes[one.name], tubes[two.name]
            possible = assembles(config, *pair)
            columns = pair_columns(listed_pairs(solved[one.name], solved[two.name], (every, every)))
            with np.errstate(invalid="ignore"):  # figures of impossible tubes, which do not pass
                columns |= at_the_point(design, *pair)
                ratio = np.abs(np.log(columns[f"rigidity_ratio_{options.rigidity}"]))
                held = [limit.holds(columns) for limit in bounds]
            passing.append(np.logical_and.reduce([possible, *held]))
            total = columns[f"total_rigidity_{options.rigidity}_n_m2"]
            cost = np.stack((columns["total_precurvature_rad"], ratio, total))
            costs.append(np.where(possible, cost, np.nan))
    return np.stack(passing), np.stack(costs)


def _solved(design: Design, made: Tubes, roll: FloatArray) -> BentTubes:
    """Solve tubes as made, in which the last stands in for each impossible one, which passes nothing anyhow."""
    rows = np.where(made.possible, np.arange(made.size), made.size - 1)
    return bent(made.picked(rows), design.gravity, roll=roll[rows])


def _first_places(design: Design, seed: int, samples: int) -> list[Row]:
    if len(design.outer) * len(design.middle) < 2:
        return []
    _, first = chances(design, RankOptions(), samples=samples, seed=seed)
    names = [f"{one.name}/{two.name}" for two in design.middle for one in design.outer]
    rows = [_row("first", name, **_probability(wins)) for name, wins in zip(names, first, strict=True) if wins.any()]
    return sorted(rows, key=lambda row: -row["probability"])


def _distributions(made: Made, nominal: Mapping[str, FloatArray]) -> list[Row]:
    rows = []
    for name in (*FIGURES, *POINT_FIGURES):
        if name in made.columns:
            values = made.columns[name][made.possible]
            low, median, high = np.quantile(values, (0.05, 0.5, 0.95)).tolist()
            facts = {"mean": float(values.mean()), "std": float(values.std()), "low_90": low, "median": median}
            rows.append(_row("figure", name, nominal=_known(nominal[name][0]), high_90=high, **facts))
    return rows


def _checks(made: Made, nominal: Mapping[str, FloatArray]) -> list[Row]:
    rows = [
        _row(
            "check",
            limit.check,
            input=limit.bound,
            nominal=_known(nominal[limit.figure][0]),
            limit=limit.limit,
            **_probability(limit.holds(made.columns)),
        )
        for limit in made.limits
    ]
    return [*rows, _row("check", "all", **_probability(made.passes))] if rows else []


def _indices(
    design: Design, varied: Variation, tubes: tuple[NotchedTube, NotchedTube], sequence: tuple[int, int]
) -> tuple[list[Row], int]:
    """Return rows of Sobol indices, the largest total first for each figure, and how many samples were replaced."""
    found = sobol_indices_of(lambda draws: make_pairs(design, varied, tubes, draws), len(varied.inputs), *sequence)
    rows = []
    for name, (first, total) in found.indices.items():
        order = [column for column in np.argsort(-total) if total[column] > _NO_EFFECT]
        rows += [
            _row("index", name, input=varied.inputs[k].name, first_order=float(first[k]), total_effect=float(total[k]))
            for k in order
        ]
    return rows, found.replaced


def _probability(hits: NDArray[np.bool_]) -> dict[str, float]:
    """Return a share with its 95 % interval (Wilson 1927)."""
    count, share, z = hits.size, float(np.mean(hits)), 1.959963984540054
    centre = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * float(np.sqrt(share * (1 - share) / count + z * z / (4 * count * count)))
    low, high = centre - half if share > 0.0 else 0.0, centre + half if share < 1.0 else 1.0
    return {"probability": share, "probability_low": low, "probability_high": high}


def _row(kind: str, name: str, **values: Any) -> Row:  # noqa: ANN401
    return {**dict.fromkeys(_COLUMNS), "kind": kind, "name": name, **values}


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _notes(design: Design, varied: Variation, share: float, dropped: int) -> tuple[str, ...]:
    notes = [*design.notes, *design.uncorrected]
    if design.config.tolerances is None:
        notes.append(
            "there is no [tolerances] table: OD +-0.007 and ID +-0.015 mm (drawn tube stock), depth +-0.01 mm (laser)."
        )
    if share > 0.0:
        notes.append(f"{100.0 * share:.3g} % of the samples cannot be made or assembled; they count as failing.")
    if dropped:
        notes.append(f"{dropped} impossible samples count as average in the Sobol indices.")
    if design.config.checks is not None and design.config.checks.min_snap_margin is not None:
        notes.append("checks.min_snap_margin is a forecast for tubes as drawn: no sample is held to it.")
    if not varied.inputs:
        notes.append("every tolerance is 0: nothing varies.")
    return tuple(notes)
