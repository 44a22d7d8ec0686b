"""The stroke model: limits, inverse, tip, and what it refuses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coast_cli.errors import BadInput
from coast_cli.mechanics.joint import Joint, Tendon, curvature_from_stroke, stroke, tendon_shortening, tension, tip
from coast_cli.mechanics.tube import NotchedTube


def tube(name, outer, inner, depth, count):
    return NotchedTube(
        name, outer, inner, np.full(count, depth), np.full(count, 3e-4), np.full(count, 3e-4), 45e9, 6450.0
    )


OUTER = tube("OT4", 0.25e-3, 0.2e-3, 0.4e-3, 188)
MIDDLE = tube("MT1", 0.18e-3, 0.14e-3, 0.243e-3, 125)
JOINT = Joint(OUTER, MIDDLE, Tendon(3.8e-5, 53.965e9, 0.38868), 42.6e9, 0.2965, np.pi, 1.0063, 1.2e-3)


@settings(deadline=None)
@given(st.floats(0.0, 80.0), st.floats(0.002, 0.06))
def test_the_inverse_returns_the_curvature(curvature, length):
    there = stroke(JOINT, curvature, length)
    back = curvature_from_stroke(JOINT, there.stroke, length)
    assert back.verdict.converged
    assert float(back.curvature) == pytest.approx(curvature, abs=1e-9)


def test_a_small_bend_shortens_by_its_angle_times_the_lever_arm():
    small = 1e-4
    assert float(tendon_shortening(JOINT, small, 0.02)) == pytest.approx(small * 0.02 * JOINT.lever_arm, rel=1e-5)


def test_the_deadband_bends_nothing():
    inside = curvature_from_stroke(JOINT, np.array([0.0, 0.6e-3, 1.2e-3]), 0.02)
    np.testing.assert_array_equal(inside.curvature, 0.0)
    np.testing.assert_array_equal(inside.tension, 0.0)


def test_friction_multiplies_tension_by_the_capstan_and_each_notch():
    smooth = Joint(OUTER, MIDDLE, JOINT.tendon, 42.6e9, 0.0, np.pi, 1.0, 1.2e-3)
    gain = float(tension(JOINT, 20.0, 0.03) / tension(smooth, 20.0, 0.03))
    assert gain == pytest.approx(np.exp(0.2965 * np.pi) * 1.0063 ** (0.03 / 6e-4))


def test_a_joint_of_one_tube_is_that_tube_alone():
    alone = Joint(None, MIDDLE, None, 42.6e9)
    assert alone.second_moment == pytest.approx(MIDDLE.rigidity_series / 45e9)
    assert alone.lever_arm == pytest.approx(float(MIDDLE.notch.neutral_axis[0]) + 0.14e-3)


def test_a_stroke_without_a_tendon_is_refused():
    with pytest.raises(BadInput, match="tendon"):
        stroke(Joint(None, MIDDLE, None, 42.6e9), 20.0, 0.02)


def test_the_tip_of_an_arc():
    x, y = tip(np.array([0.0, 1e-9, np.pi / 0.04]), 0.02)
    np.testing.assert_allclose(x, [0.02, 0.02, 0.04 / np.pi], rtol=1e-12)
    np.testing.assert_allclose(y, [0.0, 2e-13, 0.04 / np.pi], rtol=1e-9)


def test_closing_comes_first_where_a_notch_is_shortest_for_its_height():
    assert JOINT.closure_curvature < min(3e-4 / (0.18e-3 * 2) / 6e-4, 3e-4 / 0.25e-3 / 6e-4)
