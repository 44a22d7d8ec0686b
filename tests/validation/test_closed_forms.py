"""Beams whose answer is known in closed form or as a power series."""

import numpy as np
import pytest
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from coast_cli.mechanics.beam import solve_segments

LENGTH, RIGIDITY = 0.1, 3e-6


def uniform(parts=7, **loads):
    """A uniform beam in unequal pieces."""
    share = np.arange(1.0, parts + 1.0)
    curvature, weight = loads.pop("natural_curvature", 0.0), loads.pop("weight", 0.0)
    return solve_segments(LENGTH * share / share.sum(), RIGIDITY, weight, curvature, **loads).beam(0)


@pytest.mark.parametrize("modulus_squared", [0.52, 0.6, 0.75, 0.9, 0.99])
def test_elastica_with_a_force_at_its_tip(modulus_squared):
    # Bisshopp and Drucker, Quarterly of Applied Mathematics 3 (1945): sin(tip angle) = 2 k^2 - 1.
    k2 = modulus_squared
    start = np.arcsin(np.sqrt(0.5 / k2))
    alpha = ellipk(k2) - ellipkinc(start, k2)
    force = alpha**2 * RIGIDITY / LENGTH**2
    solution = uniform(tip_force=(0.0, -force))
    sine = 2.0 * k2 - 1.0
    assert solution.verdict.converged
    assert solution.tip_angle == pytest.approx(-np.arcsin(sine), abs=1e-10)
    assert solution.x[-1] == pytest.approx(LENGTH * np.sqrt(2.0 * sine) / alpha, abs=1e-11 * LENGTH)
    down = LENGTH * (1.0 - 2.0 / alpha * (ellipe(k2) - ellipeinc(start, k2)))
    assert solution.y[-1] == pytest.approx(-down, abs=1e-11 * LENGTH)


def heavy_series(load_number: float, tip_angle: float, terms: int = 90) -> float:
    """Angle at the clamp of a heavy uniform beam by its power series from the tip (Rohde, 1953): t'' = 6 N r cos t."""
    angle, cosine, sine = np.zeros(terms), np.zeros(terms), np.zeros(terms)
    angle[0], cosine[0], sine[0] = tip_angle, np.cos(tip_angle), np.sin(tip_angle)
    for n in range(terms - 2):
        if n > 0:
            j = np.arange(1, n + 1)
            cosine[n] = -np.sum(j * angle[j] * sine[n - j]) / n
            sine[n] = np.sum(j * angle[j] * cosine[n - j]) / n
        angle[n + 2] = 6.0 * load_number * (cosine[n - 1] if n > 0 else 0.0) / ((n + 1) * (n + 2))
    return float(angle.sum())


@pytest.mark.parametrize("load_number", [0.01, 0.3, 0.9, 1.5])
def test_beam_under_its_own_weight(load_number):
    gravity = 9.81
    weight = 6.0 * load_number * RIGIDITY / LENGTH**3 / gravity
    solution = uniform(weight=weight, gravity=(0.0, -gravity))
    assert solution.verdict.converged
    assert heavy_series(load_number, solution.tip_angle) == pytest.approx(0.0, abs=1e-10)


def test_small_deflections():
    load = 1e-6 * RIGIDITY / LENGTH**3
    solution = uniform(weight=load, gravity=(0.0, -1.0))
    assert solution.tip_angle == pytest.approx(-load * LENGTH**3 / (6.0 * RIGIDITY), rel=1e-9)
    assert solution.y[-1] == pytest.approx(-load * LENGTH**4 / (8.0 * RIGIDITY), rel=1e-9)


@pytest.mark.parametrize("curvature", [-60.0, 0.0, 3.0, 200.0])
def test_pure_bending_is_an_arc(curvature):
    solution = uniform(natural_curvature=0.25 * curvature, tip_moment=0.75 * curvature * RIGIDITY)
    assert solution.angle == pytest.approx(curvature * solution.s, abs=1e-12 * max(1.0, abs(curvature)))
    assert solution.x[-1] == pytest.approx(LENGTH * np.sinc(curvature * LENGTH / np.pi), abs=1e-13)
    assert solution.moment == pytest.approx(np.full(8, 0.75 * curvature * RIGIDITY), abs=1e-18)


@pytest.mark.parametrize(("load_number", "equilibria"), [(1.25, 1), (1.4, 3)])
def test_column_buckles_under_its_own_weight(load_number, equilibria):
    # Greenhill (1881): w L^3 / EI = 7.837, which is a load number of 1.306.
    weight = 6.0 * load_number * RIGIDITY / LENGTH**3
    solution = solve_segments(
        np.full(16, LENGTH / 16), RIGIDITY, weight, 1e-3, gravity=(0.0, -1.0), base_angle=np.pi / 2.0
    )
    assert solution.converged.all()
    assert solution.equilibria[0] == equilibria


def test_a_hanging_beam_hangs():
    solution = uniform(weight=1e-3, gravity=(0.0, -9.81), base_angle=-np.pi / 2.0)
    assert solution.tip_angle == pytest.approx(-np.pi / 2.0, abs=1e-14)
    assert solution.y[-1] == pytest.approx(-LENGTH, abs=1e-15)


@pytest.mark.parametrize("turned", [0.3, -2.0, 3.0])
def test_turning_everything_turns_the_shape(turned):
    cosine, sine = np.cos(turned), np.sin(turned)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    gravity, force = np.array([0.0, -9.81]), np.array([2e-4, 1e-4])
    loads = {"weight": 2e-4, "natural_curvature": 4.0, "tip_moment": 1e-6}
    straight = uniform(**loads, gravity=gravity, tip_force=force)
    tilted = uniform(**loads, gravity=turn @ gravity, tip_force=turn @ force, base_angle=turned)
    assert tilted.angle == pytest.approx(straight.angle + turned, abs=1e-13)
    assert np.stack((tilted.x, tilted.y)) == pytest.approx(turn @ np.stack((straight.x, straight.y)), abs=1e-14)
