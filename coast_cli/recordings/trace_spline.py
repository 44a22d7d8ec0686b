"""A smoothing spline along the tube, robust to what notches and dust leave behind, and the circle of least squares.

The spline is penalised by its third derivative, so that where the points say little it goes on with the curvature it
has. How smooth it is, is chosen by the Bayesian information criterion on the number of *independent* points (P uses
MARS for the same purpose); points far off are weighed down with Tukey's biweight. The circle is fitted by least squares
of distances in the form of Chernov and Lesort (J. Math. Imaging Vis. 23, 239-252, 2005), which holds for straight lines
too, and gives the curvature with its sign and uncertainty.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DEGREE = 5
SPANS = 16


@dataclass(frozen=True)
class SplineCurve:
    """A plane curve by arc length, pixels, rows counting down.

    Attributes:
        length: of the curve.
        knots: of the spline in its parameter.
        coefficients: of x and y, shape (m, 2).
        parameter, arc: a table of the parameter against arc length.
        covariance: of one coordinate's coefficients, correlation along the tube allowed for, shape (m, m).
        spread: standard deviation of the points about the curve.
        independent: number of independent points.
    """

    length: float
    knots: Floats
    coefficients: Floats
    parameter: Floats
    arc: Floats
    covariance: Floats
    spread: float
    independent: float

    def at(self, s: Floats) -> tuple[Floats, Floats, Floats]:
        """Return x, y and the angle of the tangent (positive towards the top of the image), straight past the ends."""
        from scipy.interpolate import BSpline

        inside = np.clip(s, 0.0, self.length)
        parameter = np.interp(inside, self.arc, self.parameter)
        spline = BSpline(self.knots, self.coefficients, DEGREE)
        x, y = spline(parameter).T
        dx, dy = spline(parameter, 1).T
        speed = np.hypot(dx, dy)
        over = s - inside
        return x + over * dx / speed, y + over * dy / speed, np.arctan2(-dy, dx)

    def std(self, s: Floats) -> Floats:
        """Return the standard deviation across the curve at arc lengths ``s``."""
        parameter = np.interp(s, self.arc, self.parameter)
        basis = _basis(parameter, self.knots)
        return np.asarray(np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", basis, self.covariance, basis), 0.0)))


@dataclass(frozen=True)
class Arc:
    """A circle (or line) of least squares through points in order.

    Attributes:
        curvature: 1/pixel, positive when it turns left on the image.
        std: standard deviation of the curvature, correlation along the tube allowed for.
        spread: root mean square distance of the points, pixels.
        parameters: A, the direction of (B, C) and D, in units of ``size`` about ``centre``, y upwards.
    """

    curvature: float
    std: float
    spread: float
    parameters: tuple[float, float, float]
    centre: tuple[float, float]
    size: float

    def foot(self, x: float, y: float) -> tuple[float, float, float]:
        """Return the nearest point of the circle and the angle of its tangent there."""
        u, v = (x - self.centre[0]) / self.size, -(y - self.centre[1]) / self.size
        A, direction, D = self.parameters
        distance = float(_distances(np.array(self.parameters), np.array([u]), np.array([v]))[0][0])
        E = np.sqrt(1 + 4 * A * D)
        outward = np.array([2 * A * u + E * np.cos(direction), 2 * A * v + E * np.sin(direction)])
        outward /= np.hypot(*outward)
        angle = float(np.arctan2(outward[0], -outward[1]))
        return x - distance * outward[0] * self.size, y + distance * outward[1] * self.size, angle


def fit_curve(t: Floats, x: Floats, y: Floats, low: float, high: float, *, grain: float = 1.0) -> SplineCurve:
    """Return the smoothing spline of points in order.

    Args:
        t: parameter of the points, near arc length, increasing, shape (n,).
        x, y: the points, pixels.
        low, high: ends of the curve in that parameter.
        grain: points nearer to each other than this do not count as independent.
    """
    points = np.stack([x, y], axis=1)
    knots = _knots(low, high)
    basis = _basis(t, knots)
    penalty = _penalty(knots) * (high - low) ** 5 * t.size
    best: tuple[float, Floats, Floats, Floats, float, float] | None = None
    start = np.ones(t.size)
    for strength in 10.0 ** np.arange(-13.0, -4.0):
        coefficients, weight, inverse = _robust_fit(basis, points, strength * penalty, start, 8 if best is None else 3)
        start = weight
        residual = _across(basis, points, coefficients, knots, t)
        used = weight > 0
        variance = float(np.sum(weight * residual**2) / max(weight.sum(), 1.0)) + 1e-8
        independent = float(used.sum()) / _correlation_sum(residual[used])
        independent = max(min(independent, (high - low) / grain), 12.0)
        freedom = float(np.einsum("ij,jk,ik,i->", basis, inverse, basis, weight))
        score = independent * np.log(variance) + freedom * np.log(independent)
        if best is None or score < best[0]:
            best = (score, coefficients, weight, inverse, variance, independent)
    if best is None:
        message = "no smoothness was tried"
        raise ValueError(message)
    _, coefficients, weight, inverse, variance, independent = best
    covariance = inverse * variance * weight.size / independent
    table = np.linspace(low, high, 2001)
    arc = _arc_length(knots, coefficients, table)
    return SplineCurve(
        float(arc[-1]), knots, coefficients, table, arc, covariance, float(np.sqrt(variance)), independent
    )


def _knots(low: float, high: float) -> Floats:
    inner = np.linspace(low, high, SPANS + 1)
    return np.concatenate([np.full(DEGREE, low), inner, np.full(DEGREE, high)])


def _basis(t: Floats, knots: Floats) -> Floats:
    from scipy.interpolate import BSpline

    inside = np.clip(t, knots[0], knots[-1])
    return np.asarray(BSpline.design_matrix(inside, knots, DEGREE).toarray())


def _penalty(knots: Floats) -> Floats:
    """Integrals of products of the third derivatives of the basis, by Gauss's rule on each span (exact)."""
    from scipy.interpolate import BSpline

    nodes, weights = np.polynomial.legendre.leggauss(3)
    edges = knots[DEGREE:-DEGREE]
    half = np.diff(edges) / 2
    at = ((edges[1:] + edges[:-1]) / 2)[:, None] + half[:, None] * nodes
    third = BSpline(knots, np.eye(knots.size - DEGREE - 1), DEGREE)(at.ravel(), 3)
    return np.asarray(third.T @ (third * (half[:, None] * weights).ravel()[:, None]))


def _robust_fit(
    basis: Floats, points: Floats, penalty: Floats, weight: Floats, rounds: int
) -> tuple[Floats, Floats, Floats]:
    """Return coefficients, weights of the points, and the inverse of the normal matrix."""
    coefficients = np.zeros((basis.shape[1], 2))
    inverse: Floats = np.zeros_like(penalty)
    for _ in range(rounds):
        weighted = basis * weight[:, None]
        inverse = np.asarray(np.linalg.pinv(basis.T @ weighted + penalty, rcond=1e-15, hermitian=True), dtype=float)
        coefficients = inverse @ (weighted.T @ points)
        off = np.linalg.norm(points - basis @ coefficients, axis=1)
        scale = max(1.4826 * float(np.median(off)), 0.02)
        weight = np.clip(1 - (off / (4.685 * scale)) ** 2, 0, 1) ** 2
    return coefficients, weight, inverse


def _across(basis: Floats, points: Floats, coefficients: Floats, knots: Floats, t: Floats) -> Floats:
    from scipy.interpolate import BSpline

    tangent = BSpline(knots, coefficients, DEGREE)(np.clip(t, knots[0], knots[-1]), 1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    off = points - basis @ coefficients
    return np.asarray(off[:, 0] * tangent[:, 1] - off[:, 1] * tangent[:, 0])


def _correlation_sum(residual: Floats) -> float:
    """Points per independent point: twice the integrated autocorrelation time, window by Sokal's rule."""
    n = residual.size
    centred = residual - residual.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    correlation = np.fft.irfft(spectrum)[: n // 2]
    if correlation.size == 0 or correlation[0] <= 0:
        return 1.0
    sums = 2 * np.cumsum(correlation / correlation[0]) - 1
    window = np.arange(sums.size) >= 5 * sums
    chosen = int(np.argmax(window)) if window.any() else sums.size - 1
    return float(max(sums[chosen], 1.0))


def _arc_length(knots: Floats, coefficients: Floats, table: Floats) -> Floats:
    from scipy.interpolate import BSpline

    spline = BSpline(knots, coefficients, DEGREE)
    middle = (table[1:] + table[:-1]) / 2
    speed = [np.linalg.norm(spline(part, 1), axis=1) for part in (table[:-1], middle, table[1:])]
    pieces = (speed[0] + 4 * speed[1] + speed[2]) / 6 * np.diff(table)  # Simpson
    return np.concatenate([[0.0], np.cumsum(pieces)])


def fit_arc(x: Floats, y: Floats) -> Arc:
    """Return the circle (or line) of least squares of distances through points in order, with robust weights.

    The circle is A z + B x + C y + D = 0, z = x^2 + y^2, B^2 + C^2 - 4 A D = 1; the signed distance of a point is
    2 P / (1 + sqrt(1 + 4 A P)), P the left side, and the curvature 2 A.
    """
    centre = np.array([x.mean(), y.mean()])
    size = float(np.hypot(x - centre[0], y - centre[1]).max())
    u, v = (x - centre[0]) / size, -(y - centre[1]) / size  # v up
    parameters: Floats = _pratt_start(u, v)
    weight = np.ones(u.size)
    jacobian = np.zeros((u.size, 3))
    distance = np.zeros(u.size)
    for _ in range(60):
        distance, jacobian = _distances(parameters, u, v)
        scale = max(1.4826 * float(np.median(np.abs(distance))), 1e-9)
        weight = np.clip(1 - (distance / (6 * scale)) ** 2, 0, 1) ** 2
        root = np.sqrt(weight)
        step = np.asarray(np.linalg.lstsq(jacobian * root[:, None], -distance * root, rcond=None)[0], dtype=float)
        step *= min(1.0, 0.5 / (np.abs(step).max() + 1e-300))
        parameters = np.asarray(parameters + step)
        if np.abs(step).max() < 1e-10:
            break
    inflation = _correlation_sum(distance[weight > 0])
    variance = float(np.sum(weight * distance**2) / max(weight.sum() - 3, 1.0))
    covariance = np.linalg.pinv(jacobian.T @ (jacobian * weight[:, None]), hermitian=True) * variance * inflation
    A, direction, D = (float(value) for value in parameters)
    return Arc(
        curvature=2 * A / size,
        std=2 * float(np.sqrt(covariance[0, 0])) / size,
        spread=float(np.sqrt(variance)) * size,
        parameters=(A, direction, D),
        centre=(float(centre[0]), float(centre[1])),
        size=size,
    )


def _pratt_start(u: Floats, v: Floats) -> Floats:
    """Pratt's algebraic circle (Computer Graphics 21, 145-152, 1987): A, the direction of (B, C), and D."""
    rows = np.stack([u**2 + v**2, u, v, np.ones_like(u)], axis=1)
    norm = np.array([[0.0, 0, 0, -2], [0, 1, 0, 0], [0, 0, 1, 0], [-2, 0, 0, 0]])
    values, vectors = np.linalg.eig(np.linalg.solve(norm, rows.T @ rows / u.size))
    size = np.einsum("ik,ij,jk->k", vectors.real, norm, vectors.real)
    best = int(np.argmin(np.where(size > 1e-12, values.real, np.inf)))
    A, B, C, D = vectors[:, best].real / np.sqrt(size[best])
    left = np.stack([-np.gradient(v), np.gradient(u)])
    outward = np.stack([2 * A * u + B, 2 * A * v + C])
    if np.sum(left * outward) > 0:  # positive curvature turns left: its centre lies there
        A, B, C, D = -A, -B, -C, -D
    return np.array([A, np.arctan2(C, B), D])


def _distances(parameters: Floats, u: Floats, v: Floats) -> tuple[Floats, Floats]:
    A, direction, D = parameters
    E = np.sqrt(max(1 + 4 * A * D, 1e-6))
    cos, sin = np.cos(direction), np.sin(direction)
    z = u**2 + v**2
    along = u * cos + v * sin
    P = A * z + E * along + D
    Q = np.sqrt(np.maximum(1 + 4 * A * P, 1e-6))
    distance = 2 * P / (1 + Q)
    by_P = 1 / Q
    by_A_alone = -4 * P**2 / (Q * (1 + Q) ** 2)
    P_by_A = z + 2 * D / E * along
    P_by_direction = E * (v * cos - u * sin)
    P_by_D = 1 + 2 * A / E * along
    jacobian = np.stack([by_P * P_by_A + by_A_alone, by_P * P_by_direction, by_P * P_by_D], axis=1)
    return distance, jacobian
