"""Every solver declares its order; here it is held to it."""

import numpy as np
import pytest

from coast_cli.errors import NotConverged
from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.beam.problem import BeamProblem, BeamTrace, march_shape, march_turn
from coast_cli.mechanics.beam.projected import solve_beam_projected
from coast_cli.mechanics.tube import NotchedTube


def uniform(parts: int) -> BeamProblem:
    """A heavy strip, one metre long, with force and moment at its tip, in equal pieces."""
    one = np.ones((parts, 1)) / parts
    return BeamProblem(
        length=one,
        flexibility=one / 0.7,
        bend=0.9 * one,
        load=2.1 * one,
        thrust=np.array([0.4]),
        shear=np.array([0.3]),
        moment=np.array([0.2]),
        base=np.zeros(1),
    )


def shot(parts: int) -> np.ndarray:
    problem = uniform(parts)
    trace = BeamTrace(problem)
    turn, _ = march_shape(problem, np.cos(0.5), np.sin(0.5), trace)
    return np.array([turn, trace.moment[0, 0], trace.x[0, 0], trace.y[0, 0]])


def test_the_step_is_of_order_six():
    exact = shot(1024)
    errors = np.array([np.abs(shot(parts) - exact) for parts in (16, 32, 64)])
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 6.0) < 0.2)


def test_the_tangent_is_of_order_three():
    def error(parts: int) -> float:
        problem, step = uniform(parts), 1e-30
        angle = 0.5 + 1j * step
        exact = 1.0 + np.imag(march_turn(problem, np.cos(angle), np.sin(angle))) / step
        return abs(march_shape(problem, np.cos(0.5), np.sin(0.5), BeamTrace(problem))[1] - exact)

    errors = np.array([error(parts) for parts in (8, 16, 32, 64)])
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 3.0) < 0.25)


def tube(natural_curvature: float) -> NotchedTube:
    one = np.ones(188)
    return NotchedTube(
        "reference", 0.2e-3, 0.165e-3, 0.35e-3 * one, 0.3e-3 * one, 0.3e-3 * one, 45e9, 6450.0, natural_curvature
    )


def projected_error(natural_curvature: float, load_steps: int, weight_per: str) -> float:
    exact = solve_beam(tube(natural_curvature), 9.81)
    found = solve_beam_projected(tube(natural_curvature), 9.81, load_steps=load_steps, weight_per=weight_per)
    return float(np.hypot(found.x[-1] - exact.x[-1], found.y[-1] - exact.y[-1]))


@pytest.mark.parametrize("natural_curvature", [5.0, -5.0])
def test_the_projected_method_is_of_first_order_in_its_load_steps(natural_curvature):
    errors = np.array([projected_error(natural_curvature, steps, "arc_length") for steps in (20, 40, 80, 160)])
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 1.0) < 0.05)
    assert 0.8e-3 < errors[0] < 1.5e-3


LONG_NOTCH_DEPTHS_MM = (0.314, 0.350, 0.376, 0.400)  # P's four outer tubes; diameters and lengths are ours


def long_notch_error(depth_mm: float, load_steps: int) -> float:
    """Return how far off the tip of a steel tube is (m), 0.5 x 0.4 mm, with one notch of 110 mm, as P's Fig. 6 has it."""
    one = np.ones(1)
    steel = NotchedTube("steel", 0.25e-3, 0.2e-3, depth_mm * 1e-3 * one, 0.11 * one, 2e-3 * one, 200e9, 8000.0)
    exact = solve_beam(steel, 9.81)
    found = solve_beam_projected(steel, 9.81, load_steps=load_steps)
    return float(np.hypot(found.x[-1] - exact.x[-1], found.y[-1] - exact.y[-1]))


@pytest.mark.parametrize("depth_mm", LONG_NOTCH_DEPTHS_MM)
def test_one_long_notch_is_divided_until_only_the_load_steps_err(depth_mm):
    errors = np.array([long_notch_error(depth_mm, steps) for steps in (5, 10, 20)])
    assert errors[-1] < 0.02e-3
    assert np.all(np.abs(np.log2(errors[:-1] / errors[1:]) - 1.0) < 0.1)


@pytest.mark.parametrize("natural_curvature", [5.0, -5.0])
def test_the_projected_method_as_printed_does_not_converge(natural_curvature):
    errors = [projected_error(natural_curvature, steps, "projected_length") for steps in (20, 80, 320)]
    assert all(10e-3 < error < 22e-3 for error in errors)


def test_the_projected_method_refuses_past_90_degrees():
    with pytest.raises(NotConverged, match="90 degrees"):
        solve_beam_projected(tube(-15.0), 9.81)
