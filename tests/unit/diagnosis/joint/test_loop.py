"""Widths of loops that are known: play, friction along the tendon, and recordings without a loop."""

import numpy as np
import pytest

from coast_cli.diagnosis.joint.loop import widest_loop
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.capstan_hysteresis import CapstanHysteresis
from coast_cli.spec.build import build_joint
from tests.modelled_joint import CONFIG, make_run, recording


def sweeps(*effects):
    """One load and release to slack of the reference pair with effects, and little noise."""
    stroke = np.concatenate([np.linspace(0.0, 4e-3, 60), np.linspace(4e-3, 0.0, 60)[1:]])
    joint = build_joint(CONFIG, "OT4", "MT1")
    history = History(None, stroke, None, np.full(stroke.size, 0.03))
    response = predict(joint, effects, [history], Layout("curvature", 1, 160.0))[0].response
    return [make_run(stroke, response + 0.05 * np.random.default_rng(0).standard_normal(response.shape))]


def test_play_is_as_wide_everywhere():
    loop = widest_loop(sweeps(Backlash(width_mm=0.2)))
    assert loop.low == pytest.approx(0.2e-3, rel=0.1)
    assert loop.high == pytest.approx(0.2e-3, rel=0.1)
    assert loop.meaning.startswith("it is as wide everywhere")


def test_friction_along_the_tendon_closes_towards_slack():
    loop = widest_loop(sweeps(CapstanHysteresis(pulley_friction=0.1)))
    assert loop.low < 0.5 * loop.high
    assert loop.meaning.startswith("it widens with tension")


def test_without_a_way_back_to_slack_there_is_no_loop():
    assert widest_loop(recording((Backlash(width_mm=0.2),))) is None
