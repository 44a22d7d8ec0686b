"""The figures of many pairs, row by row, for tubes that differ in everything: equation (8) of P integrated exactly.

Each pair has its own common pieces: the ends of both tubes' pieces, merged. On each of them both rigidities are
constant, so (8) is the rigidity-weighted mean of the tubes' own turns. ``mechanics.pair`` is faster where patterns repeat.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.population import TubePopulation
from coast_cli.mechanics.beam import solve_curvatures
from coast_cli.mechanics.section import FloatArray

if TYPE_CHECKING:
    from coast_cli.mechanics.joint import Joint

BLOCK = 2048  # tubes solved at a time, so that their rows stay in the processor's cache
_PAIRS = 64  # pairs merged at a time, so that they stay in the processor's cache
_TOGETHER = 1 << 18  # pairs times pieces at once where pieces are shared
_WORTH_SHARING = 16  # pairs a group of patterns, from which on merging once is faster

FIGURES = {
    "total_precurvature_rad": "rad",
    "signed_precurvature_rad": "rad",
    "rigidity_ratio_mean": "",
    "rigidity_ratio_series": "",
    "total_rigidity_mean_n_m2": "N m^2",
    "total_rigidity_series_n_m2": "N m^2",
}
POINT_FIGURES = {"stroke_mm": "mm", "tendon_strain": "", "web_strain": "", "closure_curvature_per_m": "1/m"}


@dataclass(frozen=True)
class BentTubes:
    """Solved tubes: rows of length (m), rigidity (N m^2) and bend = rigidity * curvature (N m) of every piece.

    Attributes:
        rigidity_mean, rigidity_series: of each tube, N m^2. across: natural curvature out of the plane, 1/m.
        converged: whether each tube was solved.
    """

    length: FloatArray
    rigidity: FloatArray
    bend: FloatArray
    rigidity_mean: FloatArray
    rigidity_series: FloatArray
    across: FloatArray
    converged: NDArray[np.bool_]

    @cached_property
    def ends(self) -> FloatArray:
        """End of every piece from the clamp, m."""
        return np.cumsum(self.length, axis=1)


def bent(tubes: TubePopulation, gravity: float, *, roll: FloatArray | float = 0.0) -> BentTubes:
    """Solve every tube under gravity (m/s^2).

    Args:
        roll: of the natural curvature out of the plane of gravity, rad. The plane then sees its cosine; its sine bends
            across, where gravity does nothing to first order.
    """
    length, rigidity, weight = tubes.pieces
    natural = tubes.natural_curvature * np.cos(roll)
    bend, converged = np.empty_like(rigidity), np.empty(tubes.size, dtype=bool)
    for first in range(0, tubes.size, BLOCK):
        part = slice(first, first + BLOCK)
        solved = solve_curvatures(length[part], rigidity[part], weight[part], natural[part, None], gravity=gravity)
        bend[part], converged[part] = rigidity[part] * solved.curvature, solved.converged
    across = np.broadcast_to(tubes.natural_curvature * np.sin(roll), tubes.size)
    return BentTubes(length, rigidity, bend, tubes.rigidity_mean, tubes.rigidity_series, across, converged)


def pair_figures_of(
    outer: BentTubes, middle: BentTubes, rows: tuple[NDArray[np.int64], NDArray[np.int64]]
) -> dict[str, FloatArray]:
    """Return the columns of ``FIGURES`` for pairs; NaN where a tube of the pair was not solved.

    Args:
        rows: which outer and which middle tube each pair takes, both of shape (pairs,).
    """
    first, second = rows
    columns = {name: np.empty(first.size) for name in FIGURES}
    for start in range(0, first.size, _PAIRS):
        part = slice(start, start + _PAIRS)
        _merge(outer, middle, first[part], second[part], {name: column[part] for name, column in columns.items()})
    columns["rigidity_ratio_mean"] = outer.rigidity_mean[first] / middle.rigidity_mean[second]
    columns["rigidity_ratio_series"] = outer.rigidity_series[first] / middle.rigidity_series[second]
    solved = outer.converged[first] & middle.converged[second]
    return {name: np.where(solved, column, np.nan) for name, column in columns.items()}


def cross_figures(outer: BentTubes, middle: BentTubes) -> dict[str, FloatArray]:
    """Return the columns of ``FIGURES`` of every outer with every middle tube, the middle tube slowest.

    Tubes of one notch pattern share their pieces, which then are merged once.
    """
    shape = len(middle.length), len(outer.length)
    second, first = (index.ravel() for index in np.indices(shape))
    groups = [_patterns(tubes.length) for tubes in (outer, middle)]
    if len(groups[0]) * len(groups[1]) * _WORTH_SHARING > first.size:
        return pair_figures_of(outer, middle, (first, second))
    columns = {name: np.empty(shape) for name in FIGURES}
    for ones in groups[0]:
        for twos in groups[1]:
            _merge_alike(outer, middle, ones, twos, columns)
    columns["rigidity_ratio_mean"] = outer.rigidity_mean / middle.rigidity_mean[:, None]
    columns["rigidity_ratio_series"] = outer.rigidity_series / middle.rigidity_series[:, None]
    solved = outer.converged & middle.converged[:, None]
    return {name: np.where(solved, column, np.nan).ravel() for name, column in columns.items()}


def _patterns(length: FloatArray) -> list[NDArray[np.int64]]:
    """Return rows of equal pieces, by index, in groups."""
    group = np.unique(length, axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(group, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(group[order])) + 1)


def _merge_alike(
    outer: BentTubes,
    middle: BentTubes,
    ones: NDArray[np.int64],
    twos: NDArray[np.int64],
    columns: dict[str, FloatArray],
) -> None:
    """Integrate over pairs whose outer tubes share one pattern and whose middle tubes share another."""
    length, one, two = (table[0] for table in _common_pieces(outer.ends[ones[:1]], middle.ends[twos[:1]]))
    there = length > 0.0
    length, one, two = length[there], one[there], two[there]
    stiff, bent_by = outer.rigidity[ones[:, None], one], outer.bend[ones[:, None], one]
    step = max(1, _TOGETHER // (ones.size * length.size))
    for start in range(0, twos.size, step):
        some = twos[start : start + step]
        rigidity = stiff + middle.rigidity[some[:, None, None], two]
        turn = (bent_by + middle.bend[some[:, None, None], two]) / rigidity
        here = some[:, None], ones
        columns["signed_precurvature_rad"][here] = turn @ length
        columns["total_precurvature_rad"][here] = np.abs(turn, out=turn) @ length
        columns["total_rigidity_mean_n_m2"][here] = rigidity @ length / length.sum()
        columns["total_rigidity_series_n_m2"][here] = length.sum() / (np.reciprocal(rigidity, out=rigidity) @ length)


def _merge(
    outer: BentTubes,
    middle: BentTubes,
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    columns: dict[str, FloatArray],
) -> None:
    """Integrate over the merged pieces of a few pairs."""
    length, one, two = _common_pieces(outer.ends[first], middle.ends[second])
    one += first[:, None] * outer.length.shape[1]
    two += second[:, None] * middle.length.shape[1]
    stiff = np.take(outer.rigidity, one, mode="clip"), np.take(middle.rigidity, two, mode="clip")
    rigidity = stiff[0] + stiff[1]
    share = length / rigidity
    bend = np.take(outer.bend, one, mode="clip") + np.take(middle.bend, two, mode="clip")
    columns["signed_precurvature_rad"][:] = np.einsum("ij,ij->i", bend, share)
    if np.any(outer.across[first]) or np.any(middle.across[second]):
        bend = np.hypot(bend, stiff[0] * outer.across[first, None] + stiff[1] * middle.across[second, None])
    columns["total_precurvature_rad"][:] = np.einsum("ij,ij->i", np.abs(bend, out=bend), share)
    overlap = length.sum(axis=1)
    columns["total_rigidity_mean_n_m2"][:] = np.einsum("ij,ij->i", rigidity, length) / overlap
    columns["total_rigidity_series_n_m2"][:] = overlap / share.sum(axis=1)


def _common_pieces(outer: FloatArray, middle: FloatArray) -> tuple[FloatArray, NDArray[np.int64], NDArray[np.int64]]:
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


def point_figures(
    joint: Joint, outer: TubePopulation, middle: TubePopulation, curvature: float, bending_length: float
) -> dict[str, FloatArray]:
    """Return the columns of ``POINT_FIGURES`` of pairs row by row, bent to a curvature (1/m) over a length (m).

    Stroke and tendon strain are those of the joint model with each pair's tubes; the web strain is the largest strain
    that bending puts into what a notch leaves of either tube, whose cuts take all of the bend.

    Args:
        joint: gives tendon, friction and modulus; its own tubes are not used.
    """
    from coast_cli.mechanics.joint import stroke

    pitch = np.mean(middle.cut + middle.uncut, axis=1)
    second_moment = outer.rigidity_series / outer.youngs_modulus + middle.rigidity_series / middle.youngs_modulus
    radius = 0.0 if joint.tendon is None else joint.tendon.radius
    pairs: Any = _Joints(
        tendon=joint.tendon,
        pulley_friction=joint.pulley_friction,
        wrap_angle=joint.wrap_angle,
        notch_friction=joint.notch_friction,
        deadband=joint.deadband,
        rigidity=joint.youngs_modulus * second_moment,
        lever_arm=np.mean(middle.notch.neutral_axis, axis=1) + middle.inner_radius - radius,
        cut=np.mean(middle.cut, axis=1),
        pitch=pitch,
    )
    columns = {}
    if joint.tendon is not None:
        solution = stroke(pairs, curvature, bending_length)
        columns = {"stroke_mm": solution.stroke * 1e3, "tendon_strain": solution.tendon_strain}
    columns["web_strain"] = np.maximum(web_strain(outer, curvature), web_strain(middle, curvature))
    columns["closure_curvature_per_m"] = np.minimum(_closure(outer), _closure(middle))
    return columns


def web_strain(tubes: TubePopulation, curvature: float) -> FloatArray:
    """Return the largest strain in what the notches leave where a tube bends to a mean curvature, 1/m; shape (m,).

    The cuts take the whole bend, so each bends by curvature * pitch / cut; the strain is that times the distance from
    the neutral axis to the outer skin or to the near edge of the section, whichever is further.
    """
    ro, ri = tubes.outer_radius[:, None], tubes.inner_radius[:, None]
    near = tubes.depth - ro
    if tubes.section == "sector":
        near = near * ri / ro  # its inner corner
    reach = np.maximum(ro - tubes.notch.neutral_axis, tubes.notch.neutral_axis - near)
    return np.asarray(np.max(curvature * (tubes.cut + tubes.uncut) / tubes.cut * reach, axis=1))


def _closure(tubes: TubePopulation) -> FloatArray:
    """Return the curvature at which the first notch's faces touch, 1/m: each bends by cut/(ro + ybar)."""
    bend = tubes.cut / (tubes.outer_radius[:, None] + tubes.notch.neutral_axis)
    return np.asarray(np.min(bend / (tubes.cut + tubes.uncut), axis=1))


@dataclass(frozen=True)
class _Joints:
    """What the joint model asks of a ``Joint``, with one entry a pair."""

    tendon: Any
    pulley_friction: float
    wrap_angle: float
    notch_friction: float
    deadband: float
    rigidity: FloatArray
    lever_arm: FloatArray
    cut: FloatArray
    pitch: FloatArray
