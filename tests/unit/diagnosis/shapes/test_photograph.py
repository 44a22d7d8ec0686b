"""Bad points are refused in one sentence that says what is wrong."""

from __future__ import annotations

import numpy as np
import pytest

from coast_cli.diagnosis.shapes.photograph import photographs
from coast_cli.errors import BadInput
from coast_cli.recordings.model import ShapeRun
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config_text
from tests.photographed_tube import COUNT, LENGTH, Bench, config_text, shape

DESIGN = build(load_config_text(config_text({"A": (0.314, 4.0)}), "tubes.toml"))
X, Y = shape(Bench(), up=True, points=80)


def _run(x, y, natural="up") -> ShapeRun:
    return ShapeRun("s", "shapes.csv", np.arange(2, len(x) + 2), "A", None, np.asarray(x), np.asarray(y), natural)


def _noisy(size: float) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(3)
    return X + size * random.standard_normal(X.size), Y + size * random.standard_normal(Y.size)


def test_a_good_shape_is_placed_from_clamp_to_tip():
    (found,) = photographs(DESIGN, [_run(*_noisy(1e-4))])
    assert found.at[-1] == pytest.approx(LENGTH)
    assert found.recorded_length == pytest.approx(LENGTH, rel=0.01)
    assert list(np.flatnonzero(found.placed)) == [79]
    assert found.upward == 1.0


def test_an_outer_tube_points_up_unless_it_is_said_to_point_down():
    assert photographs(DESIGN, [_run(X, Y, None)])[0].upward == 1.0
    assert photographs(DESIGN, [_run(X, Y, "down")])[0].upward == -1.0


def test_one_point_a_pitch_lies_on_the_rings():
    s = np.concatenate([[0.0], 0.15e-3 + 0.6e-3 * np.arange(COUNT)])
    at = np.linspace(0.0, LENGTH, X.size)
    (found,) = photographs(DESIGN, [_run(np.interp(s, at, X), np.interp(s, at, Y))])
    assert found.placed.all()
    assert found.at == pytest.approx(s)


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ((Y, X), "x and y seem to be swapped"),
        ((X[::-1], Y[::-1]), "from the tip to the clamp"),
        ((X[45:], Y[45:]), "not at the clamp"),
        ((np.delete(X, range(20, 65)), np.delete(Y, range(20, 65))), "a gap"),
        ((np.concatenate([X[:40], X[20:]]), np.concatenate([Y[:40], Y[20:]])), "back and forth"),
        ((1.9 * X, 1.9 * Y), "another tube's shape"),
        ((X[:35], Y[:35]), "another tube's shape"),
        ((-X, Y), "towards -x"),
        ((np.repeat(X, 2), np.repeat(Y, 2)), "stand twice"),
        ((np.zeros(20), np.zeros(20)), "stand twice"),
        ((X[[0, -1]], Y[[0, -1]]), "too few points"),
        (
            (
                X[[*range(30), 50, *range(31, 50), 30, *range(51, 80)]],
                Y[[*range(30), 50, *range(31, 50), 30, *range(51, 80)]],
            ),
            "out of order",
        ),
        ((X[[*range(30), 31, 30, *range(32, 80)]], Y[[*range(30), 31, 30, *range(32, 80)]]), "out of order"),
    ],
)
def test_bad_points(points, said):
    with pytest.raises(BadInput) as caught:
        photographs(DESIGN, [_run(*points)])
    assert said in str(caught.value)
    assert "shapes.csv" in str(caught.value)
    assert "allowed" in str(caught.value)


@pytest.mark.parametrize("up", [True, False])
@pytest.mark.parametrize("noise", [0.0, 5e-5, 3e-4])
@pytest.mark.parametrize("points", [17, 80, 400])
def test_noise_and_spacing_are_no_fault(up, noise, points):
    random = np.random.default_rng(points)
    x, y = shape(Bench(natural=-9.0), up=up, points=points)
    photographs(DESIGN, [_run(x + noise * random.standard_normal(points), y + noise * random.standard_normal(points))])


def test_one_point_that_stands_twice_does_no_harm():
    photographs(DESIGN, [_run(np.insert(X, 30, X[30]), np.insert(Y, 30, Y[30]))])


def test_an_unknown_tube_is_refused():
    run = ShapeRun("s", "shapes.csv", np.arange(3), "Z", None, np.arange(3.0), np.zeros(3), None)
    with pytest.raises(BadInput, match="no such tube"):
        photographs(DESIGN, [run])
