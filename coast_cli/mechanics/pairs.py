"""Two notched tubes as one: the curvature they settle on and the rigidity they have, equation (8) of P, for many pairs.

On a piece where both rigidities are constant the integral of (8) is the rigidity-weighted mean of the tubes' own turns,
so no quadrature is needed. Each tube is solved once. Tubes of one notch pattern share their pieces, so the pairs of two
patterns are one array of pairs by pieces; other pairs have pieces of their own. Blocks fit the processor's cache.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam import solve_alike_curvatures, solve_beams, solve_curvatures, solve_segments
from coast_cli.mechanics.plausible import MODULUS, require
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import Rows, Tubes
from coast_cli.rows import short_repr

Assembly = Literal["separate", "coupled"]

_BLOCK = 1 << 18  # pairs times pieces at once: two megabytes an array
_MERGED = 1 << 15  # the same where each pair has its own pieces, which takes more tables
_SOLVED = 1 << 19  # tubes times pieces solved at once
_WORTH_SHARING = 16  # pairs a group of patterns, from which on merging once is faster


@dataclass(frozen=True, slots=True)
class PairTable:
    """What pairs are ranked by, each of shape (middle tubes, outer tubes), or (pairs,) where they are listed.

    Attributes:
        total_precurvature: integral of |kappa_final| over the overlap, rad.
        signed_precurvature: integral of kappa_final, rad; positive where the outer tube leads.
        ratio_mean, ratio_series: rigidity of the outer over that of the middle tube, along the tube (P) or in series.
        total_mean, total_series: rigidity of both tubes together over the overlap, N m^2; in series it is the uniform
            pair that bends as far under one moment, a little more than the sum of the tubes' own series rigidities.
        converged: whether the beams beneath were solved.
    """

    __repr__ = short_repr

    total_precurvature: FloatArray
    signed_precurvature: FloatArray
    ratio_mean: FloatArray
    ratio_series: FloatArray
    total_mean: FloatArray
    total_series: FloatArray
    converged: NDArray[np.bool_]


@dataclass(frozen=True)
class BentTubes:
    """Solved tubes: rows of length (m), rigidity (N m^2) and mass per length (kg/m) of every piece, shape (m, p).

    Attributes:
        angle: of the piece ends, rad, shape (m, p + 1). natural_curvature: in the plane, 1/m; across: out of it, (m,).
        rigidity_mean, rigidity_series: of each tube, N m^2. converged: whether each was solved, (m,).
    """

    length: FloatArray
    rigidity: FloatArray
    weight: FloatArray
    angle: NDArray[Any]
    natural_curvature: FloatArray
    across: FloatArray
    rigidity_mean: FloatArray
    rigidity_series: FloatArray
    converged: NDArray[np.bool_]

    @property
    def size(self) -> int:
        """Number of tubes."""
        return len(self.length)

    @cached_property
    def ends(self) -> FloatArray:
        """End of every piece from the clamp, m."""
        return np.cumsum(self.length, axis=1)

    @cached_property
    def moment(self) -> FloatArray:
        """Rigidity times curvature of every piece, N m."""
        return self.rigidity * np.diff(self.angle, axis=1) / np.where(self.length == 0.0, 1.0, self.length)

    @cached_property
    def patterns(self) -> list[Rows]:
        """The tubes, by index, in groups of one notch pattern."""
        groups: dict[bytes, list[int]] = {}
        for index, row in enumerate(self.length):
            groups.setdefault(row.tobytes(), []).append(index)
        return [np.array(group) for group in groups.values()]


def bent(tubes: Tubes, gravity: float, *, roll: FloatArray | float = 0.0, compiled: bool = False) -> BentTubes:
    """Solve every tube under gravity (m/s^2), right to 1e-9 of the largest curvature.

    Args:
        roll: of the natural curvature out of the plane of gravity, rad. The plane then sees its cosine; its sine bends
            across, where gravity does nothing to first order.
        compiled: as for ``solve_curvatures``.
    """
    length, rigidity, weight = tubes.pieces
    natural = np.broadcast_to(tubes.natural_curvature * np.cos(roll), tubes.size)
    most = int(tubes.count.max())
    alike = most if tubes.depth.shape[1] == 1 < most and np.all(tubes.count == most) else 0
    angle, converged = np.zeros((tubes.size, length.shape[1] + 1)), np.empty(tubes.size, dtype=bool)
    for part in _parts(tubes.size, length.shape[1], _SOLVED):
        if alike and not compiled:
            one, two, three = (column[part] for column in tubes.per_notch)
            solved = solve_alike_curvatures(one, two, three, natural[part], count=alike, gravity=gravity)
        else:
            columns = length[part], rigidity[part], weight[part], natural[part, None]
            solved = solve_curvatures(*columns, gravity=gravity, compiled=compiled)
        np.cumsum(solved.curvature * length[part], axis=1, out=angle[part, 1:])
        converged[part] = solved.converged
    return BentTubes(
        length=length,
        rigidity=rigidity,
        weight=weight,
        angle=angle,
        natural_curvature=natural,
        across=np.broadcast_to(tubes.natural_curvature * np.sin(roll), tubes.size),
        rigidity_mean=tubes.rigidity_mean,
        rigidity_series=tubes.rigidity_series,
        converged=converged,
    )


def pair_table(
    outer: Sequence[NotchedTube], middle: Sequence[NotchedTube], gravity: float, assembly: Assembly = "separate"
) -> PairTable:
    """Return the figures of every pair; gravity in m/s^2 along -y.

    Args:
        outer, middle: any numbers of tubes.
        assembly: "separate" puts each tube's own sag into (8) (P); "coupled" lets each pair sag as one beam of summed
            rigidities and weights, of which what the longer tube sticks out by hangs at the end.

    Raises:
        BadInput: a modulus that is far from any material.

    Example:
        >>> design = coast.build(coast.load_config(coast.REFERENCE))
        >>> table = coast.pair_table(design.outer, design.middle, design.gravity)
        >>> round(table.total_precurvature[0, 3].item(), 5)
        0.26257
    """
    require(MODULUS, youngs_modulus=[tube.youngs_modulus for tube in (*outer, *middle)])
    return every_pair(_bent_exactly(outer, gravity), _bent_exactly(middle, gravity), gravity, assembly)


def every_pair(outer: BentTubes, middle: BentTubes, gravity: float = 0.0, assembly: Assembly = "separate") -> PairTable:
    """Return the figures of every outer with every middle tube, shape (middle, outer); arguments as ``pair_table``."""
    shape = middle.size, outer.size
    if assembly == "separate" and (
        len(outer.patterns) * len(middle.patterns) * _WORTH_SHARING > middle.size * outer.size > _WORTH_SHARING
        or np.any(outer.across)
        or np.any(middle.across)
    ):
        second, first = (index.ravel() for index in np.indices(shape))
        return _shaped(listed_pairs(outer, middle, (first, second)), shape)
    made = _Columns(shape)
    converged = outer.converged & middle.converged[:, None]
    for ones in outer.patterns:
        for twos in middle.patterns:
            common = _Common(outer.length[ones[0]], middle.length[twos[0]])
            coupled = assembly == "coupled"
            pieces = common.of(outer, ones, 0, with_weight=coupled), common.of(middle, twos, 1, with_weight=coupled)
            for one, two in _blocks(ones.size, twos.size, common.length.size):
                here = np.ix_(twos[two], ones[one])
                parts = pieces[0].picked(one, np.s_[None, :]), pieces[1].picked(two, np.s_[:, None])
                if coupled:
                    sums, converged[here] = common.coupled_integrals(*parts, gravity)
                else:
                    sums = common.integrals(*parts)
                made.put(here, sums)
    return PairTable(
        **made.values,
        ratio_mean=outer.rigidity_mean / middle.rigidity_mean[:, None],
        ratio_series=outer.rigidity_series / middle.rigidity_series[:, None],
        converged=converged,
    )


def listed_pairs(outer: BentTubes, middle: BentTubes, rows: tuple[Rows, Rows]) -> PairTable:
    """Return the figures of listed pairs, each tube sagging by itself.

    Args:
        rows: which outer and which middle tube each pair takes, both of shape (pairs,).
    """
    first, second = rows
    made = _Columns((first.size,))
    if len(outer.patterns) == len(middle.patterns) == 1:
        common = _Common(outer.length[0], middle.length[0])
        for part in _parts(first.size, common.overlap, _BLOCK):
            made.put(part, common.integrals(common.of(outer, first[part], 0), common.of(middle, second[part], 1)))
    else:
        for part in _parts(first.size, outer.length.shape[1] + middle.length.shape[1], _MERGED):
            made.put(part, _own_integrals(outer, middle, first[part], second[part]))
    return PairTable(
        **made.values,
        ratio_mean=outer.rigidity_mean[first] / middle.rigidity_mean[second],
        ratio_series=outer.rigidity_series[first] / middle.rigidity_series[second],
        converged=outer.converged[first] & middle.converged[second],
    )


def integrated(outer: NotchedTube, middle: NotchedTube, angles: tuple[NDArray[Any], NDArray[Any]]) -> dict[str, Any]:
    """Return what (8) integrates to for one pair of solved tubes, named as in ``PairTable``; numbers may be complex.

    Args:
        angles: of the ends of either tube's pieces from the clamp, rad.
    """
    one, two = (_solved_tubes((tube,), angle[None]) for tube, angle in zip((outer, middle), angles, strict=True))
    common, only = _Common(one.length[0], two.length[0]), np.zeros(1, dtype=np.int64)
    sums = common.integrals(common.of(one, only, 0), common.of(two, only, 1))
    return {name: values[0] for name, values in sums.items()}


@dataclass
class _Columns:
    """The integrals of pairs while they are filled in, block by block."""

    shape: tuple[int, ...]
    values: dict[str, NDArray[Any]] = field(init=False)

    def __post_init__(self) -> None:
        names = ("total_precurvature", "signed_precurvature", "total_mean", "total_series")
        self.values = {name: np.empty(self.shape) for name in names}

    def put(self, here: Any, sums: dict[str, NDArray[Any]]) -> None:  # noqa: ANN401  # whatever indexes an array
        for name, values in sums.items():
            self.values[name][here] = values


@dataclass(frozen=True, slots=True)
class _Pieces:
    """Tubes on the pieces they share with another pattern, shape (tubes, pieces).

    Attributes:
        rigidity: N m^2. turning, turning_across: rigidity times the turn in the plane and out of it, N m^2 rad.
        weight: kg/m. natural_moment: rigidity times natural curvature, N m.
    """

    rigidity: FloatArray
    turning: NDArray[Any]
    turning_across: FloatArray | None = None
    weight: FloatArray | None = None
    natural_moment: FloatArray | None = None

    def picked(self, rows: slice, spread: Any) -> _Pieces:  # noqa: ANN401  # whatever indexes an array
        """Return some of the tubes, spread along a new axis to meet others."""
        columns: Any = {name: getattr(self, name) for name in self.__slots__}
        return _Pieces(**{name: column[rows][spread] for name, column in columns.items() if column is not None})


class _Common:
    """The pieces on which two notch patterns are both constant; the first ``overlap`` are covered by both tubes."""

    def __init__(self, one: FloatArray, other: FloatArray) -> None:
        self.ends = [np.concatenate(([0.0], np.cumsum(np.trim_zeros(length, "b").real))) for length in (one, other)]
        shorter = min(end[-1] for end in self.ends)
        nodes = np.sort(np.concatenate((self.ends[0], self.ends[1][1:])))
        nodes = nodes[np.append(True, np.diff(nodes) > 1e-9 * shorter)]
        self.overlap = int(np.argmin(np.abs(nodes - shorter)))
        nodes[self.overlap] = shorter
        self.nodes, self.length = nodes, np.diff(nodes)

    def of(self, tubes: BentTubes, rows: Rows, which: int, *, with_weight: bool = False) -> _Pieces:
        """Return tubes of the first or second pattern; the angle is taken linear inside a tube's own piece.

        Beyond a tube's own end it has neither rigidity nor weight, which only coupled pairs need.
        """
        ends = self.ends[which]
        count = self.length.size if with_weight else self.overlap
        nodes = self.nodes[: count + 1]
        middle = 0.5 * (nodes[1:] + nodes[:-1])
        own = np.minimum(np.searchsorted(ends, middle), ends.size - 1) - 1
        there = middle < ends[-1]
        left = np.minimum(np.searchsorted(ends, nodes, side="right"), ends.size - 1) - 1
        share = (nodes - ends[left]) / np.diff(ends)[left]
        angle = tubes.angle[rows]
        at_nodes = angle[:, left]
        if np.any(share):
            at_nodes = at_nodes + share * (angle[:, left + 1] - at_nodes)
        rigidity = tubes.rigidity[rows][:, own] * there
        across = tubes.across[rows, None]
        return _Pieces(
            rigidity=rigidity,
            turning=rigidity * np.diff(at_nodes, axis=1),
            turning_across=rigidity * across * self.length[:count] if np.any(across) else None,
            weight=tubes.weight[rows][:, own] * there if with_weight else None,
            natural_moment=rigidity * tubes.natural_curvature[rows, None] if with_weight else None,
        )

    def integrals(self, outer: _Pieces, middle: _Pieces) -> dict[str, NDArray[Any]]:
        """Return what (8) integrates to where each tube sags by itself."""
        rigidity = outer.rigidity + middle.rigidity
        bend = outer.turning + middle.turning
        bend /= rigidity
        across = [tubes.turning_across / rigidity for tubes in (outer, middle) if tubes.turning_across is not None]
        return _integrals(self.length[: self.overlap], rigidity, bend, np.add.reduce(across) if across else None)

    def coupled_integrals(
        self, outer: _Pieces, middle: _Pieces, gravity: float
    ) -> tuple[dict[str, NDArray[Any]], NDArray[np.bool_]]:
        """Return what (8) integrates to where each pair sags as one beam, and whether each was solved."""
        rigidity, weight, natural = (
            getattr(outer, name) + getattr(middle, name) for name in ("rigidity", "weight", "natural_moment")
        )
        flat = (-1, self.length.size)
        solved = solve_segments(
            self.length,
            rigidity.reshape(flat),
            weight.reshape(flat),
            (natural / rigidity).reshape(flat),
            gravity=(0.0, -gravity),
        )
        bend, part = np.diff(solved.angle, axis=-1).reshape(rigidity.shape), np.s_[..., : self.overlap]
        sums = _integrals(self.length[: self.overlap], rigidity[part], bend[part])
        return sums, solved.converged.reshape(rigidity.shape[:-1])


def _own_integrals(outer: BentTubes, middle: BentTubes, first: Rows, second: Rows) -> dict[str, NDArray[Any]]:
    """Integrate (8) over the pieces of a few pairs that share none."""
    length, one, two = _own_pieces(outer.ends[first], middle.ends[second])
    one += first[:, None] * outer.length.shape[1]
    two += second[:, None] * middle.length.shape[1]
    stiff = np.take(outer.rigidity, one, mode="clip"), np.take(middle.rigidity, two, mode="clip")
    rigidity = stiff[0] + stiff[1]
    share = length / rigidity
    bend = (np.take(outer.moment, one, mode="clip") + np.take(middle.moment, two, mode="clip")) * share
    across = None
    if np.any(outer.across[first]) or np.any(middle.across[second]):
        across = (stiff[0] * outer.across[first, None] + stiff[1] * middle.across[second, None]) * share
    return _integrals(length, rigidity, bend, across)


def _own_pieces(outer: FloatArray, middle: FloatArray) -> tuple[FloatArray, Rows, Rows]:
    """Return the lengths of the merged pieces of each pair (m), and which piece of either tube each lies in.

    Args:
        outer, middle: ends of the pieces of each tube, m, shape (pairs, pieces). Merged pieces past the overlap are 0
            long, and there the piece of a tube may be one past its last.
    """
    overlap = np.minimum(outer[:, -1:], middle[:, -1:])
    outer, middle = (ends[:, : int((ends < overlap).sum(axis=1).max()) + 1] for ends in (outer, middle))
    merged = np.concatenate((outer, middle), axis=1)
    order = np.argsort(merged, axis=1, kind="stable")  # two rising runs, which a stable sort merges
    place, width = np.arange(merged.shape[1]), merged.shape[1]
    nodes = np.take(merged, order + width * np.arange(len(merged))[:, None])
    np.minimum(nodes, overlap, out=nodes)
    length = nodes.copy()
    length[:, 1:] -= nodes[:, :-1]
    own = outer.shape[1]
    one = np.where(order < own, order, place + own - order)  # pieces of the outer tube that end before this one begins
    return length, one, place - one


def _integrals(
    length: FloatArray, rigidity: NDArray[Any], bend: NDArray[Any], across: NDArray[Any] | None = None
) -> dict[str, NDArray[Any]]:
    """Return the figures of pairs from what they have on each common piece; ``rigidity`` and ``bend`` are overwritten.

    Args:
        length: m, shape (pieces,) or that of the pairs. rigidity: of both tubes together, N m^2.
        bend, across: what the pair settles on in the plane and out of it, rad.
    """
    whole = length.sum(axis=-1)
    signed = bend.sum(axis=-1)
    mean = _along(rigidity, length) / whole
    series = whole / _along(
        1.0 / rigidity if np.iscomplexobj(rigidity) else np.reciprocal(rigidity, out=rigidity), length
    )
    if across is not None:
        bend = np.hypot(bend, across)
    size = bend * np.sign(bend.real) if np.iscomplexobj(bend) else np.abs(bend, out=bend)
    return {
        "total_precurvature": size.sum(axis=-1),
        "signed_precurvature": signed,
        "total_mean": mean,
        "total_series": series,
    }


def _along(values: NDArray[Any], length: FloatArray) -> NDArray[Any]:
    return values @ length if length.ndim == 1 else np.asarray(np.einsum("ij,ij->i", values, length))


def _bent_exactly(tubes: Sequence[NotchedTube], gravity: float) -> BentTubes:
    """Solve tubes of any patterns to the accuracy of ``solve_beams``."""
    solved = solve_beams(tubes, gravity)
    return _solved_tubes(tubes, solved.angle, solved.converged)


def _solved_tubes(
    tubes: Sequence[NotchedTube], angle: NDArray[Any], converged: NDArray[np.bool_] | None = None
) -> BentTubes:
    """Return tubes with the angles (rad) of their piece ends; shorter ones are filled up with pieces of no length."""
    most = angle.shape[1] - 1

    def filled(name: str, filler: float = 0.0) -> NDArray[Any]:
        columns = [getattr(tube.segments, name) for tube in tubes]
        return np.stack([np.append(column, np.full(most - column.size, filler)) for column in columns])

    return BentTubes(
        length=filled("length"),
        rigidity=filled("rigidity", 1.0),
        weight=filled("weight"),
        angle=angle,
        natural_curvature=np.array([tube.natural_curvature for tube in tubes]),
        across=np.zeros(len(tubes)),
        rigidity_mean=np.array([tube.rigidity_mean for tube in tubes]),
        rigidity_series=np.array([tube.rigidity_series for tube in tubes]),
        converged=np.ones(len(tubes), dtype=bool) if converged is None else converged,
    )


def _shaped(table: PairTable, shape: tuple[int, int]) -> PairTable:
    columns = {name: getattr(table, name).reshape(shape) for name in PairTable.__slots__}
    return PairTable(**columns)


def _parts(rows: int, pieces: int, most: int) -> Iterator[slice]:
    """Yield slices of rows, each of at most ``most`` numbers."""
    step = max(1, most // pieces)
    for start in range(0, rows, step):
        yield slice(start, start + step)


def _blocks(outer: int, middle: int, pieces: int) -> Iterator[tuple[slice, slice]]:
    """Yield blocks of outer and middle tubes, about as many of both, each small enough for the cache."""
    pairs = max(1, _BLOCK // pieces)
    side = max(1, min(outer, max(int(pairs**0.5), pairs // middle)))
    for one in _parts(outer, 1, side):
        for two in _parts(middle, side * pieces, _BLOCK):
            yield one, two
