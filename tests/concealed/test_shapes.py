"""The rig's own beam solver meets the published reference answers, and its shapes show what they conceal."""

import numpy as np
import pytest

from examples.concealed.design import Tube, ring, sector
from examples.concealed.shape_beam import Strand, solve
from examples.concealed.shape_case import SHAPE_LEVELS, make_shape_case
from examples.concealed.shape_recipes import SHAPE_RECIPES
from examples.concealed.shape_scene import chord_moments

MM = 1e-3
TUBE = Tube("T", 0.4 * MM, 0.33 * MM, 0.35 * MM, 0.3 * MM, 0.3 * MM, 188, 5.0)


def strand(natural, elements):
    n = TUBE.count
    length = np.repeat(np.tile([TUBE.uncut, TUBE.cut], n) / elements, elements)
    moment = np.repeat(np.tile([ring(TUBE)[1], sector(TUBE)[2]], n), elements)
    area = np.repeat(np.tile([ring(TUBE)[0], sector(TUBE)[0]], n), elements)
    return Strand(length, 45e9 * moment, 6450 * 9.81 * area, np.full(length.size, natural), 0 * length)


@pytest.mark.parametrize(
    ("natural", "angle", "x", "y"),
    [
        (5.0, -0.66270797828223, 0.087982123270705, -0.066789038374872),
        (-5.0, -1.40985211612583, 0.060216743875269, -0.086052930077382),
        (-15.0, -2.12682804094436, 0.030065655053199, -0.090728647097830),
    ],
)
def test_reference_answers_are_met_at_second_order(natural, angle, x, y):
    errors = []
    for elements in (1, 2, 4):
        found = solve(strand(natural, elements))
        errors.append(abs(found.angle[-1] - angle))
        assert np.hypot(found.x[-1] - x, found.y[-1] - y) < 2e-7
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)


def test_chord_section_is_softer_than_the_sector():
    for depth in (0.314, 0.35, 0.376):
        tube = Tube("T", 0.5 * MM, 0.4 * MM, depth * MM, 0.3 * MM, 0.3 * MM, 10, 1.0)
        assert 1.05 < sector(tube)[2] / chord_moments(tube)[1] < 2.2


def test_a_weightless_tube_keeps_its_natural_curvature():
    free = strand(8.0, 2)
    shape = solve(Strand(free.length, free.rigidity, 0 * free.weight, free.natural, free.axis_offset))
    total = shape.s[-1]
    assert shape.x[-1] == pytest.approx(np.sin(8 * total) / 8, rel=1e-9)
    assert shape.y[-1] == pytest.approx((1 - np.cos(8 * total)) / 8, rel=1e-9)


@pytest.mark.parametrize("effect", sorted(SHAPE_RECIPES))
def test_every_shape_effect_moves_the_tip_clear_of_the_noise(effect):
    truth = make_shape_case(4, effect=effect).truth
    assert truth["effects"][0]["id"] == effect
    assert truth["effects"][0]["tip_noise_widths"] > 3
    assert truth["effects"][0]["noise_widths"] > 1


@pytest.mark.parametrize("level", list(SHAPE_LEVELS))
def test_every_shape_level_makes_cases(level):
    case = make_shape_case(11, level)
    assert case.truth["level"] == level
    assert sum(text.count("\n") - 1 for text in case.files.values()) == sum(map(len, case.truth["response"].values()))
