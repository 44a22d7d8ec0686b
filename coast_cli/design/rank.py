"""Ranking of tube pairs: every outer with every middle tube, scored, and marked where no other pair is better in all.

Each of total pre-curvature, |ln(rigidity ratio)| and total rigidity is divided by an absolute reference; the score is the
weighted root of the sum of their squares, smaller is better, so the order of two pairs never depends on a third. All
pairs at once, in arrays, the middle tube slowest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.references import CHANGE, Reference, rank_references
from coast_cli.design.snapping import Snaps, snaps
from coast_cli.errors import UsageError
from coast_cli.mechanics.pairs import Assembly, PairTable, pair_table
from coast_cli.mechanics.section import FloatArray, SectionKind
from coast_cli.rows import Drawn, Rows, rows_of
from coast_cli.spec.build import Design, build
from coast_cli.spec.config import Config, JointFields
from coast_cli.units import DEGREE, MILLIMETRE

Rigidity = Literal["mean", "series"]
MOST_PAIRS = 2_000_000  # half a gigabyte
RIGIDITIES: tuple[Rigidity, ...] = get_args(Rigidity)


@dataclass(frozen=True)
class RankOptions:
    """How to rank: which rigidity, which assembly, which section for every tube (None: each its own), which weights."""

    rigidity: Rigidity = "mean"
    assembly: Assembly = "separate"
    section: SectionKind | None = None
    weights: tuple[float, ...] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Check the weights.

        Raises:
            UsageError: they are not three numbers from 0 with one above 0.
        """
        if len(self.weights) != 3 or min(self.weights) < 0.0 or max(self.weights) == 0.0:
            raise UsageError("weights: allowed: three numbers from 0, at least one of them above 0.")


@dataclass(frozen=True, repr=False)
class Ranking(Rows, Drawn):
    """The pairs in order; units are in the names of the columns.

    Attributes:
        columns: by name, each with one entry a pair, best first; figures of an impossible pair are None.
        notes: what the ranking leaves open, for the user.
        rigidity: which of the two the score is of.
    """

    columns: Mapping[str, Any]
    notes: tuple[str, ...]
    rigidity: Rigidity = "mean"

    def _table(self) -> list[dict[str, Any]]:
        return rows_of(self.columns)


def rank(config: Config, options: RankOptions | None = None) -> Ranking:
    """Rank every pair of a configuration; units are in the names of the columns.

    Args:
        config: with outer and middle tubes. options: which rigidity, assembly, section and weights.

    Raises:
        BadInput: there are not both outer and middle tubes, or more than `MOST_PAIRS` pairs.

    Example:
        >>> ranking = coast.rank(coast.load_config(coast.REFERENCE))
        >>> ranking.columns["outer"][0], ranking.columns["middle"][0]
        ('OT4', 'MT1')
    """
    options = options or RankOptions()
    for role in ("outer", "middle"):
        if getattr(config, role) is None:
            raise config.refuse((), f"a pair needs an outer and a middle tube, and there is no [{role}] table")
    design = with_section(build(config), options.section)
    count = len(design.outer) * len(design.middle)
    if count > MOST_PAIRS:
        raise config.refuse(
            ("outer",),
            "too many pairs to rank at once",
            found=count,
            allowed=f"up to {MOST_PAIRS}",
            hint="`coast explore` goes through any number.",
        )
    pairs = pair_table(design.outer, design.middle, design.gravity, options.assembly)
    reasons = _reasons(design, pairs)
    possible = reasons == ""
    references = rank_references(config)
    units = np.array([reference.value for reference in references])
    scores = {rigidity: _scores(pairs, (rigidity, options.weights, units), possible) for rigidity in RIGIDITIES}
    order = np.argsort(scores[options.rigidity], kind="stable")
    changed = [_scores(pairs, (options.rigidity, options.weights, units * f), possible) for f in _changes()]
    margins = _margins(*(table[order] for table in (scores[options.rigidity], *changed)))
    columns = _columns(design, pairs, reasons, (scores[options.rigidity], margins), options.rigidity, order)
    columns |= _snap_columns(None if _uneven(design) else snaps(design), possible, order)
    return Ranking(columns, _notes(design, options.rigidity, scores, columns, references), options.rigidity)


def pareto(costs: FloatArray) -> NDArray[np.bool_]:
    """Return which rows of ``costs``, shape (n, 3), no other row matches in every column and beats in one.

    In lexicographic order of distinct rows, a row is dominated exactly where an earlier one is as low in the second and
    third column. Each earlier row lies, at one level of halving, in the left half of a block whose right half holds the
    later one; a level is one running minimum over all blocks (Kung, Luccio and Preparata, 1975).
    """
    sorted_rows = np.lexsort(costs.T[::-1])
    distinct = np.append(True, np.any(np.diff(costs[sorted_rows], axis=0) != 0.0, axis=1))[: len(costs)]
    rows = costs[sorted_rows[distinct]]
    count = len(rows)
    third = np.unique(rows[:, 2], return_inverse=True)[1]
    by_second = np.argsort(rows[:, 1], kind="stable")
    dominated = np.zeros(count, dtype=bool)
    half = 1
    while half < count:
        block = by_second // (2 * half)
        # By block, then by the second column, then by row: numpy sorts whole numbers of two bytes in one pass.
        small = block.astype(np.min_scalar_type(count // (2 * half)))
        order = by_second[np.argsort(small, kind="stable")]
        in_right = order // half % 2 == 1
        # Each block's values lie below all of the block before, so one running minimum starts anew in each.
        offset = order // (2 * half) * (count + 1)
        lowest = np.minimum.accumulate(np.where(in_right, count, third[order]) - offset) + offset
        dominated[order] |= in_right & (lowest <= third[order])
        half *= 2
    found = np.empty(len(costs), dtype=bool)
    found[sorted_rows] = ~dominated[np.cumsum(distinct) - 1]
    return found


def with_section(design: Design, section: SectionKind | None) -> Design:
    """Return the design with one section for every tube, or as it is where none is given."""
    if section is None:
        return design
    outer, middle = (tuple(replace(tube, section=section) for tube in tubes) for tubes in (design.outer, design.middle))
    return replace(design, outer=outer, middle=middle)


def _costs(pairs: PairTable, rigidity: Rigidity) -> FloatArray:
    ratio, total = (
        (pairs.ratio_mean, pairs.total_mean) if rigidity == "mean" else (pairs.ratio_series, pairs.total_series)
    )
    return np.stack([cost.ravel() for cost in (pairs.total_precurvature, np.abs(np.log(ratio)), total)], axis=1)


def _scores(
    pairs: PairTable, scoring: tuple[Rigidity, Sequence[float], FloatArray], possible: NDArray[np.bool_]
) -> FloatArray:
    """Return the score of each pair by a rigidity, weights and references, infinite for an impossible pair."""
    rigidity, weights, references = scoring
    return scores_of(np.where(possible[:, None], _costs(pairs, rigidity), np.nan), weights, references)


def scores_of(costs: FloatArray, weights: Sequence[float], references: Sequence[float] | FloatArray) -> FloatArray:
    """Return the score of each pair from its own costs alone, infinite where they are NaN.

    Args:
        costs: shape (pairs, k), or (pairs, k, m) for m benches.
        weights, references: of the k costs; a cost over its reference counts.
    """
    known = np.isfinite(costs)
    shape = (-1, *[1] * (costs.ndim - 2))
    scaled = np.where(known, costs, 0.0) / np.reshape(references, shape)
    return np.where(known.all(axis=1), np.sqrt((np.reshape(weights, shape) * scaled**2).sum(axis=1)), np.inf)


def _changes() -> FloatArray:
    """Return factors of the references: each in turn larger and smaller, the others as they are; shape (6, 3)."""
    return np.concatenate([1.0 + sign * CHANGE * np.eye(3) for sign in (1.0, -1.0)])


def _margins(score: FloatArray, *changed: FloatArray) -> dict[str, list[Any]]:
    """Return by how much each pair, in order, is ahead of the next, and whether it stays so with changed references."""
    last = np.append(~np.isfinite(score[1:]), True) if score.size else np.ones(0, dtype=bool)
    with np.errstate(invalid="ignore"):
        ahead = np.stack([np.append(np.diff(table), np.nan) for table in (score, *changed)])
    return {
        "margin": [None if end else float(gap) for end, gap in zip(last, ahead[0], strict=True)],
        "margin_stable": [
            None if end else bool(held) for end, held in zip(last, np.all(ahead > 0.0, axis=0), strict=True)
        ],
    }


def _reasons(design: Design, pairs: PairTable) -> NDArray[np.object_]:
    """Return why each pair cannot be assembled or solved, an empty string where it can."""
    outer_bore = np.array([tube.inner_radius for tube in design.outer])
    middle_radius = np.array([tube.outer_radius for tube in design.middle])
    middle_bore = np.array([tube.inner_radius for tube in design.middle])
    reasons = np.full((len(design.middle), len(design.outer)), "", dtype=object)
    reasons[~pairs.converged] = "the beam under gravity did not converge"
    if design.config.inner is not None:
        inner = design.config.inner.outer_diameter_mm / 2e3
        reasons[inner >= middle_bore, :] = "the inner tube does not go into the middle tube"
    reasons[middle_radius[:, None] >= outer_bore] = "the middle tube does not go into the outer tube"
    return reasons.ravel()


def _columns(
    design: Design,
    pairs: PairTable,
    reasons: NDArray[np.object_],
    scored: tuple[FloatArray, Mapping[str, list[Any]]],
    rigidity: Rigidity,
    order: NDArray[np.intp],
) -> dict[str, Any]:
    possible = reasons == ""
    best = np.zeros(order.size, dtype=bool)
    best[possible] = pareto(_costs(pairs, rigidity)[possible])
    number_outer = len(design.outer)
    outer = np.array([tube.name for tube in design.outer], dtype=object)
    middle = np.array([tube.name for tube in design.middle], dtype=object)

    shown = reasons.copy()
    shown[possible] = None

    def figure(values: NDArray[Any]) -> NDArray[Any]:
        known = values.ravel()[order]
        if not np.all(possible):
            known = known.astype(object)
            known[~possible[order]] = None
        return known

    return {
        "rank": np.arange(1, order.size + 1),
        "sample": np.char.add("S", (order + 1).astype(str)),
        "outer": outer[order % number_outer],
        "middle": middle[order // number_outer],
        "total_precurvature_rad": figure(pairs.total_precurvature),
        "signed_precurvature_rad": figure(pairs.signed_precurvature),
        "rigidity_ratio_mean": figure(pairs.ratio_mean),
        "rigidity_ratio_series": figure(pairs.ratio_series),
        "total_rigidity_mean_n_m2": figure(pairs.total_mean),
        "total_rigidity_series_n_m2": figure(pairs.total_series),
        "score": figure(scored[0]),
        **scored[1],
        "pareto": best[order],
        "leading_tube": figure(np.where(pairs.signed_precurvature > 0.0, "outer", "middle")),
        "probability_passing": [None] * order.size,
        "probability_first": [None] * order.size,
        "reason": shown[order],
    }


def _snap_columns(found: Snaps | None, possible: NDArray[np.bool_], order: NDArray[np.intp]) -> dict[str, Any]:
    """Return the nearer forecast of a jump for each pair, in order; nothing without a joint and its tendon."""
    names = ("snap_margin", "snap_by", "snap_stroke_mm", "snap_jump_deg")
    if found is None:
        return {name: [None] * order.size for name in names}
    by = np.where(found.by_roll, "roll", "crossing")
    by = np.where(found.margin < 1.0, by, None)  # type: ignore[call-overload]  # no value where neither is anywhere near
    columns = (found.margin, by, found.stroke / MILLIMETRE, found.jump / DEGREE)

    def shown(values: NDArray[Any]) -> list[Any]:
        known = values.ravel()[order].tolist()
        lacks = ~possible[order]
        return [
            None if off or value is None or value != value else value  # noqa: PLR0124 -- NaN is not itself
            for off, value in zip(lacks.tolist(), known, strict=True)
        ]

    return {name: shown(values) for name, values in zip(names, columns, strict=True)}


def _uneven(design: Design) -> bool:
    """Return whether the middle tube may bend alone, of which jumps are not forecast."""
    joint = design.config.joint
    return isinstance(joint, JointFields) and joint.outer_cover_mm is not None


def _notes(
    design: Design,
    rigidity: Rigidity,
    scores: Mapping[Rigidity, FloatArray],
    columns: Mapping[str, Any],
    references: Sequence[Reference],
) -> tuple[str, ...]:
    words = ", ".join(f"{one.name} {one.words} ({one.source})" for one in references)
    origin = design.config.rank.source if design.config.rank is not None else None
    notes = [*design.notes, *design.uncorrected, f"measured in: {words}{f'; {origin}' if origin else ''}."]
    if _uneven(design):
        notes.append("jumps are not forecast, as joint.outer_cover_mm lets the middle tube bend alone.")
    if not np.isfinite(scores[rigidity]).any():
        return (*notes, "no pair can be assembled.")
    if columns["margin"][0] is not None:
        stays = "stays first" if columns["margin_stable"][0] else "does not stay first"
        notes.append(
            f"{columns['sample'][0]} is {columns['margin'][0]:.3g} ahead of {columns['sample'][1]}, and {stays} before it "
            f"where any one of these references changes by {100.0 * CHANGE:g} %."
        )
    other: Rigidity = "series" if rigidity == "mean" else "mean"
    first = {name: int(np.argmin(scores[name])) for name in RIGIDITIES}
    if first[other] == first[rigidity]:
        notes.append(f"by {other} rigidity the same pair ranks first.")
    else:
        middle, outer = divmod(first[other], len(design.outer))
        name = f"{design.outer[outer].name}/{design.middle[middle].name}"
        notes.append(f"by {other} rigidity another pair, S{first[other] + 1} ({name}), ranks first.")
    margin = columns["snap_margin"][0]
    if margin is not None and margin < 0.0:
        notes.append(
            f"the first pair is forecast to jump by {columns['snap_by'][0]} at {columns['snap_stroke_mm'][0]:.4g} mm of stroke."
        )
    if columns["leading_tube"][0] == "outer":
        notes.append("the outer tube leads the first pair: snapping was seen where it does.")
    return tuple(notes)
