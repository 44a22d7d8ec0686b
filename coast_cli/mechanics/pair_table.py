"""Figures of every pair of many outer and many middle tubes, equation (8) of P, without a loop over pairs.

Each tube is solved once. Tubes of one notch pattern share their pieces, so the pairs of two patterns are one array of
pairs by pieces, summed in blocks that fit the processor's cache.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam import BeamSolutions, solve_beams, solve_segments
from coast_cli.mechanics.pair import Assembly
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube

_BLOCK = 1 << 19  # pairs times pieces at once


@dataclass(frozen=True, slots=True)
class PairTable:
    """The figures of ``PairFigures`` for all pairs, shape (middle tubes, outer tubes).

    Attributes:
        total_precurvature, signed_precurvature: rad. ratio_mean, ratio_series: outer over middle.
        total_mean, total_series: N m^2 over the overlap.
        converged: whether the beams beneath were solved.
    """

    total_precurvature: FloatArray
    signed_precurvature: FloatArray
    ratio_mean: FloatArray
    ratio_series: FloatArray
    total_mean: FloatArray
    total_series: FloatArray
    converged: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _Pieces:
    """Tubes of one pattern on the pieces they share with another pattern; shape (tubes, pieces), turn in rad."""

    rigidity: FloatArray
    weight: FloatArray
    turn: FloatArray
    natural_curvature: FloatArray


def pair_table(
    outer: Sequence[NotchedTube], middle: Sequence[NotchedTube], gravity: float, assembly: Assembly = "separate"
) -> PairTable:
    """Return the figures of every pair; gravity in m/s^2 along -y.

    Args:
        outer, middle: any numbers of tubes.
        assembly: "separate" puts each tube's own sag into (8) (P); "coupled" lets each pair sag as one beam of summed
            rigidities and weights, of which what the longer tube sticks out by hangs at the end.
    """
    shape = (len(middle), len(outer))
    zeros = [np.zeros(shape) for _ in range(6)]
    table = PairTable(zeros[0], zeros[1], zeros[2], zeros[3], zeros[4], zeros[5], np.ones(shape, dtype=bool))
    mean, series = (
        [np.array([getattr(tube, name) for tube in tubes]) for tubes in (outer, middle)]
        for name in ("rigidity_mean", "rigidity_series")
    )
    table.ratio_mean[:] = mean[0] / mean[1][:, None]
    table.ratio_series[:] = series[0] / series[1][:, None]
    solved = (solve_beams(outer, gravity), solve_beams(middle, gravity))
    if assembly == "separate":
        table.converged[:] = solved[0].converged & solved[1].converged[:, None]
    for outer_group in _patterns(outer):
        for middle_group in _patterns(middle):
            nodes, overlap = _common_nodes(outer[outer_group[0]], middle[middle_group[0]])
            if assembly == "separate":
                nodes = nodes[: overlap + 1]
            length = np.diff(nodes)
            pieces = (
                _on_pieces(outer, outer_group, solved[0], nodes),
                _on_pieces(middle, middle_group, solved[1], nodes),
            )
            for block in _blocks(outer_group, middle_group, length.size):
                _fill(table, length, overlap, pieces, block, gravity, assembly)
    return table


def _fill(
    table: PairTable,
    length: FloatArray,
    overlap: int,
    pieces: tuple[_Pieces, _Pieces],
    block: tuple[NDArray[np.int64], NDArray[np.int64], slice],
    gravity: float,
    assembly: Assembly,
) -> None:
    """Put the figures of some middle tubes with all outer tubes of a pattern into the table."""
    outer_tubes, middle_tubes, rows = block
    outer, middle = pieces
    rigidity = outer.rigidity + middle.rigidity[rows, None, :]
    here = np.ix_(middle_tubes[rows], outer_tubes)
    common = length[:overlap]
    table.total_mean[here] = rigidity[..., :overlap] @ common / common.sum()
    table.total_series[here] = common.sum() / ((1.0 / rigidity[..., :overlap]) @ common)
    if assembly == "separate":
        bend = (outer.rigidity * outer.turn + (middle.rigidity * middle.turn)[rows, None, :]) / rigidity
    else:
        bend, table.converged[here] = _coupled_bend(length, rigidity, outer, middle, rows, gravity)
    bend = bend[..., :overlap]
    table.signed_precurvature[here] = bend.sum(axis=-1)
    table.total_precurvature[here] = np.abs(bend, out=bend).sum(axis=-1)


def _coupled_bend(
    length: FloatArray, rigidity: FloatArray, outer: _Pieces, middle: _Pieces, rows: slice, gravity: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the turn of each piece of the composite beams (rad) and whether each was solved."""
    weight = outer.weight + middle.weight[rows, None, :]
    natural = (
        outer.rigidity * outer.natural_curvature + (middle.rigidity * middle.natural_curvature)[rows, None, :]
    ) / rigidity
    flat = (-1, length.size)
    solution = solve_segments(
        length, rigidity.reshape(flat), weight.reshape(flat), natural.reshape(flat), gravity=(0.0, -gravity)
    )
    return np.diff(solution.angle, axis=-1).reshape(rigidity.shape), solution.converged.reshape(rigidity.shape[:-1])


def _patterns(tubes: Sequence[NotchedTube]) -> list[NDArray[np.int64]]:
    """Return the tubes, by index, in groups of one notch pattern."""
    groups: dict[bytes, list[int]] = {}
    for index, tube in enumerate(tubes):
        groups.setdefault(tube.segments.length.tobytes(), []).append(index)
    return [np.array(group) for group in groups.values()]


def _common_nodes(one: NotchedTube, other: NotchedTube) -> tuple[FloatArray, int]:
    """Return the ends (m) of the pieces on which both patterns are constant, and how many pieces overlap."""
    ends = [np.cumsum(tube.segments.length) for tube in (one, other)]
    overlap = min(end[-1] for end in ends)
    nodes = np.sort(np.concatenate((np.zeros(1), *ends)))
    nodes = nodes[np.append(True, np.diff(nodes) > 1e-9 * overlap)]
    last = int(np.argmin(np.abs(nodes - overlap)))
    nodes[last] = overlap
    return nodes, last


def _on_pieces(
    tubes: Sequence[NotchedTube], group: NDArray[np.int64], solved: BeamSolutions, nodes: FloatArray
) -> _Pieces:
    """Return the tubes of one pattern on common pieces; the angle is taken linear inside a tube's own piece.

    Beyond a tube's own end it has neither rigidity nor weight.
    """
    pieces = [tubes[index].segments for index in group]
    ends = np.concatenate(([0.0], np.cumsum(pieces[0].length)))
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    own = np.minimum(np.searchsorted(ends, middle), ends.size - 1) - 1
    there = middle < ends[-1]
    angle = solved.angle[group][:, : ends.size]
    left = np.minimum(np.searchsorted(ends, nodes, side="right"), ends.size - 1) - 1
    share = (nodes - ends[left]) / np.diff(ends)[left]
    at_nodes = angle[:, left] + share * (angle[:, left + 1] - angle[:, left])
    return _Pieces(
        rigidity=np.stack([piece.rigidity for piece in pieces])[:, own] * there,
        weight=np.stack([piece.weight for piece in pieces])[:, own] * there,
        turn=np.diff(at_nodes, axis=1),
        natural_curvature=np.array([[tubes[index].natural_curvature] for index in group]),
    )


def _blocks(
    outer: NDArray[np.int64], middle: NDArray[np.int64], pieces: int
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], slice]]:
    """Yield blocks of middle tubes, each with all outer tubes."""
    step = max(1, _BLOCK // (outer.size * pieces))
    for first in range(0, middle.size, step):
        yield outer, middle, slice(first, first + step)
