"""The body along a path: exact where a path is one, honest about the distance where it is not."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid

from coast_cli.design.follow_leader import Body, deviation, follow_path, nearest_body
from coast_cli.recordings.planar_path import path_of_curvature

LONGEST = 0.075
ONE_BEND = {
    "arc": ([0.0, 0.05], [30.0, 30.0], Body(0.0, 0.05, 30.0)),
    "lead, arc": ([0.0, 0.02, 0.02 + 1e-9, 0.06], [0.0, 0.0, -20.0, -20.0], Body(0.02, 0.04, -20.0)),
    "arc, tail": ([0.0, 0.03, 0.03 + 1e-9, 0.06], [40.0, 40.0, 0.0, 0.0], Body(0.0, 0.03, 40.0)),
    "145 degrees": (
        [0.0, 0.01, 0.01 + 1e-9, 0.07, 0.07 + 1e-9, 0.09],
        [0.0, 0.0, 42.18, 42.18, 0.0, 0.0],
        Body(0.01, 0.06, 42.18),
    ),
}


def path(arc_length, curvature):
    return path_of_curvature(np.array(arc_length), np.array(curvature))


@pytest.mark.parametrize("name", ONE_BEND)
def test_a_path_of_one_bend_is_followed_exactly(name):
    arc_length, curvature, wanted = ONE_BEND[name]
    followed = path(arc_length, curvature)
    found, far = follow_path(followed, LONGEST, 1e-6, extends=True)
    assert far == followed.length
    assert found.start == pytest.approx(wanted.start, abs=1e-8)
    assert found.bend == pytest.approx(wanted.bend, abs=1e-8)
    assert found.curvature == pytest.approx(wanted.curvature, rel=1e-6)
    assert deviation(followed, found, np.linspace(0.0, followed.length, 50))[0].max() < 2e-8


def test_a_straight_path_has_no_bend():
    found = nearest_body(path([0.0, 0.04], [0.0, 0.0]), LONGEST, extends=True)
    assert (found.bend, found.start) == (0.0, 0.04)


def test_controls_add_up_to_the_feed():
    found, feed = Body(0.02, 0.03, 25.0), np.linspace(0.0, 0.09, 91)
    bent, beyond = found.bent(feed), found.beyond(feed)
    np.testing.assert_allclose(np.minimum(feed, found.start) + bent + beyond, feed, rtol=0, atol=1e-16)
    assert bent.max() == pytest.approx(0.03)
    assert beyond[feed <= 0.05].max() < 1e-15


def test_the_body_is_the_integral_of_its_curvature():
    found = Body(0.012, 0.03, -35.0)
    along = np.linspace(0.0, 0.06, 121)

    def turn(s, state):
        inside = found.start <= s < found.start + found.bend
        return [np.cos(state[2]), np.sin(state[2]), found.curvature if inside else 0.0]

    ends = [0.0, found.start, found.start + found.bend, 0.06]
    state, places = [0.0, 0.0, 0.0], {}
    for low, high in pairwise(ends):
        wanted = along[(along >= low) & (along < high - 1e-9)]
        middle = 0.5 * (low + high)
        solved = solve_ivp(
            lambda _, y, m=middle: turn(m, y), (low, high), state, t_eval=[*wanted, high], rtol=1e-11, atol=1e-14
        )
        places.update(zip([*wanted, high], solved.y[:2].T, strict=True))
        state = solved.y[:, -1]
    along = np.array(list(places))
    np.testing.assert_allclose(np.stack(found.place(along), axis=1), [*places.values()], rtol=0, atol=1e-12)


def test_deviation_is_the_distance_at_equal_arc_length_along_the_body_so_far():
    followed = path([0.0, 0.05], [0.0, 40.0])
    found, feed = Body(0.01, 0.03, 20.0), np.array([0.0, 0.02, 0.05])
    largest, mean = deviation(followed, found, feed)
    for row, tip in enumerate(feed):
        distance = found.distance(followed, np.linspace(0.0, tip, 20001))
        assert largest[row] == pytest.approx(distance.max(), abs=1e-9)
        assert mean[row] == pytest.approx(np.sqrt(trapezoid(distance**2) / 20000.0), abs=1e-9)
    assert (np.diff(largest) >= 0.0).all()


@pytest.mark.parametrize(
    ("arc_length", "curvature", "best"),
    [
        # the least largest distances that 2,000-step simplices from many starts found
        ([0.0, 0.06], [0.0, 40.0], 0.52e-3),
        ([0.0, 0.01, 0.0101, 0.03, 0.0301, 0.05], [0.0, 0.0, 20.0, 20.0, -20.0, -20.0], 0.70e-3),
        ([0.0, 0.1], [15.0, 15.0], 1.15e-3),
    ],
)
def test_the_nearest_body_is_as_near_as_a_long_search_finds(arc_length, curvature, best):
    followed = path(arc_length, curvature)
    found = nearest_body(followed, LONGEST, extends=True)
    assert found.distance(followed, followed.arc_length).max() < 1.03 * best + 5e-6


def test_a_path_that_turns_back_is_followed_in_part():
    s = np.linspace(0.0, 0.09, 46)
    followed = path(
        s, np.interp(s, [0.02, 0.022, 0.04, 0.042, 0.05, 0.052, 0.07, 0.072], [0, 35, 35, 0, 0, -35, -35, 0])
    )
    found, far = follow_path(followed, LONGEST, 1e-3, extends=True)
    distance = found.distance(followed, followed.arc_length)
    assert 0.055 < far < 0.09
    assert distance[followed.arc_length <= far].max() <= 1e-3
    assert follow_path(followed, LONGEST, 3e-3, extends=True)[1] > far


def test_one_tube_bends_to_its_end():
    found = nearest_body(path([0.0, 0.03, 0.0301, 0.06], [40.0, 40.0, 0.0, 0.0]), LONGEST, extends=False)
    assert found.start + found.bend == pytest.approx(0.06, abs=1e-6)


def test_the_bend_is_never_longer_than_the_notches():
    assert nearest_body(path([0.0, 0.1], [15.0, 15.0]), 0.04, extends=True).bend <= 0.04


def test_a_mirrored_path_has_the_mirrored_body():
    one, other = (nearest_body(path([0.0, 0.06], [0.0, side * 40.0]), LONGEST, extends=True) for side in (1, -1))
    assert one.start == pytest.approx(other.start, abs=2e-5)
    assert one.curvature == pytest.approx(-other.curvature, rel=1e-3)
