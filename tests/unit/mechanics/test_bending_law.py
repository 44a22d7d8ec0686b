from dataclasses import replace

import numpy as np
import pytest

from coast_cli.mechanics.bending_law import bending_law, interpolated
from coast_cli.mechanics.fibres import moment_curvature, ring_fibres, strip_fibres
from coast_cli.mechanics.joint import Joint, Tendon, curvature_from_stroke, joints_of, stroke
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import tubes_of

LAW = Superelastic(45e9, 25e9, 300e6, 120e6, 0.046, 0.5e9, 1.2)
ONE = np.ones(125)


def tube(depth=0.314, law=LAW, section="sector", outer=0.25, inner=0.2):
    depths = np.asarray(depth) * 1e-3 * ONE
    radii = outer * 1e-3, inner * 1e-3
    return NotchedTube(
        "tube", *radii, depths, 3e-4 * ONE, 3e-4 * ONE, 45e9, 6450.0, section=section, end_length=5e-5, superelastic=law
    )


def tube_law(one, modulus, **way):
    return bending_law(one.row, one.superelastic, modulus, **way)


def row(*values):
    return np.array([values])


def joint(law=LAW):
    tendon = Tendon(3.8e-5, 53.965e9, 0.38868)
    middle = tube(0.243, law, outer=0.18, inner=0.14)
    return Joint(tube(0.4, law), middle, tendon, 42.6e9, 0.2965, np.pi, 1.0063, 1.2e-3)


@pytest.mark.parametrize("section", ["sector", "chord"])
@pytest.mark.parametrize("unloading", [False, True])
def test_below_the_plateau_it_is_the_series_rigidity(section, unloading):
    one = tube(section=section)
    law = tube_law(one, 45e9, towards_notch=True, unloading=unloading)
    first = law.curvature[0, 1]
    assert law.rigidity[0, 0] == pytest.approx(one.rigidity_series, rel=1e-12)
    curvature = np.linspace(-first, first, 9)[None]
    assert np.array_equal(law.carried(curvature), curvature)
    assert np.all(law.slope(0.9 * curvature) == 1.0)
    assert law.strain_at(curvature)[0, -1] == pytest.approx((0.4 if unloading else 1.0) * LAW.yield_strain)
    assert (
        law.strain_at(curvature)[0, -1] < one.strain_per_curvature[0] * first
    )  # which gives the whole bend to the cut


def test_past_it_ring_and_strip_bend_in_series():
    one = tube()
    law = tube_law(one, 45e9, towards_notch=True)
    strip, ring = strip_fibres(0.25e-3, 0.2e-3, 0.314e-3), ring_fibres(0.25e-3, 0.2e-3)
    for bend in (200.0, 400.0, 800.0):
        moment = moment_curvature(strip, LAW, [bend])[0][0]
        curvature = (3.5e-4 * bend + 3e-4 * moment / (45e9 * ring.inertia)) / 6e-4
        found = law.carried(row(curvature)) * one.rigidity_series
        assert found[0, 0] == pytest.approx(moment, rel=3e-4)


def test_a_ring_past_its_own_plateau():
    weak = replace(LAW, upper_plateau=300e6, plateau_modulus=12e9)
    one = tube(0.26)
    law = tube_law(replace(one, superelastic=weak), 45e9, towards_notch=True)
    strip, ring = strip_fibres(0.25e-3, 0.2e-3, 0.26e-3), ring_fibres(0.25e-3, 0.2e-3)
    moment = moment_curvature(strip, weak, [900.0])[0][0]
    bends = np.linspace(0.0, 600.0, 4001)
    ring_bend = np.interp(moment, moment_curvature(ring, weak, bends)[0], bends)
    assert ring_bend > weak.upper_plateau / 45e9 / 0.25e-3  # past its plateau indeed
    curvature = (3.5e-4 * 900.0 + 3e-4 * ring_bend) / 6e-4
    found = law.carried(row(curvature)) * law.rigidity
    assert found[0, 0] == pytest.approx(moment, rel=1e-3)


def test_notches_that_differ_add_their_bends():
    depths = np.where(np.arange(125) < 25, 0.3, 0.36)
    laws = [tube_law(tube(depth), 45e9, towards_notch=True) for depth in (0.3, 0.36)]
    mixed = tube_law(tube(depths), 45e9, towards_notch=True)
    curvature = row(20.0, 60.0, 120.0)
    moment = mixed.carried(curvature) * mixed.rigidity
    bends = [interpolated(moment, law.moment, law.curvature) for law in laws]
    assert 0.2 * bends[0] + 0.8 * bends[1] == pytest.approx(curvature, rel=1e-3)


def test_a_bend_away_from_the_notch_presses_the_skin_and_is_held_longer_by_compression():
    towards, away = (tube_law(tube(), 45e9, towards_notch=way) for way in (True, False))
    assert towards.carried(row(150.0)) != pytest.approx(away.carried(row(150.0)), rel=1e-3)
    even = tube(law=replace(LAW, compression_ratio=1.0))
    ways = [tube_law(even, 45e9, towards_notch=way).carried(row(150.0)) for way in (True, False)]
    assert ways[0] == pytest.approx(ways[1])


def test_release_lies_below_load():
    load, release = (tube_law(tube(), 45e9, towards_notch=True, unloading=way) for way in (False, True))
    curvature = np.linspace(1.0, 300.0, 60)[None]
    assert np.all(release.carried(curvature) <= load.carried(curvature))
    assert release.carried(row(100.0)) < 0.7 * load.carried(row(100.0))


def test_a_joint_below_its_plateau_is_the_linear_one():
    curvature, length = np.array([0.0, 5.0, 20.0]), 0.03
    linear, curved = stroke(joint(None), curvature, length), stroke(joint(), curvature, length)
    assert curved.stroke == pytest.approx(linear.stroke, rel=1e-12)
    assert curved.tension == pytest.approx(linear.tension, rel=1e-12)


def test_past_the_plateau_a_joint_pulls_less_and_its_inverse_returns():
    curvature = np.linspace(0.0, 160.0, 33)
    linear, curved = stroke(joint(None), curvature, 0.02), stroke(joint(), curvature, 0.02)
    assert np.all(curved.tension[-20:] < linear.tension[-20:])
    back = curvature_from_stroke(joint(), curved.stroke, 0.02)
    assert back.verdict.converged
    assert back.curvature == pytest.approx(curvature, abs=1e-9)
    assert back.tension == pytest.approx(curved.tension)


def test_a_warmer_tube_is_stiffer():
    cold, warm = (joint(replace(LAW).warmer(kelvin)) for kelvin in (0.0, 15.0))
    assert np.all(stroke(warm, [100.0], 0.02).tension > 1.05 * stroke(cold, [100.0], 0.02).tension)


def test_rows_of_many_tubes_are_each_their_own():
    one, other = joint().outer, replace(joint().outer, depth=0.36e-3 * ONE)
    many = tubes_of([one, other, one])
    moduli = np.array([45e9, 45e9, 40e9])
    law = bending_law(many, LAW, moduli, towards_notch=True)
    for index, (tube_, modulus) in enumerate(zip((one, other, one), moduli, strict=True)):
        own = bending_law(tube_.row, LAW, modulus, towards_notch=True)
        assert law.moment[index] == pytest.approx(own.moment[0], rel=1e-9)
        assert law.carried(np.full((3, 1), 120.0))[index] == pytest.approx(own.carried(row(120.0))[0], rel=1e-9)


def test_many_pairs_at_once_are_the_joints_one_by_one():
    base = joint()
    outer = tubes_of([base.outer, replace(base.outer, depth=0.36e-3 * ONE)])
    middle = tubes_of([base.middle, base.middle])
    many = stroke(joints_of(base, outer, middle), 110.0, 0.03)
    for index in range(2):
        one = stroke(replace(base, outer=replace(base.outer, depth=outer.depth[index])), 110.0, 0.03)
        assert many.stroke[index] == pytest.approx(float(one.stroke), rel=1e-9)


def test_tables_of_very_many_tubes_are_coarser_and_still_near():
    one = joint().outer
    many = tubes_of([one] * 80)
    fine = bending_law(one.row, LAW, 45e9, towards_notch=True)
    coarse = bending_law(many, LAW, 45e9, towards_notch=True)
    for bend in (40.0, 90.0, 120.0, 200.0, 400.0):
        assert coarse.carried(np.full((80, 1), bend))[0] == pytest.approx(fine.carried(row(bend))[0], rel=2e-3)
