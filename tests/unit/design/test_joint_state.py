"""A joint step by step is the forward model of the whole history, whatever friction and play remember."""

import numpy as np
import pytest

from coast_cli.design.joint_state import JointState
from coast_cli.effects.catalogue import build_effects
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.errors import BadInput, UsageError
from coast_cli.mechanics.joint import curvature_from_stroke, tip
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config_text


def law(stage, variable, memory, weights, high, setting=0.0):
    """The table of a law without a name, as a model file has it."""
    names = ("stage", "variable", "memory", "setting", "low", "high", "weights")
    return dict(zip(names, (stage, variable, memory, setting, 0.0, high, list(weights)), strict=True))


ITERATED = ("creep", "set", "laws of the tendon")  # the forward model to 1e-8 m of slack
MEMORIES = {
    "nothing": {},
    "friction": {"coulomb_friction": {"holds_per_m": 6.0, "spread": 0.4, "held_per_m": 2.0}},
    "capstan": {"capstan_hysteresis": {"pulley_friction": 0.2, "notch_friction_exponent": 0.003, "spread": 0.0}},
    "rounded capstan": {"capstan_hysteresis": {"pulley_friction": 0.2, "spread": 0.5}},
    "play and screw": {"backlash": {"width_mm": 0.3}, "leadscrew_pitch_error": {"sine_mm": 0.03, "cosine_mm": 0.01}},
    "friction along": {
        "distributed_notch_friction": {"coefficient": 0.4, "own_share": 0.5},
        "backlash": {"width_mm": 0.1},
    },
    "rest and plateau": {
        "precurvature": {"curvature_per_m": 4.0},
        "tendon_superelasticity": {"knee_n": 1.0, "extra_compliance": 2.0},
    },
    "camera": {"camera_scale": {"scale": 1.1}, "sensor_lag": {"time_constant_s": 0.2, "delay_s": 0.15}},
    "creep": {"tendon_creep": {"fraction": 0.3, "time_constant_s": 1.5}},
    "set": {"tendon_permanent_set": {"slack_mm_per_n": 0.15, "threshold_n": 0.4}, "backlash": {"width_mm": 0.1}},
    "laws of the segment": {
        "unnamed_1": law("structure", "curvature", "friction", (3.0, 1.0), 60.0),
        "unnamed_2": law("transmission", "curvature", "none", (0.05, 0.02), 60.0),
    },
    "laws of drive and camera": {
        "unnamed_1": law("drive", "stroke", "friction", (0.06,), 5e-3),
        "unnamed_2": law("sensor", "curvature", "none", (0.5, 1.0), 60.0),
    },
    "laws that come late": {
        "unnamed_1": law("drive", "stroke", "relaxation", (0.2,), 5e-3, 1.5),
        "unnamed_2": law("sensor", "curvature", "relaxation", (2.0,), 60.0, 0.7),
    },
    "laws of the tendon": {
        "unnamed_1": law("tendon", "tension", "maximum", (0.05,), 2.0),
        "unnamed_2": law("tendon", "tension", "none", (0.05, 0.02), 2.0),
    },
    "snap": {"snap_through": {"curvature_per_m": 20.0, "drop": 0.3, "sharpness": 0.2, "back": 0.5}},
}
LOW, HIGH, ROWS, LIMIT = 0.02, 0.04, 241, 120.0


@pytest.fixture(scope="module")
def joint():
    from pathlib import Path

    text = (Path(__file__).parents[3] / "configs" / "tubes.toml").read_text(encoding="utf-8")
    return build(load_config_text(text)).joint()


def history(*, sliding):
    """Return a drive that turns round at odd strokes, X2 sliding over the whole range or at its end."""
    phase = np.linspace(0.0, 1.0, ROWS)
    stroke = 1e-3 * (2.4 - 2.4 * np.cos(14.0 * phase) * (1.0 - 0.4 * phase))
    length = 0.5 * (LOW + HIGH) - 0.5 * (HIGH - LOW) * np.cos(2.0 * np.pi * phase) if sliding else np.full(ROWS, LOW)
    return History(np.linspace(0.0, 6.0, ROWS), stroke, None, length)


def stepped(joint, effects, run):
    lengths = (float(run.bending_length.min()), float(run.bending_length.max()))
    state = JointState(joint, effects, bending_lengths=lengths, largest_curvature=LIMIT)
    times = np.diff(run.time, prepend=run.time[0])
    return [
        state.step(*row) for row in zip(times.tolist(), run.stroke.tolist(), run.bending_length.tolist(), strict=True)
    ]


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("name", MEMORIES)
def test_steps_are_the_forward_model_of_the_history(joint, name, sliding):
    effects, run = build_effects(MEMORIES[name]), history(sliding=sliding)
    expected = predict(joint, effects, [run], Layout("curvature", 1, LIMIT))[0]
    found = stepped(joint, effects, run)
    near = 2e-3 if name in ITERATED else 1e-9
    np.testing.assert_allclose([step.seen_curvature for step in found], expected.response[:, 0], rtol=near, atol=near)
    coarse = 1e-3 if name in ("rest and plateau", *ITERATED) else 1e-9  # the forward model's own table of the tendon
    np.testing.assert_allclose([step.tension for step in found], expected.tension, rtol=coarse, atol=coarse)


@pytest.mark.parametrize("name", [name for name in MEMORIES if name not in ("nothing", "camera")])
def test_memories_do_remember(joint, name):
    run = history(sliding=False)
    plain, held = (
        np.array([one.seen_curvature for one in stepped(joint, build_effects(MEMORIES[key]), run)])
        for key in ("nothing", name)
    )
    assert np.abs(held - plain).max() > 0.5


def test_without_corrections_it_is_the_joint_model(joint):
    state = JointState(joint, bending_lengths=(LOW, HIGH))
    for stroke, length in ((0.0, 0.02), (2.0e-3, 0.02), (3.0e-3, 0.0275), (1.0e-3, 0.04)):
        step = state.step(0.01, stroke, length)
        exact = curvature_from_stroke(joint, stroke, length)
        assert step.curvature == pytest.approx(float(exact.curvature), rel=2e-3, abs=1e-9)
        assert (step.tip_x, step.tip_y) == pytest.approx(tuple(map(float, tip(step.curvature, length))), rel=1e-12)


@pytest.mark.parametrize(
    "effect",
    [
        {"lost_steps": {"lost_mm": 0.1, "time_s": 5.0}},
        {"viscous_friction": {"time_constant_s": 0.1}},
        {"unnamed_1": law("structure", "curvature", "relaxation", (1.0,), 60.0, 2.0)},
        {"unnamed_1": law("drive", "rate", "none", (0.1,), 1.0)},
        {"unnamed_1": law("tendon", "tension", "friction", (0.05,), 2.0)},
        {"thermal_drift": {"stiffness_change": 0.1, "time_constant_s": 5.0}},
        {"tube_hysteresis": {"upper_plateau_mpa": 300.0, "lower_plateau_mpa": 100.0, "stiffness_lost": 0.9}},
    ],
)
def test_what_needs_the_whole_history_is_refused(joint, effect):
    with pytest.raises(BadInput, match="needs more of the history than a step has"):
        JointState(joint, build_effects(effect), bending_lengths=(LOW, HIGH))


@pytest.mark.parametrize(
    "step", [(np.nan, 1e-3, 0.03), (-0.1, 1e-3, 0.03), (0.1, np.inf, 0.03), (0.1, 1e-3, 0.05), (0.1, 1e-3, np.nan)]
)
def test_steps_that_nobody_can_take_are_refused_and_change_nothing(joint, step):
    state = JointState(joint, build_effects(MEMORIES["play and screw"]), bending_lengths=(LOW, HIGH))
    before = state.step(0.0, 2e-3, 0.03)
    with pytest.raises(UsageError, match="step: "):
        state.step(*step)
    assert state.step(0.1, 2e-3, 0.03) == before


@pytest.mark.parametrize("lengths", [(0.0, 0.02), (0.03, 0.02), (0.02, 0.2)])
def test_bending_lengths_that_the_tubes_do_not_have_are_refused(joint, lengths):
    with pytest.raises(UsageError, match="bending_lengths"):
        JointState(joint, bending_lengths=lengths)
