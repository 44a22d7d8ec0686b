"""All pairs at once give what each pair gives alone, whatever patterns the tubes have; coupled pairs sag as one beam."""

from dataclasses import fields, replace

import numpy as np
import pytest

from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.pairs import PairTable, pair_table
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config
from tests.one_pair import pair_figures

FIGURES = [field.name for field in fields(PairTable) if field.name != "converged"]


@pytest.fixture
def design(reference):
    return build(load_config(reference))


def with_other_pattern(tube, cut, uncut, count):
    return replace(tube, depth=np.full(count, tube.depth[0]), cut=np.full(count, cut), uncut=np.full(count, uncut))


def test_it_agrees_with_each_pair_alone(design):
    other = with_other_pattern(design.outer[1], 0.25e-3, 0.4e-3, 90)
    outer, middle = (*design.outer, other), (*design.middle, with_other_pattern(design.middle[0], 0.3e-3, 0.3e-3, 190))
    table = pair_table(outer, middle, design.gravity)
    assert np.all(table.converged)
    for row, middle_tube in enumerate(middle):
        for column, outer_tube in enumerate(outer):
            alone = pair_figures(outer_tube, middle_tube, design.gravity)
            for name in FIGURES:
                assert getattr(table, name)[row, column] == pytest.approx(getattr(alone, name), rel=1e-9, abs=1e-13), (
                    name
                )


def test_a_coupled_pair_of_equal_tubes_hangs_like_one_of_them(design):
    tube = replace(design.middle[0], natural_curvature=-3.0)
    table = pair_table([tube], [tube], design.gravity, "coupled")
    assert table.signed_precurvature[0, 0] == pytest.approx(solve_beam(tube, design.gravity).tip_angle, rel=1e-12)


def test_without_gravity_both_assemblies_agree(design):
    separate, coupled = (pair_table(design.outer, design.middle, 0.0, kind) for kind in ("separate", "coupled"))
    for name in FIGURES:
        np.testing.assert_allclose(getattr(coupled, name), getattr(separate, name), rtol=1e-9)


def test_blocks_do_not_show(design, monkeypatch):
    whole = pair_table(design.outer, design.middle, design.gravity)
    monkeypatch.setattr("coast_cli.mechanics.pairs._BLOCK", 700)
    split = pair_table(design.outer, design.middle, design.gravity)
    bend = whole.total_precurvature.max()  # the signed integral cancels, so its rounding is that of the whole bend
    for name in FIGURES:
        atol = 1e-15 * bend if name == "signed_precurvature" else 0.0
        np.testing.assert_allclose(getattr(split, name), getattr(whole, name), rtol=1e-14, atol=atol)
