"""Distances in strips are those of the whole mask, to the bit."""

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from coast_cli.recordings import trace_distance


@pytest.mark.parametrize("share", [0.3, 0.999, 0.99999])
@pytest.mark.parametrize("margin", [1, 64])
def test_strips_make_the_whole(monkeypatch, share, margin):
    monkeypatch.setattr(trace_distance, "STRIP", 5000)
    monkeypatch.setattr(trace_distance, "_MARGIN", margin)
    mask = np.random.default_rng(7).random((333, 120)) < share
    np.testing.assert_array_equal(trace_distance.edge_distance(mask), distance_transform_edt(mask))


def test_a_mask_whose_edge_is_far_off(monkeypatch):
    monkeypatch.setattr(trace_distance, "STRIP", 1000)
    mask = np.ones((700, 50), dtype=bool)
    mask[0, 10] = False
    np.testing.assert_array_equal(trace_distance.edge_distance(mask), distance_transform_edt(mask))
