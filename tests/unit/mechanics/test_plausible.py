"""Arguments in another unit than they are asked for in are refused by name; what a configuration may hold never is."""

from dataclasses import replace

import numpy as np
import pytest

import coast_cli as coast
from coast_cli.mechanics.joint import Tendon
from coast_cli.mechanics.plausible import RADIUS, require
from tests.conftest import REFERENCE

DESIGN = coast.build(coast.load_config(REFERENCE))
JOINT, TUBE = DESIGN.joint(), DESIGN.tube("MT3")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: coast.stroke(JOINT, [20.0], 20.0), "bending_length 20 m; millimetres?"),
        (lambda: coast.stroke(JOINT, 20, 20), "bending_length 20 m; millimetres?"),
        (lambda: coast.tip(20, [1, 20]), "bending_length 20 m; millimetres?"),
        (lambda: coast.curvature_from_stroke(JOINT, 2.6, 0.02), "stroke_length 2.6 m; millimetres?"),
        (lambda: coast.curvature_from_stroke(JOINT, 0.0026, [0.02, 40.0]), "bending_length 40 m; millimetres?"),
        (lambda: coast.tip(20.0, 20.0), "bending_length 20 m; millimetres?"),
        (lambda: coast.stroke_table(JOINT, [20.0], curvatures=[20.0]), "20"),
        (lambda: replace(TUBE, outer_radius=0.18), "outer_radius 0.18 m; millimetres?"),
        (lambda: replace(TUBE, cut=TUBE.cut * 1e4), "cut 3 m; millimetres?"),
        (lambda: replace(TUBE, density=6.45), "density 6.45 kg/m^3; g/cm^3?"),
        (lambda: coast.solve_beam(replace(TUBE, youngs_modulus=45.0), 9.81), "youngs_modulus 45 Pa; gigapascals?"),
        (lambda: replace(JOINT, youngs_modulus=42.6), "youngs_modulus 42.6 Pa; gigapascals?"),
        (lambda: Tendon(0.076, 5.4e10, 0.4), "radius 0.076 m; millimetres?"),
        (lambda: Tendon(3.8e-5, 5.4e10, 388.0), "length 388 m; millimetres?"),
    ],
)
def test_another_unit_is_named(call, said):
    with pytest.raises(coast.CoastError) as caught:
        call()
    assert said in str(caught.value)


@pytest.mark.parametrize("fine", [0.05, 0, np.array([0.001, np.nan]), np.zeros(0), [], 1e-4 + 1e-20j])
def test_what_may_be_passes(fine):
    require(RADIUS, radius=fine)
