"""The superelastic loop of a joint against fibres that each remember: the same loop, whatever drives."""

import itertools

import numpy as np
import pytest

from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.library.tube_hysteresis import TubeHysteresis
from coast_cli.mechanics.fibres import moment_history, ring_fibres, strip_fibres
from coast_cli.mechanics.joint import Joint, Tendon, tendon_shortening
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tube import NotchedTube

ONE = np.ones(60)
TUBE = NotchedTube("wrist", 0.25e-3, 0.2e-3, 0.314e-3 * ONE, 3e-4 * ONE, 3e-4 * ONE, 45e9, 6450.0)
EFFECT = TubeHysteresis(300.0, 120.0, 0.95)
LENGTH = 0.03


def law_of(effect):
    return Superelastic(
        45e9,
        45e9,
        1e6 * effect.upper_plateau_mpa,
        1e6 * effect.lower_plateau_mpa,
        0.046,
        (1 - effect.stiffness_lost) * 45e9,
    )


def remembered(joint, peaks):
    """Curvature, stroke and tension of a joint whose layers each remember, along curvatures of the strip."""
    bend = np.concatenate([np.linspace(a, b, 120) for a, b in itertools.pairwise(peaks)])
    moment = moment_history(strip_fibres(0.25e-3, 0.2e-3, 0.314e-3), law_of(EFFECT), bend)[0]
    curvature = 0.5 * bend + 0.5 * moment / (45e9 * float(ring_fibres(0.25e-3, 0.2e-3).inertia))
    tension = moment / joint.lever_arm
    if joint.tendon is None:
        return curvature, None, tension
    return curvature, tendon_shortening(joint, curvature, LENGTH) + tension / joint.tendon.stiffness, tension


def bent(joint, effect, stroke, tension):
    drive = tension if stroke is None else stroke
    run = History(None, stroke, tension if stroke is None else None, np.full(drive.size, LENGTH))
    return predict(joint, [effect], [run], Layout("curvature", 1, 300.0))[0].response[:, 0]


@pytest.mark.parametrize("tendon", [None, Tendon(3.8e-5, 53.965e9, 0.38868)])
@pytest.mark.parametrize("peak", [110.0, 180.0, 280.0])
def test_a_loop_is_that_of_layers_that_remember(tendon, peak):
    joint = Joint(None, TUBE, tendon, 45e9)
    curvature, stroke, tension = remembered(joint, [0.0, peak, 0.0])
    found = bent(joint, EFFECT, stroke, tension)
    assert found == pytest.approx(curvature, abs=0.015 * curvature.max())
    assert np.ptp(bent(joint, EFFECT.null(), stroke, tension) - curvature) > 0.02 * curvature.max()


def test_inner_loops_are_near_those_of_layers():
    joint = Joint(None, TUBE, None, 45e9)
    curvature, stroke, tension = remembered(joint, [0.0, 250.0, 130.0, 250.0, 0.0])
    found = bent(joint, EFFECT, stroke, tension)
    assert np.sqrt(np.mean((found - curvature) ** 2)) < 0.03 * curvature.max()


def test_below_the_plateau_nothing_is_left_behind():
    joint = Joint(None, TUBE, None, 45e9)
    curvature, stroke, tension = remembered(joint, [0.0, 50.0, 0.0, 40.0])
    assert bent(joint, EFFECT, stroke, tension) == pytest.approx(curvature, rel=1e-6, abs=1e-6)


def test_plateaus_come_back_from_a_fit():
    from scipy.optimize import least_squares

    joint = Joint(None, TUBE, Tendon(3.8e-5, 53.965e9, 0.38868), 45e9)
    curvature, stroke, tension = remembered(joint, [0.0, 250.0, 0.0])
    noisy = curvature + np.random.default_rng(0).normal(0.0, 0.2, curvature.size)
    start = np.array([200.0, 60.0, 0.8])
    fit = least_squares(
        lambda v: bent(joint, TubeHysteresis(*v), stroke, tension) - noisy,
        start,
        x_scale=start,
        bounds=([20.0, 5.0, 0.0], [1000.0, 900.0, 0.98]),
        diff_step=1e-3,
    )
    assert fit.x[:2] == pytest.approx([300.0, 120.0], rel=0.05)
    assert fit.x[2] == pytest.approx(0.95, abs=0.02)
