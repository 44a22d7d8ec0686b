"""Mean moment of loads on a segment of constant curvature, which is what a constant-curvature joint can feel."""

from __future__ import annotations

import numpy as np

from coast_cli.mechanics.section import FloatArray


def tip_force_arm(curvature: FloatArray, length: float) -> FloatArray:
    """Return the mean lever arm (m) of a transverse tip force: mean over s of x_tip - x(s), for x = sin(kappa s)/kappa."""
    bend = curvature * length
    return length * (np.sinc(bend / np.pi) - 0.5 * np.sinc(bend / (2.0 * np.pi)) ** 2)


def weight_arm(curvature: FloatArray, length: float) -> FloatArray:
    """Return the mean moment (m^2) of a unit transverse line load: mean over s of the integral of x(t) - x(s), t > s.

    Gauss-Legendre in s; the inner integral is closed: (cos(kappa s) - cos(kappa L))/kappa^2 - (L - s) sin(kappa s)/kappa.
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)
    place = 0.5 * length * (nodes + 1.0)
    kappa = np.where(np.abs(curvature * length) < 1e-4, 1e-4 / length, curvature)[..., np.newaxis]
    inner = (np.cos(kappa * place) - np.cos(kappa * length)) / kappa**2 - (length - place) * np.sin(kappa * place) / kappa
    return np.asarray(inner @ (0.5 * weights))
