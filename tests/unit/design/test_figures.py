"""Figures of many pairs at once are those of each pair alone."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.design.figures import pair_columns, point_figures
from coast_cli.mechanics.joint import Joint, stroke
from coast_cli.mechanics.pairs import bent, every_pair, listed_pairs
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import Tubes, tubes_of
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config
from tests.one_pair import pair_figures


@pytest.fixture
def design(reference):
    return build(load_config(reference))


def check(outer: NotchedTube, middle: NotchedTube, columns, row, gravity):
    alone = pair_figures(outer, middle, gravity)
    np.testing.assert_allclose(
        [columns[name][row] for name in columns],
        [
            alone.total_precurvature,
            alone.signed_precurvature,
            alone.ratio_mean,
            alone.ratio_series,
            alone.total_mean,
            alone.total_series,
        ],
        rtol=1e-10,
        atol=1e-12,
    )


def test_every_reference_pair(design):
    outer, middle = tubes_of(design.outer), tubes_of(design.middle)
    first, second = (grid.ravel() for grid in np.meshgrid(range(4), range(3)))
    columns = pair_columns(listed_pairs(bent(outer, design.gravity), bent(middle, design.gravity), (first, second)))
    for row, (one, two) in enumerate(zip(first, second, strict=True)):
        check(design.outer[one], design.middle[two], columns, row, design.gravity)


def test_tubes_of_different_patterns_and_counts(design):
    rng = np.random.default_rng(3)
    tubes, rows = {"outer": [], "middle": []}, {}
    for role, start in (("outer", design.outer[0]), ("middle", design.middle[0])):
        for _ in range(5):
            count = int(rng.integers(80, 180))
            one, cut, uncut = np.ones(count), rng.uniform(0.2e-3, 0.5e-3), rng.uniform(0.2e-3, 0.5e-3)
            depth = start.outer_radius * rng.uniform(1.2, 1.6)
            tubes[role].append(replace(start, depth=depth * one, cut=cut * one, uncut=uncut * one))
        rows[role] = Tubes(
            outer_radius=np.full(5, start.outer_radius),
            inner_radius=np.full(5, start.inner_radius),
            depth=np.array([[tube.depth[0]] for tube in tubes[role]]),
            cut=np.array([[tube.cut[0]] for tube in tubes[role]]),
            uncut=np.array([[tube.uncut[0]] for tube in tubes[role]]),
            count=np.array([tube.count for tube in tubes[role]]),
            youngs_modulus=np.full(5, start.youngs_modulus),
            density=np.full(5, start.density),
            natural_curvature=np.full(5, start.natural_curvature),
        )
    solved = {role: bent(rows[role], design.gravity) for role in rows}
    every = np.arange(5)
    columns = pair_columns(listed_pairs(solved["outer"], solved["middle"], (every, every[::-1])))
    for row in range(5):
        check(tubes["outer"][row], tubes["middle"][4 - row], columns, row, design.gravity)


def test_every_pair_of_two_benches_is_that_pair_alone(design):
    """Enough tubes of few patterns that their pieces are merged once a group of patterns."""
    rows = np.arange(40) % 4
    outer, middle = tubes_of(design.outer).picked(rows), tubes_of(design.middle).picked(rows % 3)
    cut = np.where(np.arange(40)[:, None] < 20, 0.9, 1.0) * outer.cut
    outer = replace(outer, depth=outer.depth * np.linspace(0.98, 1.0, 40)[:, None], cut=cut)
    solved = bent(outer, design.gravity), bent(middle, design.gravity)
    second, first = (index.ravel() for index in np.indices((40, 40)))
    one_by_one, together = pair_columns(listed_pairs(*solved, (first, second))), pair_columns(every_pair(*solved))
    for name, column in one_by_one.items():
        np.testing.assert_allclose(together[name], column, rtol=1e-12, atol=1e-15)


def test_a_quarter_roll_puts_the_natural_curvature_across(design):
    straight = tubes_of([replace(design.outer[0], natural_curvature=0.0)])
    rolled, middle = tubes_of([design.outer[0]]), tubes_of([replace(design.middle[0], natural_curvature=0.0)])
    row = (np.zeros(1, dtype=int), np.zeros(1, dtype=int))
    planar = pair_columns(listed_pairs(bent(straight, 0.0), bent(middle, 0.0), row))
    across = pair_columns(listed_pairs(bent(rolled, 0.0, roll=np.array([np.pi / 2])), bent(middle, 0.0), row))
    along = pair_columns(listed_pairs(bent(rolled, 0.0), bent(middle, 0.0), row))
    assert planar["total_precurvature_rad"][0] == 0.0
    assert abs(across["signed_precurvature_rad"][0]) < 1e-12
    np.testing.assert_allclose(across["total_precurvature_rad"], along["total_precurvature_rad"])


def test_stroke_and_strains_are_those_of_each_joint(design):
    joint = design.joint()
    outer, middle = tubes_of([design.outer[3], design.outer[0]]), tubes_of([design.middle[0], design.middle[2]])
    columns = point_figures(joint, outer, middle, 40.0, 40e-3)
    for row, (one, two) in enumerate(((3, 0), (0, 2))):
        alone: Joint = replace(joint, outer=design.outer[one], middle=design.middle[two])
        solution = stroke(alone, 40.0, 40e-3)
        np.testing.assert_allclose(columns["stroke_mm"][row], solution.stroke * 1e3)
        np.testing.assert_allclose(columns["tendon_strain"][row], solution.tendon_strain)
        np.testing.assert_allclose(columns["closure_curvature_per_m"][row], alone.closure_curvature)


@pytest.mark.parametrize("section", ["sector", "chord"])
def test_the_web_strain_is_the_furthest_fibre_of_the_section(design, section):
    """Against points of the remaining section, taken one by one."""
    tube = replace(design.outer[1], section=section)
    ro, ri, depth = tube.outer_radius, tube.inner_radius, tube.depth[0]
    radius, angle = np.meshgrid(np.linspace(ri, ro, 200), np.linspace(-np.pi, np.pi, 4001))
    height = radius * np.cos(angle)
    half = np.arccos((depth - ro) / ro)
    left = np.abs(angle) <= half if section == "sector" else height >= depth - ro
    furthest = np.max(np.abs(height[left] - tube.notch.neutral_axis[0]))
    strain = 10.0 * tube.strain_per_curvature.max()
    np.testing.assert_allclose(strain, 10.0 * 2.0 * furthest, rtol=2e-3)
