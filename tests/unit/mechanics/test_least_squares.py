"""The wrapper's separate answers: bounds, what never moved, what is not seen, robustness, profile intervals."""

import numpy as np
import pytest
from scipy.stats import t

from coast_cli.mechanics.least_squares import least_squares, profile_interval

X = np.linspace(0.0, 1.0, 40)
WIDE = np.full(2, -10.0), np.full(2, 10.0)


def line(noise=0.0, seed=0):
    y = 1.0 + 2.0 * X + noise * np.random.default_rng(seed).normal(size=X.size)
    return lambda p: p[0] + p[1] * X - y


def test_linear_fit_has_the_textbook_answer():
    residual = line(0.1)
    fit = least_squares(residual, np.zeros(2), *WIDE)
    design = np.column_stack((np.ones_like(X), X))
    y = -residual(np.zeros(2))
    expected, rss, *_ = np.linalg.lstsq(design, y, rcond=None)
    covariance = rss[0] / 38.0 * np.linalg.inv(design.T @ design)
    assert fit.x == pytest.approx(expected, rel=1e-10)
    assert fit.covariance == pytest.approx(covariance, rel=1e-6)
    assert fit.std == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-6)
    assert fit.correlation[0, 1] == pytest.approx(covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]))
    assert fit.at_bound == (False, False)
    assert fit.moved == (True, True)
    assert fit.seen == (True, True)


def test_profile_of_a_linear_model_is_its_t_interval():
    residual = line(0.1)
    fit = least_squares(residual, np.zeros(2), *WIDE)
    half = t.ppf(0.95, 38) * fit.std[1]
    assert profile_interval(residual, fit, 1, *WIDE) == pytest.approx((fit.x[1] - half, fit.x[1] + half), rel=1e-4)


def test_a_parameter_on_its_bound_is_named_and_the_other_still_fits():
    lower, upper = np.array([-10.0, -10.0]), np.array([10.0, 1.5])
    fit = least_squares(line(), np.zeros(2), lower, upper)
    assert fit.at_bound == (False, True)
    assert fit.x == pytest.approx([1.25, 1.5], abs=1e-6)


def test_a_start_outside_the_bounds_is_moved_in():
    fit = least_squares(line(), np.array([50.0, -50.0]), *WIDE)
    assert fit.x == pytest.approx([1.0, 2.0])


def test_what_the_residual_cannot_see_is_said():
    fit = least_squares(lambda p: p[0] - 1.0 + 0.0 * X, np.zeros(2), *WIDE)
    assert fit.seen == (True, False)
    assert fit.moved == (True, False)
    assert fit.std[1] == np.inf


def test_a_product_is_seen_but_not_its_factors():
    wide = np.full(3, 0.1), np.full(3, 10.0)
    rng = np.random.default_rng(0)
    y = 6.0 * X + 0.01 * rng.normal(size=X.size) + 1.0
    fit = least_squares(lambda p: p[0] * p[1] * X + p[2] - y, np.array([1.0, 1.0, 0.5]), *wide)
    assert fit.x[0] * fit.x[1] == pytest.approx(6.0, rel=0.01)
    assert fit.seen == (False, False, True)


def test_robust_loss_ignores_outliers():
    rng = np.random.default_rng(1)
    y = 1.0 + 2.0 * X + 0.01 * rng.normal(size=X.size)
    y[::8] += 5.0
    weighted = lambda p: (p[0] + p[1] * X - y) / 0.01  # noqa: E731
    fit = least_squares(weighted, np.zeros(2), *WIDE, robust=True)
    assert fit.x == pytest.approx([1.0, 2.0], abs=0.02)


def test_profile_stops_at_a_bound_it_does_not_reach():
    lower, upper = np.array([-10.0, 1.9999]), np.array([10.0, 2.0001])
    residual = line(0.1)
    fit = least_squares(residual, np.array([1.0, 2.0]), lower, upper)
    assert profile_interval(residual, fit, 1, lower, upper) == pytest.approx((1.9999, 2.0001))
