"""Zeros are zeros on every processor."""

import numpy as np

from coast_cli.mechanics.rounding import without_rounding


def test_what_is_rounding_of_the_largest_is_zero():
    assert without_rounding(np.array([2.78e-17, -3e-14, 1e-9, 37.7])).tolist() == [0.0, 0.0, 1e-9, 37.7]


def test_the_largest_may_lie_elsewhere_and_nothing_stays_nothing():
    assert without_rounding(np.array([5.7e-19]), among=np.array([2.6])).tolist() == [0.0]
    assert without_rounding(np.array([5.7e-19])).tolist() == [5.7e-19]
    assert without_rounding(np.zeros(0)).size == 0
    assert np.isnan(without_rounding(np.array([np.nan]), among=np.array([1.0]))).all()
