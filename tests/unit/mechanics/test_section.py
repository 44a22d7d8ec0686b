"""Sections against the integral over their own area, which knows no closed form."""

import numpy as np
import pytest

from coast_cli.mechanics.section import full_section, notched_section, strip_across

OUTER, INNER = 0.25e-3, 0.2e-3
CELLS = 2000


def integrated(depth, kind):
    """Area, centroid and second moment of what a notch leaves, summed over polar cells."""
    radius = INNER + (np.arange(CELLS) + 0.5) * (OUTER - INNER) / CELLS
    angle = -np.pi + (np.arange(CELLS) + 0.5) * 2.0 * np.pi / CELLS
    r, a = np.meshgrid(radius, angle)
    cell = r * (OUTER - INNER) / CELLS * 2.0 * np.pi / CELLS
    height = r * np.cos(a)
    edge = np.arccos((depth - OUTER) / OUTER)
    kept = np.abs(a) <= edge if kind == "sector" else height >= depth - OUTER
    area = np.sum(cell[kept])
    centroid = np.sum((cell * height)[kept]) / area
    return area, centroid, np.sum((cell * (height - centroid) ** 2)[kept])


@pytest.mark.parametrize("kind", ["sector", "chord"])
@pytest.mark.parametrize("depth", [0.26e-3, 0.314e-3, 0.4e-3, 0.43e-3])
def test_closed_forms_equal_the_integral(kind, depth):
    section = notched_section(OUTER, INNER, depth, kind)
    area, centroid, second_moment = integrated(depth, kind)
    assert float(section.area) == pytest.approx(area, rel=2e-3)
    assert float(section.neutral_axis) == pytest.approx(centroid, rel=2e-3)
    assert float(section.second_moment) == pytest.approx(second_moment, rel=5e-3)


def test_past_the_bore_only_the_outer_circle_is_left():
    past = notched_section(OUTER, INNER, OUTER + 1.1 * INNER, "chord")
    solid = notched_section(OUTER, 1e-9, OUTER + 1.1 * INNER, "chord")
    assert float(past.second_moment) == pytest.approx(float(solid.second_moment), rel=1e-6)


def test_the_sector_overstates_the_chord():
    depths = np.array([0.314e-3, 0.35e-3, 0.4e-3])
    ratio = (
        notched_section(OUTER, INNER, depths).second_moment
        / notched_section(OUTER, INNER, depths, "chord").second_moment
    )
    assert np.all((ratio > 1.05) & (ratio < 2.1))


def test_the_ring_is_a_notch_of_no_angle_lost():
    ring = full_section(OUTER, INNER)
    assert float(ring.area) == pytest.approx(np.pi * (OUTER**2 - INNER**2))
    assert float(ring.second_moment) == pytest.approx(np.pi / 4.0 * (OUTER**4 - INNER**4))


def test_sections_broadcast():
    assert notched_section(OUTER, np.full((2, 1), INNER), np.full(3, 0.3e-3)).area.shape == (2, 3)


@pytest.mark.parametrize("kind", ["sector", "chord"])
@pytest.mark.parametrize("depth", [0.25e-3, 0.314e-3, 0.38e-3])
def test_across_the_notch_by_integration_in_two_dimensions(kind, depth):
    ro, ri = 0.25e-3, 0.2e-3
    half = np.arccos((depth - ro) / ro) if kind == "sector" else np.pi
    radius = ri + (ro - ri) * (np.arange(200) + 0.5) / 200
    angle = half * (np.arange(4000) + 0.5) / 4000
    height = radius[:, None] * np.cos(angle)
    kept = height > (depth - ro if kind == "chord" else -1.0)
    area = radius[:, None] * (ro - ri) / 200 * 2.0 * half / 4000 * kept
    across, torsion = strip_across(ro, ri, depth, kind)
    assert across == pytest.approx((area * (radius[:, None] * np.sin(angle)) ** 2).sum(), rel=2e-3)
    assert torsion == pytest.approx(
        area.sum() * (ro - ri) ** 2 / 3.0, rel=0.12
    )  # a strip of wall t and area A: A t^2/3
