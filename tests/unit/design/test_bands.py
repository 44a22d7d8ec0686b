"""Bands of strokes against plain random draws: of a fit with its correlations, and of how the tubes are made."""

import numpy as np
import pytest

from coast_cli.design.bands import alternatives
from coast_cli.design.samples import shares
from coast_cli.design.stroke import stroke_table
from coast_cli.design.variation import variation
from coast_cli.mechanics.joint import joints_of, stroke
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config_text

STD, CORRELATION = np.array([2.0, 0.02, 0.05]), np.array([[1.0, -0.8, 0.3], [-0.8, 1.0, 0.0], [0.3, 0.0, 1.0]])
FITTED = f"""
[fitted]
keys = ["joint.youngs_modulus_gpa", "joint.pulley_friction", "joint.deadband_mm"]
std = {STD.tolist()}
correlation = {CORRELATION.tolist()}
"""
CURVATURES, LENGTHS = (10.0, 40.0), (0.02, 0.04)


def banded(text, pair=None, *, tolerances=False, **drive):
    design = build(load_config_text(text))
    others = alternatives(design, pair, tolerances=tolerances)
    drive = drive or {"curvatures": CURVATURES}
    joint = design.joint(pair)
    found = stroke_table(joint, LENGTHS, effects=design.effects, alternatives=others, **drive)
    return {
        name: np.array(values, dtype=float) for name, values in found.columns.items() if name not in ("outer", "middle")
    }


def strokes(text, draws):
    """Return the strokes of a joint with E, mu and dead band replaced by each draw, shape (draws, rows)."""
    joint = build(load_config_text(text)).joint()
    length, curvature = (grid.ravel() for grid in np.meshgrid(LENGTHS, CURVATURES, indexing="ij"))
    from dataclasses import replace

    found = [
        stroke(replace(joint, youngs_modulus=e * 1e9, pulley_friction=mu, deadband=slack * 1e-3), curvature, length)
        for e, mu, slack in draws
    ]
    return np.array([one.stroke for one in found]) * 1e3


def test_the_band_of_a_fit_is_that_of_random_draws(reference_text):
    found = banded(reference_text + FITTED)
    covariance = CORRELATION * np.outer(STD, STD)
    draws = np.random.default_rng(3).multivariate_normal([42.6, 0.2965, 1.2], covariance, size=4000)
    low, high = np.quantile(strokes(reference_text, draws), (0.05, 0.95), axis=0)
    width = high - low
    assert np.all(np.abs(found["stroke_low_mm"] - low) < 0.05 * width)
    assert np.all(np.abs(found["stroke_high_mm"] - high) < 0.05 * width)


def test_correlations_count(reference_text):
    alone = FITTED.replace(str(CORRELATION.tolist()), str(np.eye(3).tolist()))
    one, other = (banded(reference_text + text) for text in (FITTED, alone))
    width = [found["stroke_high_mm"] - found["stroke_low_mm"] for found in (one, other)]
    assert np.all(width[0][1::2] < 0.9 * width[1][1::2])


def test_the_band_of_a_curvature_is_that_of_its_strokes_turned_round(reference_text):
    one = banded(reference_text + FITTED)
    back = banded(reference_text + FITTED, strokes=(3e-3,))
    assert np.all(back["curvature_low_per_m"] < back["curvature_per_m"])
    slope = np.diff(one["stroke_mm"].reshape(2, 2), axis=1)[:, 0] / 30.0
    half = (one["stroke_high_mm"] - one["stroke_low_mm"]).reshape(2, 2)
    near = [np.interp(k, CURVATURES, row) for k, row in zip(back["curvature_per_m"], half, strict=True)]
    np.testing.assert_allclose((back["curvature_high_per_m"] - back["curvature_low_per_m"]) * slope, near, rtol=0.15)


def test_the_band_of_tolerances_is_that_of_random_tubes(reference_text):
    found = banded(reference_text, tolerances=True)
    design = build(load_config_text(reference_text))
    joint = design.joint()
    varied = variation(design.config, (joint.outer, joint.middle))
    draws = shares(0, len(varied.inputs), 0, 4000)
    made = joints_of(joint, *(varied.tube(tube, draws) for tube in (joint.outer, joint.middle)))
    for row, (length, curvature) in enumerate((x2, k) for x2 in LENGTHS for k in CURVATURES):
        low, high = np.nanquantile(stroke(made, curvature, length).stroke * 1e3, (0.05, 0.95))
        assert found["stroke_low_mm"][row] == pytest.approx(low, abs=0.1 * (high - low))
        assert found["stroke_high_mm"][row] == pytest.approx(high, abs=0.1 * (high - low))


def test_corrections_have_their_band(reference_text):
    found = banded(
        f"{reference_text}\n[corrections.coulomb_friction]\nholds_per_m = 10.0\n"
        '[fitted]\nkeys = ["corrections.coulomb_friction.holds_per_m"]\nstd = [2.0]\ncorrelation = [[1.0]]\n'
    )
    per_one = (found["stroke_mm"][1] - found["stroke_mm"][0]) / 30.0
    half = 0.5 * (found["stroke_high_mm"] - found["stroke_low_mm"])[:2]
    np.testing.assert_allclose(half, 1.645 * 2.0 * per_one, rtol=0.1)


def test_a_model_without_a_fit_has_no_band(reference_text):
    found = banded(reference_text)
    assert np.isnan(found["stroke_low_mm"]).all()
    assert np.isnan(found["stroke_high_mm"]).all()


def test_the_end_of_a_range_bounds_the_band(reference_text):
    text = reference_text.replace("deadband_mm = 1.2", "deadband_mm = 0.01")
    wide = '[fitted]\nkeys = ["joint.deadband_mm"]\nstd = [0.5]\ncorrelation = [[1.0]]\n'
    assert np.all(banded(text + wide)["stroke_low_mm"] > 0.0)
