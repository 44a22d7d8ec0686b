"""Two notched tubes as one: the curvature they settle on and the rigidity they have, equation (8) of P, for many pairs.

On a piece where both rigidities are constant the integral of (8) is the rigidity-weighted mean of the tubes' own turns,
so no quadrature is needed. Each tube is solved once. Tubes of one notch pattern share their pieces, so the pairs of two
patterns are one array of pairs by pieces, summed in blocks that fit the processor's cache.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.beam import solve_beams, solve_segments
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube

Assembly = Literal["separate", "coupled"]

_BLOCK = 1 << 19  # pairs times pieces at once


@dataclass(frozen=True, slots=True)
class PairTable:
    """What pairs are ranked by, each of shape (middle tubes, outer tubes).

    Attributes:
        total_precurvature: integral of |kappa_final| over the overlap, rad.
        signed_precurvature: integral of kappa_final, rad; positive where the outer tube leads.
        ratio_mean, ratio_series: rigidity of the outer over that of the middle tube, along the tube (P) or in series.
        total_mean, total_series: rigidity of both tubes together over the overlap, N m^2; in series it is the uniform
            pair that bends as far under one moment, a little more than the sum of the tubes' own series rigidities.
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
                _on_pieces([outer[index] for index in outer_group], solved[0].angle[outer_group], nodes),
                _on_pieces([middle[index] for index in middle_group], solved[1].angle[middle_group], nodes),
            )
            for block in _blocks(outer_group, middle_group, length.size):
                _fill(table, length, overlap, pieces, block, gravity, assembly)
    return table


def integrated(outer: NotchedTube, middle: NotchedTube, angles: tuple[NDArray[Any], NDArray[Any]]) -> dict[str, Any]:
    """Return what (8) integrates to for one pair of solved tubes, named as in ``PairTable``; numbers may be complex.

    Args:
        angles: of the ends of either tube's pieces from the clamp, rad.
    """
    nodes, overlap = _common_nodes(outer, middle)
    nodes = nodes[: overlap + 1]
    pieces = _on_pieces([outer], angles[0][None], nodes), _on_pieces([middle], angles[1][None], nodes)
    rigidity = _together(*pieces)
    sums = _sums(np.diff(nodes), rigidity, _together(*pieces, "turn") / rigidity)
    return {name: values[0, 0] for name, values in sums.items()}


def _together(outer: _Pieces, middle: _Pieces, weighted: str = "", rows: slice = slice(None)) -> NDArray[Any]:
    """Return the sum of both rigidities, or of rigidities times an attribute, shape (middle, outer, pieces)."""
    one, two = (tubes.rigidity * getattr(tubes, weighted) if weighted else tubes.rigidity for tubes in (outer, middle))
    return one + two[rows, None, :]


def _sums(length: FloatArray, rigidity: NDArray[Any], bend: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return the figures of pairs from length (m), rigidity (N m^2) and bend (rad, overwritten) of their common pieces."""
    signed = bend.sum(axis=-1)
    size = bend * np.sign(bend.real) if np.iscomplexobj(bend) else np.abs(bend, out=bend)
    return {
        "total_precurvature": size.sum(axis=-1),
        "signed_precurvature": signed,
        "total_mean": rigidity @ length / length.sum(),
        "total_series": length.sum() / ((1.0 / rigidity) @ length),
    }


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
    rigidity = _together(outer, middle, rows=rows)
    here = np.ix_(middle_tubes[rows], outer_tubes)
    if assembly == "separate":
        bend = _together(outer, middle, "turn", rows) / rigidity
    else:
        bend, table.converged[here] = _coupled_bend(length, rigidity, outer, middle, rows, gravity)
    for name, values in _sums(length[:overlap], rigidity[..., :overlap], bend[..., :overlap]).items():
        getattr(table, name)[here] = values


def _coupled_bend(
    length: FloatArray, rigidity: FloatArray, outer: _Pieces, middle: _Pieces, rows: slice, gravity: float
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the turn of each piece of the composite beams (rad) and whether each was solved."""
    weight = outer.weight + middle.weight[rows, None, :]
    natural = _together(outer, middle, "natural_curvature", rows) / rigidity
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


def _on_pieces(tubes: Sequence[NotchedTube], angle: NDArray[Any], nodes: FloatArray) -> _Pieces:
    """Return tubes of one pattern on common pieces; the angle is taken linear inside a tube's own piece.

    Beyond a tube's own end it has neither rigidity nor weight.
    """
    pieces = [tube.segments for tube in tubes]
    ends = np.concatenate(([0.0], np.cumsum(pieces[0].length)))
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    own = np.minimum(np.searchsorted(ends, middle), ends.size - 1) - 1
    there = middle < ends[-1]
    left = np.minimum(np.searchsorted(ends, nodes, side="right"), ends.size - 1) - 1
    share = (nodes - ends[left]) / np.diff(ends)[left]
    at_nodes = angle[:, left] + share * (angle[:, left + 1] - angle[:, left])
    return _Pieces(
        rigidity=np.stack([piece.rigidity for piece in pieces])[:, own] * there,
        weight=np.stack([piece.weight for piece in pieces])[:, own] * there,
        turn=np.diff(at_nodes, axis=1),
        natural_curvature=np.array([[tube.natural_curvature] for tube in tubes]),
    )


def _blocks(
    outer: NDArray[np.int64], middle: NDArray[np.int64], pieces: int
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], slice]]:
    """Yield blocks of middle tubes, each with all outer tubes."""
    step = max(1, _BLOCK // (outer.size * pieces))
    for first in range(0, middle.size, step):
        yield outer, middle, slice(first, first + step)
