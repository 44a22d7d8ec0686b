"""Fibre sections against closed forms (elastic-plastic bars, tubes and thin strips) and a fine integration in two dimensions."""

import numpy as np
import pytest
from scipy.optimize import brentq

from coast_cli.mechanics.fibres import bar_fibres, moment_curvature, ring_fibres, strip_fibres
from coast_cli.mechanics.superelastic import Superelastic

MODULUS, YIELD = 50e9, 400e6
PLASTIC = Superelastic(MODULUS, MODULUS, YIELD, 0.4 * YIELD, 1e3)  # a plateau without an end
NITINOL = Superelastic(45e9, 25e9, 450e6, 180e6, 0.046, 0.5e9, 1.25)
RO, RI = 0.25e-3, 0.2e-3


def test_elastic_plastic_bar():
    """M = M_y (1.5 - 0.5 (kappa_y/kappa)^2), any textbook of plasticity."""
    height = 0.1e-3
    first = 2.0 * YIELD / MODULUS / height
    kappa = first * np.array([1.0, 1.3, 2.0, 5.0, 40.0])
    moment, _ = moment_curvature(bar_fibres(1e-3, height, 256), PLASTIC, kappa)
    exact = YIELD * 1e-3 * height**2 / 6.0 * (1.5 - 0.5 * (first / kappa) ** 2)
    assert moment == pytest.approx(exact, rel=3e-5)


def test_fully_plastic_tube():
    """M_p = 4/3 sigma (ro^3 - ri^3)."""
    moment, _ = moment_curvature(ring_fibres(RO, RI, 256), PLASTIC, [200.0 * YIELD / MODULUS / RO])
    assert moment[0] == pytest.approx(4.0 / 3.0 * YIELD * (RO**3 - RI**3), rel=1e-4)


@pytest.mark.parametrize("depth", [1.1, 1.4, 1.7])
def test_fully_plastic_thin_strip(depth):
    """An arc of half angle a yields about its quarter points: M_p = 2 sigma t r^2 (2 sin(a/2) - sin a)."""
    outer, inner = RO, 0.9998 * RO
    half = np.arccos(depth - 1.0)
    moment, _ = moment_curvature(strip_fibres(outer, inner, depth * RO, layers=1024), PLASTIC, [1e5])
    mean, wall = (outer + inner) / 2.0, outer - inner
    exact = 2.0 * YIELD * wall * mean**2 * (2.0 * np.sin(half / 2.0) - np.sin(half))
    assert moment[0] == pytest.approx(exact, rel=2e-3)


def cells(kind, depth, count=700):
    """Small cells of a notched section: height above the axis and area of each."""
    radius = np.linspace(RI, RO, count // 4 + 1)
    radius = 0.5 * (radius[1:] + radius[:-1])
    half = np.arccos((depth - RO) / RO) if kind == "sector" else np.pi
    angle = half * (np.arange(4 * count) + 0.5) / (4 * count)
    area = np.broadcast_to(
        (radius * (RO - RI) / radius.size * 2.0 * half / angle.size)[:, None], (radius.size, angle.size)
    )
    height = radius[:, None] * np.cos(angle)
    kept = height > depth - RO if kind == "chord" else np.ones_like(height, dtype=bool)
    return height[kept], area[kept]


@pytest.mark.parametrize("kind", ["sector", "chord"])
@pytest.mark.parametrize("depth", [0.314e-3, 0.4e-3])
def test_against_two_dimensions(kind, depth):
    height, area = cells(kind, depth)
    fibres = strip_fibres(RO, RI, depth, kind)
    kappa = np.array([-900.0, -300.0, 300.0, 900.0])
    moment, _ = moment_curvature(fibres, NITINOL, kappa)
    for bend, mine in zip(kappa, moment, strict=True):

        def stress(axis, bend=bend):
            return NITINOL.loading_stress(bend * (height - axis))

        axis = brentq(lambda axis: float(stress(axis) @ area), -RO, 2.0 * RO)
        assert mine == pytest.approx(float(stress(axis) @ (area * height)), rel=2e-3)
