"""Tubes that have a stress-strain curve of their own: what is fitted takes the place of its plateaus, and the rest stays."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares

from coast_cli.diagnosis.joint.words import plateau_note
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.library.tube_hysteresis import TubeHysteresis
from coast_cli.effects.library.tube_superelasticity import TubeSuperelasticity
from coast_cli.effects.plateau import fitted_law, has_own_curve
from coast_cli.mechanics.fibres import moment_history, ring_fibres, strip_fibres
from coast_cli.mechanics.joint import Joint, Tendon, tendon_shortening
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tube import NotchedTube

ONE = np.ones(60)
E = 45e9
DATA_SHEET = Superelastic(E, 25e9, 450e6, 180e6, 0.046, 2e9, 1.2)
TRUE = replace(DATA_SHEET, upper_plateau=360e6, lower_plateau=140e6)
TUBE = NotchedTube("own", 0.25e-3, 0.2e-3, 0.314e-3 * ONE, 3e-4 * ONE, 3e-4 * ONE, E, 6450.0, superelastic=DATA_SHEET)
JOINT = Joint(None, TUBE, Tendon(3.8e-5, 53.965e9, 0.38868), E)
LENGTH, LOST = 0.03, 1.0 - 2e9 / E


def remembered(peaks, law=TRUE):
    """Stroke and curvature of a joint whose layers each remember, along curvatures of the strip."""
    bend = np.concatenate([np.linspace(a, b, 100) for a, b in itertools.pairwise(peaks)])
    moment = moment_history(strip_fibres(0.25e-3, 0.2e-3, 0.314e-3), law, bend)[0]
    curvature = 0.5 * bend + 0.5 * moment / (E * float(ring_fibres(0.25e-3, 0.2e-3).inertia))
    return tendon_shortening(JOINT, curvature, LENGTH) + moment / JOINT.lever_arm / JOINT.tendon.stiffness, curvature


def bent(stroke, *effects):
    run = History(None, stroke, None, np.full(stroke.size, LENGTH))
    return predict(JOINT, effects, [run], Layout("curvature", 1, 300.0))[0].response[:, 0]


def fitted(effect, stroke, curvature):
    """Return the effect with its numbers fitted to a noisy curve."""
    noisy = curvature + np.random.default_rng(0).normal(0.0, 0.2, curvature.size)
    start = np.array(effect.values())
    bounds = np.transpose([(p.low, p.high) for p in effect.parameters])
    found = least_squares(
        lambda v: bent(stroke, effect.with_values(v)) - noisy, start, x_scale=start, bounds=bounds, diff_step=1e-3
    )
    return effect.with_values(found.x)


def test_nulls_leave_the_configured_curve():
    stroke, curvature = remembered([0.0, 200.0], DATA_SHEET)
    assert bent(stroke) == pytest.approx(curvature, abs=0.003 * curvature.max())
    for kind in (TubeHysteresis, TubeSuperelasticity):
        assert np.array_equal(bent(stroke, kind.null()), bent(stroke))


@pytest.mark.parametrize("effect", [TubeHysteresis(450.0, 180.0, LOST), TubeSuperelasticity(0.45 / 45.0, LOST)])
def test_the_configured_plateaus_change_nothing_on_load(effect):
    stroke, _ = remembered([0.0, 200.0], DATA_SHEET)
    assert bent(stroke, effect) == pytest.approx(bent(stroke), rel=1e-3)


def test_other_plateaus_give_the_loop_of_layers_that_remember():
    stroke, curvature = remembered([0.0, 220.0, 0.0])
    assert bent(stroke, TubeHysteresis(360.0, 140.0, LOST)) == pytest.approx(curvature, abs=0.02 * curvature.max())


def test_both_plateaus_come_back_in_mpa():
    found = fitted(TubeHysteresis(450.0, 180.0, 0.8), *remembered([0.0, 220.0, 0.0]))
    assert (found.upper_plateau_mpa, found.lower_plateau_mpa) == pytest.approx((360.0, 140.0), rel=0.03)


def test_the_upper_plateau_comes_back_from_load_alone():
    found = fitted(TubeSuperelasticity(0.012, 0.8), *remembered([0.0, 220.0]))
    assert found.plateau(JOINT) == pytest.approx(360e6, rel=0.02)


def test_only_tubes_of_a_curve_have_one():
    assert has_own_curve(JOINT)
    assert not has_own_curve(JOINT.elastic)


def test_high_plateaus_leave_the_lower_one_its_length():
    law = fitted_law(DATA_SHEET, E, 3e9, 1e8, 0.95)
    assert law.lower_length == pytest.approx(0.5 * law.transformation_strain)
    assert 0.0 < law.martensite_modulus <= E


def test_a_plateau_fitted_as_a_strain_is_said_in_mpa():
    problem = SimpleNamespace(joints={"own": JOINT}, values=lambda _: {"youngs_modulus_gpa": 40.0})
    fit = SimpleNamespace(effects=(TubeSuperelasticity(0.009, LOST),), coordinates=np.zeros(1))
    assert "360 MPa" in plateau_note(problem, fit)[0]
    assert not plateau_note(SimpleNamespace(joints={"linear": JOINT.elastic}), fit)
