"""Derivatives are those of the figures themselves, to their last digits; what enters as a product is said."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.design.sensitivity import sensitivity_rows, tip_derivative
from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.joint import stroke
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config
from tests.one_pair import pair_figures


@pytest.fixture(scope="module")
def design():
    from pathlib import Path

    return build(load_config(Path(__file__).parents[3] / "configs" / "tubes.toml"))


@pytest.fixture(scope="module")
def answer(design):
    rows, notes = sensitivity_rows(design)
    return {(r["subject"], r["figure"], r["input_of"], r["input"]): r for r in rows}, notes


def central(function, step):
    """Derivative by central differences, extrapolated once."""
    once, twice = ((function(h) - function(-h)) / (2.0 * h) for h in (step, 2.0 * step))
    return (4.0 * once - twice) / 3.0


@pytest.mark.parametrize(("natural_curvature", "expected"), [(5.0, 1.97), (-5.0, 1.23)])
def test_a_micrometre_of_depth_moves_the_tip_by_more_than_a_millimetre(natural_curvature, expected):
    one = np.ones(188)
    tube = NotchedTube(
        "reference", 0.2e-3, 0.165e-3, 0.35e-3 * one, 0.3e-3 * one, 0.3e-3 * one, 45e9, 6450.0, natural_curvature
    )
    per_micrometre = np.hypot(*tip_derivative(tube, 9.81, "depth")) * 1e-6 / 1e-3
    assert round(float(per_micrometre), 2) == expected


@pytest.mark.parametrize(
    "field", ["depth", "cut", "uncut", "outer_radius", "inner_radius", "youngs_modulus", "density"]
)
def test_tip_derivatives_are_those_of_the_tip(design, field):
    tube = design.tube("MT3")
    size = 1e-4 * np.mean(getattr(tube, field))

    def tip(change):
        solution = solve_beam(replace(tube, **{field: getattr(tube, field) + change}), design.gravity)
        return np.array([solution.x[-1], solution.y[-1]])

    assert tip_derivative(tube, design.gravity, field) == pytest.approx(central(tip, size), rel=1e-7)


def test_pair_derivatives_are_those_of_the_pair(design, answer):
    outer, middle = design.tube("OT4"), design.tube("MT1")

    def figures(change):
        found = pair_figures(replace(outer, depth=outer.depth + change * 1e-6), middle, design.gravity)
        return np.array([found.total_precurvature, found.ratio_mean, found.ratio_series, found.total_series])

    expected = central(figures, 0.05)
    rows, _ = answer
    for name, value in zip(("total_precurvature", "ratio_mean", "ratio_series", "total_series"), expected, strict=True):
        assert rows["OT4/MT1", name, "OT4", "depth"]["change"] == pytest.approx(value, rel=1e-6)


def test_stroke_derivatives_are_those_of_the_stroke(design, answer):
    joint = design.joint()
    value = float(stroke(joint, 40.0, 40e-3).stroke)
    rows, _ = answer
    assert rows["OT4/MT1", "stroke", "joint", "deadband"]["change"] == pytest.approx(1e-3)
    row = rows["OT4/MT1", "stroke", "joint", "youngs_modulus"]
    stretched = float(stroke(replace(joint, youngs_modulus=joint.youngs_modulus + 1e9), 40.0, 40e-3).stroke)
    assert row["change"] == pytest.approx((stretched - value) * 1e3, rel=1e-12)
    assert row["change_percent"] == pytest.approx(100.0 * (stretched - value) / value, rel=1e-12)


def test_products_are_said(answer):
    _, notes = answer
    product = next(note for note in notes if "one combination" in note)
    for name in ("joint.youngs_modulus", "joint.pulley_friction", "joint.wrap_angle", "tendon.length"):
        assert name in product
    assert "joint.notch_friction" not in product
    assert "joint.deadband" not in product
    assert "MT1.youngs_modulus" not in product
    assert any("density * gravity / modulus" in note for note in notes)
