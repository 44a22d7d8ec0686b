"""A segment whose outer tube ends on the way: two springs in series, each with its own bend."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.design.loading import corrected_stroke
from coast_cli.design.reach import require_covered
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.library.coulomb_friction import CoulombFriction
from coast_cli.errors import BadInput
from coast_cli.mechanics.beam import solve_segments
from coast_cli.mechanics.joint import (
    Joint,
    Tendon,
    curvature_from_stroke,
    segment_parts,
    segment_tip,
    stroke,
    tension,
    tip,
)
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.spec.build import build
from coast_cli.spec.load import REFERENCE, load_config_text, read_text

ONE = np.ones(120)
SOFT = Superelastic(45e9, 25e9, 400e6, 180e6, 0.046, 5e8)
COVER, KAPPA = 0.025, np.array([0.0, 8.0, 20.0, 45.0])


def tube(size, law=None):
    """A tube of the outer one's proportions, so that ring and strip of both are in one ratio."""
    lengths = (size * 0.25e-3, size * 0.2e-3, size * 0.4e-3 * ONE)
    return NotchedTube("tube", *lengths, 3e-4 * ONE, 3e-4 * ONE, 45e9, 6450.0, superelastic=law)


def joint(cover=COVER, law=None, size=0.72):
    tendon = Tendon(3.8e-5, 53.965e9, 0.38868)
    return Joint(tube(1.0, law), tube(size, law), tendon, 45e9, 0.2, 3.0, 1.004, 1e-3, cover)


@pytest.mark.parametrize("law", [None, SOFT])
def test_up_to_the_cover_nothing_changes(law):
    for length in (0.012, COVER):
        even, uneven = stroke(joint(None, law), KAPPA, length), stroke(joint(COVER, law), KAPPA, length)
        assert np.array_equal(even.stroke, uneven.stroke)
        assert np.array_equal(even.tension, uneven.tension)
        assert np.allclose(segment_tip(joint(COVER, law), KAPPA, length), tip(KAPPA, length), atol=1e-18)


@pytest.mark.parametrize("law", [None, SOFT])
def test_the_inverse_comes_back(law):
    found = curvature_from_stroke(joint(COVER, law), stroke(joint(COVER, law), KAPPA, 0.04).stroke, 0.04)
    assert found.verdict.converged
    assert found.curvature == pytest.approx(KAPPA, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("law", [None, SOFT])
def test_one_moment_goes_through_both_parts(law):
    one = joint(COVER, law)
    inside, beyond = segment_parts(one, KAPPA, 0.04)
    both = one.rigidity * one.softening.carried(inside.curvature)
    assert one.free.rigidity * one.free.softening.carried(beyond.curvature) == pytest.approx(both, rel=1e-9)
    mean = inside.share * inside.curvature + beyond.share * beyond.curvature
    assert mean == pytest.approx(KAPPA, rel=1e-14)
    step = 1e-4
    for before, after, here in zip(
        *(segment_parts(one, KAPPA + change, 0.04) for change in (-step, step)), (inside, beyond), strict=True
    ):
        slope = (after.curvature - before.curvature) / (2.0 * step)
        assert here.rate[1:] == pytest.approx(slope[1:], rel=2e-3)


def test_the_beam_of_both_tubes_bends_alike():
    """The tubes' own pieces, cut by cut, under the tendon's moment at the tip: the shape solved in arc length."""
    one, length = joint(), 0.042
    cover = round(COVER / 6e-4) * 6e-4
    one = replace(one, outer_cover=cover)
    moment = tension(replace(one, pulley_friction=0.0, notch_friction=1.0), 30.0, length) * one.lever_arm
    outer, middle = (tube.segments.rigidity[: round(length / 3e-4)] for tube in (one.outer, one.middle))
    covered = (np.arange(outer.size) + 0.5) * 3e-4 < cover
    beam = solve_segments(3e-4, middle + np.where(covered, outer, 0.0), 0.0, 0.0, tip_moment=float(moment)).beam(0)
    x, y = segment_tip(one, 30.0, length)
    assert beam.angle[-1] == pytest.approx(30.0 * length, rel=1e-9)
    # Inside a pitch the ring bends less than the strip, which moves the tip by parts of a pitch.
    assert np.hypot(beam.x[-1] - x, beam.y[-1] - y) < 0.01 * 6e-4 + 30.0 * length * 6e-4
    even = tip(30.0, length)
    assert np.hypot(beam.x[-1] - even[0], beam.y[-1] - even[1]) > 2e-3


def test_the_figures_of_the_guide():
    even = build(load_config_text(read_text(REFERENCE), REFERENCE.name)).joint("OT4/MT1")
    one = replace(even, outer_cover=COVER)
    inside, beyond = (float(part.curvature) for part in segment_parts(one, 20.0, 0.04))
    moved = np.hypot(*np.subtract(segment_tip(one, 20.0, 0.04), tip(20.0, 0.04)))
    strokes = [1e3 * float(stroke(each, 20.0, 0.04).stroke) for each in (one, even)]
    assert (inside, beyond, *strokes, 1e3 * moved) == pytest.approx((14.0, 29.9, 2.515, 2.996, 2.9), rel=0.02)


@pytest.mark.parametrize("law", [None, SOFT])
def test_the_forward_model_has_the_same_segment(law):
    one, length = joint(COVER, law), np.full(KAPPA.size - 1, 0.04)
    direct = stroke(one, KAPPA[1:], 0.04)
    found = corrected_stroke(one, (), length, KAPPA[1:], inverse=False)
    assert found.stroke == pytest.approx(direct.stroke, rel=2e-4)
    assert found.tension == pytest.approx(direct.tension, rel=2e-3)
    run = History(None, direct.stroke, None, length)
    assert predict(one, [], [run], Layout("curvature"))[0].response[:, 0] == pytest.approx(KAPPA[1:], rel=2e-3)


def test_friction_keeps_its_loop_and_notches_their_parts():
    one = joint()
    up = stroke(one, np.linspace(0.0, 40.0, 30), 0.04).stroke
    run = History(None, np.concatenate((up, up[::-1])), None, np.full(60, 0.04))
    bend = predict(one, [CoulombFriction(2.0)], [run], Layout("curvature"))[0].response[:, 0]
    assert bend[45] > bend[14] + 1.0
    notches = predict(one, [], [run], Layout("notch", 66))[0].response[29]
    free = (np.arange(66) + 0.5) * 6e-4 + (0.04 - 66 * 6e-4) > COVER
    inside, beyond = (float(part.curvature) * 6e-4 for part in segment_parts(one, 40.0, 0.04))
    assert notches == pytest.approx(np.where(free, beyond, inside), rel=0.02)


def test_what_needs_one_curvature_refuses():
    with pytest.raises(BadInput, match="bend evenly"):
        require_covered(joint(), 0.03)
    require_covered(joint(), COVER)
    run = History(None, np.zeros(2), None, np.array([0.02, 0.03]))
    with pytest.raises(BadInput, match="cannot slide"):
        predict(joint(), [], [run], Layout("curvature"))
