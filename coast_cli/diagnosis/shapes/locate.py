"""Where along the tube the mismatch is: the stretch whose curvature, set free, leaves the rest of the model right.

Differentiating noisy points is avoided: a curvature error in a stretch moves all points beyond it in a known way, so
stretches compete as linear models of the residuals themselves. Curvature is piecewise constant, Gaussian with a width that
is chosen from a few, free in every photograph, base parameters follow; the score is the marginal likelihood, which
pays for every degree of freedom. Under noise alone a Bayes factor exceeds x with probability at most 1/x (Markov), so
looks / factor bounds the p-value. A base rotation competes as a stretch of no length at the clamp.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.diagnosis.locate import Region
from coast_cli.diagnosis.shapes.fit import Fit, Space
from coast_cli.diagnosis.shapes.problem import Problem
from coast_cli.mechanics.section import FloatArray
from coast_cli.units import MILLIMETRE

_BINS = 16
_REFINED = 3
_SIGNIFICANT = 0.01
_WIDTHS = (0.3, 3.0, 30.0)  # of the curvature that turns the tip by one noise width over the tube's length


@dataclass(frozen=True, slots=True)
class _Linear:
    """Residual in noise levels (n,), base directions (n, p) with prior precision (p, p), curvature bins (n, K), rotation (n, 1)."""

    residual: FloatArray
    base: FloatArray
    precision: FloatArray
    bins: FloatArray
    rotation: FloatArray
    edges: FloatArray
    slices: tuple[slice, ...]


def locate(problem: Problem, base: Fit, noise: float, correlation: float = 0.0) -> tuple[Region, ...]:
    """Return the regions that hold the base model's excess error, largest share first; none where it agrees.

    Args:
        noise: of the points, m. correlation: of it between neighbours, by which evidence is worth less.
    """
    length = problem.scene.length
    edges = np.linspace(0.0, length, _BINS + 1)
    linear = _linear(problem, base, noise, edges)
    power = float(linear.residual @ linear.residual)
    found: tuple[float, float, tuple[float, float]] | None = None
    looks = _BINS * (_BINS + 1) // 2 + 1
    gain, left = _rotation(linear)
    best = (gain, left, (0.0, 0.0))
    found = _best_interval(linear)
    if found[0] > best[0]:
        best = found
        for _ in range(_REFINED):
            low, high = best[2]
            if high - low > 2.5 * (edges[1] - edges[0]) or edges[1] - edges[0] < length / 300.0:
                break
            margin = edges[1] - edges[0]
            edges = np.linspace(max(low - margin, 0.0), min(high + margin, length), 9)
            finer = _best_interval(_linear(problem, base, noise, edges))
            looks += 36
            if finer[0] <= best[0]:
                break
            best = finer
    gain, left, (low, high) = best
    floor = float(linear.residual.size)
    known = float(np.clip(correlation, 0.0, 0.95))
    p_value = float(min(1.0, looks * np.exp(-min(gain * (1.0 - known) / (1.0 + known), 700.0))))
    regions = []
    if p_value <= _SIGNIFICANT:
        excess = max(power - floor, 1e-300)
        share = float(np.clip((power - left) / excess, 0.0, 1.0))
        regions.append(Region("arc_length", None, low / MILLIMETRE, high / MILLIMETRE, share, p_value))
        regions += _by_photograph(problem, linear, excess)
    return tuple(sorted(regions, key=lambda region: -region.share))


def _by_photograph(problem: Problem, linear: _Linear, excess: float) -> list[Region]:
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
    return [Region("pair", name, None, None, share, p_value)] if p_value < _SIGNIFICANT and share > 0.5 else []


def _linear(problem: Problem, base: Fit, noise: float, edges: FloatArray) -> _Linear:
    level = max(noise, 1e-12)
    bins = np.zeros((problem.size, edges.size - 1))
    rotation = np.zeros((problem.size, 1))
    state = problem.state(base.coordinates, base.effects)
    lines = problem.forward.lines([(index, state) for index in range(len(problem.photographs))])
    for photograph, line, rows, (across, along) in zip(
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
    space = Space(problem, base.effects)
    return _Linear(
        residual=base.residual / level,
        base=-base.jacobian / level,
        precision=np.diag(1.0 / space.width**2),
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


def _rotation(linear: _Linear) -> tuple[float, float]:
    """Return the gain, nats, and the power left of a rotation at the clamp, the same in all photographs."""
    size = float(np.sum(linear.rotation**2))
    if size <= 0.0:
        return 0.0, float(linear.residual @ linear.residual)
    best = (-np.inf, 0.0)
    for width in _WIDTHS:
        columns = np.concatenate((linear.base, linear.rotation * width / np.sqrt(size) * 10.0), axis=1)
        best = max(best, _evidence(linear, columns, [(1, 1)]))
    return best


def _evidence(linear: _Linear, columns: FloatArray, _: object) -> tuple[float, float]:
    """Return the log Bayes factor over base parameters alone, and the power left; the last columns have unit prior."""
    extra = columns.shape[1] - linear.base.shape[1]
    precision = np.eye(columns.shape[1])
    size = linear.base.shape[1]
    precision[:size, :size] = linear.precision
    return _gain(linear, columns, precision, extra)


def _gain(linear: _Linear, columns: FloatArray, precision: FloatArray, extra: int) -> tuple[float, float]:
    size = columns.shape[1] - extra
    normal = columns.T @ columns + precision
    target = columns.T @ linear.residual
    solution = np.linalg.solve(normal, target)
    small = np.linalg.solve(normal[:size, :size], target[:size]) if size else np.zeros(0)
    fall = 0.5 * (float(target @ solution) - float(target[:size] @ small))
    occam = 0.5 * (np.linalg.slogdet(normal)[1] - (np.linalg.slogdet(normal[:size, :size])[1] if size else 0.0))
    left = linear.residual - columns @ solution
    return float(fall - occam), float(left @ left)


def _best_interval(linear: _Linear) -> tuple[float, float, tuple[float, float]]:
    """Return gain, power left and ends (m) of the best stretch; curvatures are free in every photograph."""
    count = linear.bins.shape[1]
    blocks = []
    for rows in linear.slices:
        bins, base, residual = linear.bins[rows], linear.base[rows], linear.residual[rows]
        blocks.append((bins.T @ bins, bins.T @ base, bins.T @ residual))
    normal = linear.base.T @ linear.base + linear.precision
    target = linear.base.T @ linear.residual
    zero = 0.5 * float(target @ np.linalg.solve(normal, target)) if target.size else 0.0
    zero_log = np.linalg.slogdet(normal)[1] if target.size else 0.0
    power = float(linear.residual @ linear.residual)
    typical = np.sqrt(max(float(np.mean([np.trace(block[0]) for block in blocks])) / count, 1e-300))
    best = (-np.inf, power, (0.0, 0.0))
    for width in _WIDTHS:
        prior = (width * 10.0 / typical) ** 2
        for first in range(count):
            for last in range(first, count):
                inside = slice(first, last + 1)
                schur, toward, fall, logs = normal.copy(), target.copy(), 0.0, 0.0
                for gram, cross, along in blocks:
                    own = gram[inside, inside] + np.eye(last + 1 - first) / prior
                    solved = np.linalg.solve(own, np.column_stack((cross[inside], along[inside])))
                    schur -= cross[inside].T @ solved[:, :-1]
                    toward -= cross[inside].T @ solved[:, -1]
                    fall += 0.5 * float(along[inside] @ solved[:, -1])
                    logs += np.linalg.slogdet(own * prior)[1]
                if target.size:
                    fall += 0.5 * float(toward @ np.linalg.solve(schur, toward))
                    logs += np.linalg.slogdet(schur)[1]
                gain = fall - zero - 0.5 * (logs - zero_log)
                if gain > best[0]:
                    ends = float(linear.edges[first]), float(linear.edges[last + 1])
                    best = (float(gain), power - 2.0 * fall, ends)
    return best
