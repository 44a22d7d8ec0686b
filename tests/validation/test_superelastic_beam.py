"""A superelastic tube under a heavy load against scipy: the same law, marched by an adaptive solver from the tip."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from coast_cli.design.shape import shape_columns
from coast_cli.mechanics.fibres import moment_curvature, strip_fibres
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tube import NotchedTube

COUNT = 40
ONE = np.ones(COUNT)
LAW = Superelastic(45e9, 25e9, 350e6, 150e6, 0.046, 0.5e9, 1.3)
TUBE = NotchedTube("tube", 0.25e-3, 0.2e-3, 0.36e-3 * ONE, 4e-4 * ONE, 3e-4 * ONE, 45e9, 6450.0, 3.0, superelastic=LAW)
HEAVY = 4000.0  # m/s^2


def marched(tube, law, gravity):
    """Tip (x, y, angle) by pieces from the clamp, the clamp's moment found by root search; `law` gives bend from moment."""
    pieces = tube.segments
    total = float(pieces.weight @ pieces.length) * gravity

    def march(moment):
        state, shear = np.array([0.0, moment, 0.0, 0.0]), total
        for index, (length, rigidity, weight) in enumerate(
            zip(pieces.length, pieces.rigidity, pieces.weight, strict=True)
        ):

            def slope(s, y, index=index, rigidity=rigidity, weight=weight, shear=shear):
                bend = law(y[1]) if index % 2 else y[1] / rigidity
                return [
                    tube.natural_curvature + bend,
                    (shear - weight * gravity * s) * np.cos(y[0]),
                    np.cos(y[0]),
                    np.sin(y[0]),
                ]

            state = solve_ivp(slope, (0.0, length), state, rtol=1e-9, atol=1e-14).y[:, -1]
            shear -= weight * gravity * length
        return state

    moment = brentq(lambda moment: march(moment)[1], -total * tube.length, 0.0, xtol=1e-14)
    return march(moment)


@pytest.mark.parametrize("natural", [3.0, -3.0])
def test_the_tip_of_a_tube_past_its_plateau(natural):
    tube = replace(TUBE, natural_curvature=natural)
    side = np.sign(natural)
    bends = np.concatenate([-np.geomspace(2000.0, 1.0, 4000), [0.0], np.geomspace(1.0, 2000.0, 4000)])
    moments = moment_curvature(strip_fibres(0.25e-3, 0.2e-3, 0.36e-3), LAW, bends)[0]
    angle, _, x, y = marched(tube, lambda moment: side * np.interp(side * moment, moments, bends), HEAVY)
    found = shape_columns([tube], HEAVY, method="arc")
    length = tube.length * 1e3
    linear = shape_columns([replace(tube, superelastic=None)], HEAVY, method="arc")
    assert np.hypot(found["x_mm"][-1] - linear["x_mm"][-1], found["y_mm"][-1] - linear["y_mm"][-1]) > 0.04 * length
    assert found["x_mm"][-1] == pytest.approx(1e3 * x, abs=1e-3 * length)
    assert found["y_mm"][-1] == pytest.approx(1e3 * y, abs=1e-3 * length)
    assert found["angle_deg"][-1] == pytest.approx(np.degrees(angle), abs=0.1)


def test_below_the_plateau_the_shape_is_the_linear_one():
    for points in (None, 50):
        found, linear = (
            shape_columns([tube], 9.81, method="arc", points=points)
            for tube in (TUBE, replace(TUBE, superelastic=None))
        )
        for name in ("x_mm", "y_mm", "angle_deg", "curvature_per_m"):
            np.testing.assert_array_equal(found[name], linear[name])
