"""Very soft beams hang; their equilibrium is held to the equations piece by piece by an integrator of its own."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.mechanics.beam import solve_beam, solve_segments
from coast_cli.mechanics.tube import NotchedTube

GRAVITY = 9.81


def tube(count=188, natural_curvature=-5.0, modulus=45e9):
    one = np.ones(count)
    notch = 0.35e-3 * one, 0.3e-3 * one, 0.3e-3 * one
    return NotchedTube("t", 0.2e-3, 0.165e-3, *notch, modulus, 6450.0, natural_curvature)


def missed(tube, solution):
    """How far each piece, crossed by classic Runge-Kutta from its clamp side, misses its tip side: rad, and N m."""
    pieces = tube.segments
    beyond = np.append(np.cumsum((pieces.weight * pieces.length)[::-1])[::-1], 0.0) * GRAVITY
    angle, moment, shear = solution.angle[:-1], solution.moment[:-1], beyond[:-1]
    steps = 64
    h = pieces.length / steps

    def slopes(angle, moment, shear):
        return tube.natural_curvature + moment / pieces.rigidity, shear * np.cos(angle)

    for _ in range(steps):
        half, after = shear - pieces.weight * GRAVITY * h / 2.0, shear - pieces.weight * GRAVITY * h
        a = slopes(angle, moment, shear)
        b = slopes(angle + h / 2.0 * a[0], moment + h / 2.0 * a[1], half)
        c = slopes(angle + h / 2.0 * b[0], moment + h / 2.0 * b[1], half)
        d = slopes(angle + h * c[0], moment + h * c[1], after)
        angle = angle + h / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0])
        moment = moment + h / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1])
        shear = after
    return np.max(np.abs(angle - solution.angle[1:])), np.max(np.abs(moment - solution.moment[1:]))


@pytest.mark.parametrize(
    "soft",
    [
        tube(800),
        tube(1400, 5.0),
        tube(2000),
        tube(2000, 5.0),
        tube(modulus=1e9),
        tube(modulus=0.1e9, natural_curvature=5.0),
    ],
    ids=["800 notches", "1,400", "2,000", "2,000 against gravity", "1 GPa", "0.1 GPa"],
)
def test_soft_tubes_hang_in_equilibrium(soft):
    solution = solve_beam(soft, GRAVITY)
    assert solution.verdict.converged
    assert solution.angle[0] == pytest.approx(0.0, abs=1e-12)
    assert solution.moment[-1] == pytest.approx(0.0, abs=1e-18)
    angle, moment = missed(soft, solution)
    assert angle < 1e-11
    assert moment < 1e-11 * np.max(np.abs(solution.moment))
    turned = np.diff(solution.x) ** 2 + np.diff(solution.y) ** 2
    assert np.all(turned <= soft.segments.length**2 * (1.0 + 1e-12))


def test_the_end_of_a_long_tube_hangs_straight_down_but_for_its_natural_curvature():
    """Far from the clamp nothing but the natural curvature bends; a longer tube hangs alike beneath."""
    two, three = (solve_beam(tube(count), GRAVITY) for count in (1000, 1200))
    assert three.tip_angle == pytest.approx(two.tip_angle, abs=1e-6)
    assert three.angle[60] == pytest.approx(two.angle[60], abs=0.1)


def test_soft_and_ordinary_beams_side_by_side():
    tubes = [tube(188), replace(tube(188), youngs_modulus=0.3e9)]
    columns = [np.stack([getattr(one.segments, name) for one in tubes]) for name in ("length", "rigidity", "weight")]
    both = solve_segments(*columns, -5.0, gravity=(0.0, -GRAVITY))
    assert both.converged.all()
    for row, one in enumerate(tubes):
        assert both.angle[row] == pytest.approx(solve_beam(one, GRAVITY).angle, abs=1e-11)


def test_what_is_too_soft_names_the_bound_that_it_met():
    verdict = solve_beam(tube(modulus=1e6), GRAVITY).verdict
    assert not verdict.converged
    assert "load number is 7.38e+04; beams are followed to 10000" in verdict.message
