"""The interpolated end effect: exact where it must be, monotone, vectorised, outspoken outside its table."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.mechanics.end_effect import RELATIVE_ERROR, end_effect_table, end_length, interpolate

KINDS = ["sector", "chord"]


@pytest.mark.parametrize("kind", KINDS)
def test_the_table_is_returned_at_its_own_points(kind):
    table = end_effect_table(kind)
    grid = np.meshgrid(table.inner_ratio, table.depth, table.uncut_ratio, indexing="ij")
    assert interpolate(table, *grid) == pytest.approx(table.extra_cut_ratio, abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_a_ring_of_no_length_stiffens_nothing(kind):
    length, notes = end_length(2e-4, 1.65e-4, 3.14e-4, 3e-4, 0.0, kind)
    assert length == pytest.approx(0.0, abs=1e-15)
    assert notes == ()


@pytest.mark.parametrize("kind", KINDS)
def test_a_short_ring_counts_as_cut_almost_wholly(kind):
    length, _ = end_length(2e-4, 1.65e-4, 3.14e-4, 3e-4, 2e-6, kind)
    assert 0.85 < length / 2e-6 < 1.0


@pytest.mark.parametrize("kind", KINDS)
def test_leaving_out_one_plane_of_the_table_changes_little(kind):
    """Upper bound of the interpolation error: the gap left is twice the table's own."""
    table = end_effect_table(kind)
    names = ("inner_ratio", "depth", "uncut_ratio")
    errors = []
    for number, name in enumerate(names):
        axis = getattr(table, name)
        for left_out in range(1, axis.size - 1):
            thinner = replace(
                table,
                **{name: np.delete(axis, left_out)},
                extra_cut_ratio=np.delete(table.extra_cut_ratio, left_out, axis=number),
            )
            axes = [getattr(table, n) for n in names]
            axes[number] = axis[left_out : left_out + 1]
            truth = np.take(table.extra_cut_ratio, [left_out], axis=number)
            away_from_zero = truth > 0.02
            error = interpolate(thinner, *np.meshgrid(*axes, indexing="ij")) - truth
            errors.append(np.abs(error[away_from_zero] / truth[away_from_zero]))
    pooled = np.concatenate(errors)
    assert np.median(pooled) < RELATIVE_ERROR / 2
    assert np.quantile(pooled, 0.95) < 4 * RELATIVE_ERROR


def test_monotone_where_the_table_is():
    uncut = np.linspace(0.0, 1.5, 400)
    for kind in KINDS:
        table = end_effect_table(kind)
        rising = np.all(
            np.diff(table.extra_cut_ratio[:, :, : np.searchsorted(table.uncut_ratio, 1.6)], axis=-1) > 0, axis=-1
        )
        assert rising.any()
        for i, j in np.argwhere(rising):
            line = interpolate(table, np.full(400, table.inner_ratio[i]), np.full(400, table.depth[j]), uncut)
            assert np.all(np.diff(line) > -1e-14)


def test_arrays_broadcast_and_agree_with_single_calls():
    depth = np.array([[3.1e-4], [3.5e-4], [3.7e-4]])
    uncut = np.array([1e-4, 3e-4])
    length, notes = end_length(2e-4, 1.65e-4, depth, 3e-4, uncut)
    assert length.shape == (3, 2)
    assert notes == ()
    for i in range(3):
        for j in range(2):
            assert end_length(2e-4, 1.65e-4, depth[i, 0], 3e-4, uncut[j])[0] == pytest.approx(length[i, j], rel=1e-14)


def test_it_scales_with_the_tube():
    small, _ = end_length(2e-4, 1.65e-4, 3.14e-4, 3e-4, 3e-4)
    large, _ = end_length(8e-4, 6.6e-4, 12.56e-4, 12e-4, 12e-4)
    assert large == pytest.approx(4 * small, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "name", "shown"),
    [
        ((2e-4, 0.5e-4, 3e-4, 3e-4, 3e-4), "ri/ro", "0.25"),
        ((2e-4, 1.65e-4, 3.98e-4, 3e-4, 3e-4), "depth/(2 ro)", "0.995"),
        ((2e-4, 1.65e-4, 3e-4, 0.2e-4, 3e-4), "holds from 0.5 ro", "0.1 ro"),
    ],
)
def test_outside_the_table_is_said(arguments, name, shown):
    length, notes = end_length(*arguments)
    assert np.isfinite(length)
    assert length > 0
    assert len(notes) == 1
    assert name in notes[0]
    assert shown in notes[0]


def test_past_the_longest_ring_nothing_changes():
    far, notes = end_length(2e-4, 1.65e-4, 3.14e-4, 3e-4, [2e-3, 2e-2])
    assert far[0] == pytest.approx(far[1], rel=1e-12)
    assert notes == ()


def test_a_flat_cut_passes_the_bore_without_a_jump():
    ro, ri = 2e-4, 1.65e-4
    below, above = end_length(ro, ri, ro + ri + np.array([-1e-9, 1e-9]), 3e-4, 3e-4, "chord")[0]
    assert above == pytest.approx(below, rel=1e-3)
