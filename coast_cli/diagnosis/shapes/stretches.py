"""Where along the tube the mismatch is: the stretch whose curvature, set free, leaves the rest of the model right.

Differentiating noisy points is avoided: a curvature error in a stretch moves all points beyond it in a known way, so
stretches compete as linear models of the residuals themselves. Curvature is piecewise constant, Gaussian with a width that
is chosen from a few, free in every photograph, base parameters follow; the score is the marginal likelihood, which
pays for every degree of freedom. Under noise alone a Bayes factor exceeds x with probability at most 1/x (Markov), so
looks / factor bounds the p-value. A base rotation competes as a stretch of no length at the clamp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.locate import Region, in_order_of_share
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.thresholds import PAIR_SHARE, SIGNIFICANT
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

_BINS = 16
_REFINED, _FINER = 3, 8
_WIDTHS = (0.3, 3.0, 30.0)  # of the curvature that turns the tip by one noise width over the tube's length


_Block = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, slots=True)
class _Stretch:
    """A stretch with its log Bayes factor over base parameters alone, the power left, and its ends, m."""

    gain: float
    left: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class _Linear:
    """The linear problem in noise levels.

    Attributes:
        residual: (n,). base: how it moves with base parameters (n, p). precision: of their priors (p, p).
        bins: how points move with the curvature of each bin (n, K). rotation: with the clamp (n, 1).
        edges: of the bins, m. slices: rows of each photograph.
    """

    residual: FloatArray
    base: FloatArray
    precision: FloatArray
    bins: FloatArray
    rotation: FloatArray
    edges: FloatArray
    slices: tuple[slice, ...]


def locate_along_tube(problem: ShapeProblem, base: Fit, noise: float, correlation: float = 0.0) -> tuple[Region, ...]:
    """Return the regions that hold the base model's excess error, largest share first; none where it agrees.

    Args:
        noise: of the points, m. correlation: of it between neighbours, by which evidence is worth less.
    """
    length = problem.scene.length
    edges = np.linspace(0.0, length, _BINS + 1)
    linear = _linear(problem, base, noise, edges)
    looks = _BINS * (_BINS + 1) // 2 + 1
    best = max(_rotation(linear), _best_interval(linear), key=lambda stretch: stretch.gain)
    for _ in range(_REFINED):
        width = float(edges[1] - edges[0])
        if best.high - best.low > 2.5 * width or best.high == 0.0 or width < length / 300.0:
            break
        edges = np.linspace(max(best.low - width, 0.0), min(best.high + width, length), _FINER + 1)
        finer = _best_interval(_linear(problem, base, noise, edges))
        looks += _FINER * (_FINER + 1) // 2
        if finer.gain <= best.gain:
            break
        best = finer
    known = float(np.clip(correlation, 0.0, 0.95))
    nats = best.gain * (1.0 - known) / (1.0 + known)
    p_value = float(min(1.0, looks * np.exp(-min(nats, 700.0))))
    if p_value > SIGNIFICANT:
        return ()
    power = float(linear.residual @ linear.residual)
    excess = max(power - linear.residual.size, 1e-300)
    share = float(np.clip((power - best.left) / excess, 0.0, 1.0))
    along = Region("arc_length", None, best.low / MILLIMETRE, best.high / MILLIMETRE, share, p_value)
    return in_order_of_share((along, *_by_photograph(problem, linear, excess)))


def _by_photograph(problem: ShapeProblem, linear: _Linear, excess: float) -> list[Region]:
    """Return the tube, where several were photographed, that holds most of the excess, if it holds more than its part."""
    parts: dict[str, tuple[float, int]] = {}
    for photograph, rows in zip(problem.photographs, linear.slices, strict=True):
        values = linear.residual[rows]
        before = parts.get(photograph.run.pair, (0.0, 0))
        parts[photograph.run.pair] = before[0] + float(values @ values), before[1] + values.size
    if len(parts) < 2:
        return []
    name, (power, count) = max(parts.items(), key=lambda item: item[1][0] - item[1][1])
    share = float(np.clip((power - count) / excess, 0.0, 1.0))
    total = sum(part[1] for part in parts.values())
    rest = max(sum(part[0] for part in parts.values()) - power, 1e-300)
    nats = 0.5 * count * np.log(max(power / count, 1e-300) / ((power + rest) / total))
    p_value = float(min(1.0, len(parts) * np.exp(-max(nats, 0.0))))
    return [Region("pair", name, None, None, share, p_value)] if p_value < SIGNIFICANT and share > PAIR_SHARE else []


def _linear(problem: ShapeProblem, base: Fit, noise: float, edges: FloatArray) -> _Linear:
    level = max(noise, 1e-12)
    bins = np.zeros((problem.size, edges.size - 1))
    rotation = np.zeros((problem.size, 1))
    state = problem.state(base.coordinates, base.effects)
    lines = problem.forward.lines([(index, state) for index in range(len(problem.photographs))])
    for photograph, line, rows, (across, _) in zip(
        problem.photographs, lines, problem.slices, problem.rows, strict=True
    ):
        tangent = np.stack([line.along_x[0], line.along_y[0]], axis=1)
        place = np.stack([line.x[0], line.y[0]], axis=1)
        at = photograph.at
        turned = np.clip((at[:, None] - edges[:-1]) / np.diff(edges), 0.0, 1.0) * np.diff(edges)
        moved = _moved(turned, place)
        swung = _moved(np.ones((at.size, 1)), place)
        part = slice(rows.start, rows.start + int(across.sum()))
        bins[part] = np.einsum("nkd,nd->nk", moved, _normal(tangent))[across]
        rotation[part] = np.einsum("nkd,nd->nk", swung, _normal(tangent))[across]
    space = problem.space(base.effects)
    return _Linear(
        residual=base.residual / level,
        base=-base.jacobian / level,
        precision=np.diag(1.0 / space.spread**2),
        bins=bins / level,
        rotation=rotation / level,
        edges=edges,
        slices=problem.slices,
    )


def _normal(tangent: FloatArray) -> FloatArray:
    return np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)


def _moved(turned: FloatArray, place: FloatArray) -> FloatArray:
    """Return how points move when the line turns by ``turned`` (n, k) at each: (n, k, 2), the clamp fixed."""
    step = np.diff(place, axis=0)
    mean = 0.5 * (turned[1:] + turned[:-1])
    pieces = mean[:, :, None] * np.stack([-step[:, 1], step[:, 0]], axis=1)[:, None, :]
    first = turned[:1, :, None] * np.stack([-place[:1, 1], place[:1, 0]], axis=1)[:, None, :]
    return np.cumsum(np.concatenate((first, pieces)), axis=0)


def _rotation(linear: _Linear) -> _Stretch:
    """Return how well one rotation at the clamp, the same in all photographs, does."""
    column = linear.rotation[:, 0]
    size = float(column @ column)
    power = float(linear.residual @ linear.residual)
    if size <= 0.0:
        return _Stretch(-np.inf, power, 0.0, 0.0)
    solve = np.linalg.solve
    normal = linear.base.T @ linear.base + linear.precision
    free = column - linear.base @ solve(normal, linear.base.T @ column)
    target = float(free @ linear.residual)
    found = []
    for width in _WIDTHS:
        prior = (10.0 * width) ** 2 / size
        precision = float(column @ free) + 1.0 / prior
        fall = 0.5 * target**2 / precision
        found.append(_Stretch(fall - 0.5 * float(np.log(precision * prior)), power - 2.0 * fall, 0.0, 0.0))
    return max(found, key=lambda stretch: stretch.gain)


def _best_interval(linear: _Linear) -> _Stretch:
    """Return the best stretch; its curvatures are free in every photograph."""
    blocks = []
    for rows in linear.slices:
        bins, base, residual = linear.bins[rows], linear.base[rows], linear.residual[rows]
        blocks.append((bins.T @ bins, bins.T @ base, bins.T @ residual))
    count = linear.bins.shape[1]
    typical = max(float(np.mean([np.trace(gram) for gram, _, _ in blocks])) / count, 1e-300)
    found = _Stretch(-np.inf, 0.0, 0.0, 0.0)
    for width in _WIDTHS:
        prior = (10.0 * width) ** 2 / typical
        for first in range(count):
            for last in range(first, count):
                gain, fall = _interval(linear, blocks, slice(first, last + 1), prior)
                if gain > found.gain:
                    power = float(linear.residual @ linear.residual)
                    low, high = float(linear.edges[first]), float(linear.edges[last + 1])
                    found = _Stretch(gain, power - 2.0 * fall, low, high)
    return found


def _interval(linear: _Linear, blocks: Sequence[_Block], inside: slice, prior: float) -> tuple[float, float]:
    """Return the log Bayes factor of a stretch over base parameters alone, and by how much it lowers the cost, nats.

    The normal matrix is an arrow, a block of curvatures for each photograph beside the shared base parameters.
    """
    normal = linear.base.T @ linear.base + linear.precision
    target = linear.base.T @ linear.residual
    schur, toward, fall, logs = normal.copy(), target.copy(), 0.0, 0.0
    for gram, cross, along in blocks:
        own = gram[inside, inside] + np.eye(inside.stop - inside.start) / prior
        solved = np.linalg.solve(own, np.column_stack((cross[inside], along[inside])))
        schur -= cross[inside].T @ solved[:, :-1]
        toward -= cross[inside].T @ solved[:, -1]
        fall += 0.5 * float(along[inside] @ solved[:, -1])
        logs += float(np.linalg.slogdet(own * prior)[1])
    if target.size:
        fall += 0.5 * float(toward @ np.linalg.solve(schur, toward) - target @ np.linalg.solve(normal, target))
        logs += float(np.linalg.slogdet(schur)[1] - np.linalg.slogdet(normal)[1])
    return float(fall - 0.5 * logs), float(fall)
