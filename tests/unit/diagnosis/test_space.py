"""Coordinates, their bounds and priors, and derivatives that stay inside the bounds."""

import numpy as np
import pytest

from coast_cli.diagnosis import space as space_module
from coast_cli.diagnosis.space import (
    BaseParameter,
    Coordinate,
    ParameterSpace,
    bounds_of,
    configured_coordinates,
    inverse,
)
from coast_cli.effects.library.backlash import Backlash

MODULUS = BaseParameter("youngs_modulus_gpa", 45.0, 30.0, 60.0, 0.5, logarithmic=True)
PLAY = BaseParameter("deadband_mm", 1.0, 0.0, 3.0, 1.0)


def coordinate(name="x", **changes):
    return Coordinate(**{"name": name, "value": 1.0, "low": 0.0, "high": 2.0, "width": 1.0, "scale": 1.0, **changes})


def space(*coordinates):
    return ParameterSpace(tuple(coordinates), (), ())


def test_base_parameters_are_fitted_as_logarithms_where_they_are_moduli():
    assert configured_coordinates((MODULUS, PLAY)) == pytest.approx([np.log(45.0), 1.0])
    low, high = bounds_of((MODULUS, PLAY))
    assert low == pytest.approx([np.log(30.0), 0.0])
    assert high == pytest.approx([np.log(60.0), 3.0])
    assert MODULUS.outer(MODULUS.inner) == pytest.approx(45.0)


def test_a_vector_becomes_base_coordinates_and_effects_and_back():
    own = coordinate("width_mm", value=0.3, high=5.0)
    whole = ParameterSpace((coordinate(),), (Backlash(width_mm=0.3),), ((own,),))
    vector = whole.joined(np.array([1.5]))
    assert vector == pytest.approx([1.5, 0.3])
    base, (effect,) = whole.split(np.array([1.2, 0.7]))
    assert base == pytest.approx([1.2])
    assert effect.width_mm == pytest.approx(0.7)


def test_a_start_outside_is_moved_to_the_bound():
    assert space(coordinate()).joined(np.array([7.0])) == pytest.approx([2.0])


STEP = space_module._DIFFERENCE


def derivatives(at, **changes):
    calls = []

    def residuals(vectors):
        calls.extend(float(vector[0]) for vector in vectors)
        return [np.array([vector[0] ** 2, vector[0] ** 3]) for vector in vectors]

    whole = space(coordinate(**changes))
    vector = np.array([at])
    return whole.jacobian(residuals, vector, np.array([at**2, at**3]), whole.moving)[:, 0], calls


def test_derivatives_are_central_and_in_one_batch():
    found, calls = derivatives(1.0)
    assert found == pytest.approx([2.0, 3.0 + STEP**2], rel=1e-9)
    assert len(calls) == 2


@pytest.mark.parametrize("bound", [0.0, 2.0])
def test_derivatives_on_a_bound_are_one_sided_and_look_inside(bound):
    found, calls = derivatives(bound)
    inside = -STEP if bound > 0.0 else STEP
    assert found == pytest.approx([2.0 * bound + inside, 3.0 * bound**2 + 3.0 * bound * inside + STEP**2], rel=1e-9)
    assert len(calls) == 1
    assert 0.0 <= calls[0] <= 2.0


def test_what_has_no_room_does_not_move():
    found, calls = derivatives(1.0, low=1.0, high=1.0)
    assert not calls
    assert not found.any()


def test_only_what_is_expected_counts_in_the_prior_and_the_rest_is_held_weakly():
    whole = space(coordinate(mean=0.5), coordinate())
    vector = np.array([1.5, 1.0])
    assert whole.log_prior(vector) == pytest.approx(-0.5)
    pull = whole.pull(vector)
    assert pull[0] == pytest.approx(1.0)
    assert 0.0 < pull[1] <= 0.5
    assert np.diag(whole.pull_slopes) == pytest.approx([1.0, pull[1]])


def test_a_bound_that_is_touched_is_said():
    assert space(coordinate(), coordinate()).touching(np.array([0.0, 1.0])) == (True, False)


@pytest.mark.parametrize("scale", [1.0, 1e9, 1e18])
def test_a_precision_that_rounding_made_singular_has_a_finite_inverse(scale):
    slopes = np.array([[1.0, 2.0], [1.0, 2.0]]) * scale
    found = inverse(slopes.T @ slopes + np.diag([1.0, 4.0]))
    assert np.all(np.linalg.eigvalsh(found) > 0.0)
    if scale == 1.0:
        assert found @ (slopes.T @ slopes + np.diag([1.0, 4.0])) == pytest.approx(np.eye(2), abs=1e-12)
