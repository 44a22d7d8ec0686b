"""Random tubes against scipy's integrators: the answer is integrated from the tip and must arrive at the clamp."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp

from coast_cli.mechanics.beam import solve_beam, solve_segments
from coast_cli.mechanics.tube import NotchedTube

GRAVITY = 9.81


def random_tube(seed: int) -> NotchedTube:
    """A tube of few but long notches, graded and unequal, to 122 degrees and more."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 9))
    ro = rng.uniform(0.15e-3, 0.3e-3)
    shares = rng.uniform(0.3, 1.0, (2, count))
    cut, uncut = rng.uniform(0.03, 0.12) * shares / shares.sum()
    return NotchedTube(
        f"random {seed}",
        ro,
        rng.uniform(0.7, 0.88) * ro,
        rng.uniform(1.1, 1.75, count) * ro,
        cut,
        uncut,
        rng.uniform(40e9, 75e9),
        6450.0,
        rng.uniform(-15.0, 15.0),
        section=str(rng.choice(["sector", "chord"])),
    )


def clamp_from_tip(tube: NotchedTube, tip_angle: float) -> np.ndarray:
    """Integrate theta, M, x, y, V piece by piece from the tip to the clamp with an order-8 Runge-Kutta method."""
    state = np.array([tip_angle, 0.0, 0.0, 0.0, 0.0])
    pieces = tube.segments
    for length, rigidity, weight in zip(pieces.length[::-1], pieces.rigidity[::-1], pieces.weight[::-1], strict=True):

        def slope(_, state, rigidity=rigidity, weight=weight):
            angle, moment, _, _, shear = state
            cosine = np.cos(angle)
            return [
                moment / rigidity - tube.natural_curvature,
                shear * cosine,
                cosine,
                np.sin(angle),
                weight * GRAVITY,
            ]

        state = solve_ivp(slope, (0.0, length), state, method="DOP853", rtol=1e-11, atol=1e-15).y[:, -1]
    return state


@pytest.mark.parametrize("block", range(10))
def test_two_hundred_random_tubes(block):
    for seed in range(20 * block, 20 * block + 20):
        tube = random_tube(seed)
        solution = solve_beam(tube, GRAVITY)
        assert solution.verdict.converged
        angle, moment, x, y, _ = clamp_from_tip(tube, solution.tip_angle)
        assert abs(angle) < 1e-9
        assert solution.moment[0] == pytest.approx(-moment, rel=1e-8)
        assert np.hypot(solution.x[-1] - x, solution.y[-1] - y) < 1e-10 * tube.length


def test_a_boundary_value_solver_agrees():
    length, rigidity, weight, curvature = 0.1, 3e-6, 2e-3, 6.0
    solution = solve_segments(length, rigidity, weight, curvature, gravity=(0.0, -GRAVITY))

    def slope(s, state):
        return np.stack((curvature - state[1] / rigidity, -weight * GRAVITY * (length - s) * np.cos(state[0])))

    s = np.linspace(0.0, length, 200)
    found = solve_bvp(slope, lambda start, end: np.array([start[0], end[1]]), s, np.zeros((2, 200)), tol=1e-8)
    assert found.success
    assert solution.angle[0, -1] == pytest.approx(found.y[0, -1], abs=1e-7)
