"""The recordings are what they claim: the base model where nothing is concealed, honest physics where something is."""

import subprocess
import sys

import numpy as np
import pytest

from examples.concealed.camera import circle_curvature
from examples.concealed.case import make_case, narrowest
from examples.concealed.design import Joint, Tube, config_text
from examples.concealed.draw import LEVELS, SHOWN_BY_TENSION, draw_world
from examples.concealed.laws import BENCH, JOINT_EFFECTS, OUTSIDE, RECIPES
from examples.concealed.mechanism import simulate
from examples.concealed.refit import refit, surviving
from examples.concealed.world import Played, play_protocol

MM = 1e-3
OT4 = Tube("OT4", 0.5 * MM, 0.4 * MM, 0.4 * MM, 0.3 * MM, 0.3 * MM, 188, 1.1)
MT1 = Tube("MT1", 0.36 * MM, 0.28 * MM, 0.243 * MM, 0.3 * MM, 0.3 * MM, 125, 2.0)
S4 = Joint(OT4, MT1, 42.6e9, 0.2965, np.pi, 1.0063, 1.2 * MM, 0.038 * MM, 53.965e9, 388.68 * MM)


@pytest.mark.parametrize(
    ("curvature", "length", "stroke"), [(20, 20, 2.6001), (40, 20, 4.0002), (20, 40, 2.9955), (40, 40, 4.7913)]
)
def test_base_model_gives_the_reference_strokes(curvature, length, stroke):
    found, _ = S4.stroke(np.array(float(curvature)), length * MM)
    assert found * 1e3 == pytest.approx(stroke, abs=6e-5)
    assert S4.curvature(found, length * MM) == pytest.approx(curvature, abs=1e-9)


def test_a_configuration_means_to_the_library_what_it_means_here(tmp_path):
    world, *_ = draw_world(5, "L0")
    while world.robot.joint.tendon_radius == 0:
        world, *_ = draw_world(6, "L0")
    path = tmp_path / "tubes.toml"
    path.write_text(config_text(world.robot), encoding="utf-8")
    call = [sys.executable, "-m", "coast_cli", "stroke", str(path), "--kappa", "20", "--x2", "25", "--format", "csv"]
    done = subprocess.run(call, capture_output=True, text=True, check=True)
    row = dict(zip(*(line.split(",") for line in done.stdout.strip().splitlines()), strict=True))
    stroke, tension = world.robot.joint.stroke(np.array(20.0), 25 * MM)
    assert float(row["stroke_mm"]) == pytest.approx(stroke * 1e3, rel=1e-9)
    assert float(row["tension_n"]) == pytest.approx(tension, rel=1e-9)


def test_the_fine_mechanism_without_effects_is_the_base_model():
    for seed in range(12):
        world, *_ = draw_world(seed, "L0")
        clean = play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams)
        fine = play_protocol(world.actual, world.protocol, {"none": {}}, world.curvature, world.streams)
        assert np.abs(fine.response - clean.response).max() < 1e-3 * clean.response.max()
        assert np.abs(fine.tension - clean.tension).max() < 1e-3 * clean.tension.max()


def test_a_clean_record_is_single_valued_and_leaves_only_noise():
    for seed in range(20):
        case = make_case(seed, "L0")
        assert case.truth["effects"] == []
        world, *_ = draw_world(seed, "L0")
        played = play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams)
        truth = np.concatenate([np.array(rows) for rows in case.truth["response"].values()])
        assert np.sqrt(np.mean((truth - played.response) ** 2)) < 0.5 * world.sigma
        assert surviving(played.rows, played.response) < 1e-6


def test_noise_has_the_stated_level():
    for seed in range(12):
        case = make_case(seed, "L0")
        noise = case.truth["noise"]
        seen = recorded(case)
        truth = np.concatenate([np.array(rows) for rows in case.truth["response"].values()])
        off = (seen - truth)[np.isfinite(seen)]
        robust = 1.4826 * np.median(np.abs(off))
        if noise["kind"] == "white":
            assert robust == pytest.approx(noise["sigma"], rel=0.2)


def recorded(case):
    rows = []
    for name in sorted(case.files):
        lines = case.files[name].strip().splitlines()
        header = lines[0].split(",")
        at = [i for i, key in enumerate(header) if key in ("curvature_per_m", "bend_deg") or key.startswith("notch_")]
        rows += [[float(line.split(",")[i] or "nan") for i in at] for line in lines[1:]]
    return np.array(rows)


@pytest.mark.parametrize("effect", [*JOINT_EFFECTS, *OUTSIDE, *BENCH])
def test_every_effect_shows_above_the_refitted_base(effect):
    world, level, names, sizes = draw_world(2, effect=effect)
    assert level == ("L1" if effect in JOINT_EFFECTS else "L6" if effect in OUTSIDE else "L9")
    assert names == [effect]
    if effect in SHOWN_BY_TENSION:
        assert sizes[effect] > RECIPES[effect].floor
        return
    played = play_protocol(world.actual, world.protocol, world.effects, world.curvature, world.streams)
    assert np.isfinite(played.response).all()
    best, fitted = refit(played.rows, played.response)
    left = np.sqrt(np.mean((played.response - fitted[:, None]) ** 2))
    assert left > 0.95 * RECIPES[effect].floor * world.sigma
    assert sizes[effect] == pytest.approx(left / world.sigma, rel=1e-6)
    assert np.isfinite(best).all()


@pytest.mark.parametrize("level", list(LEVELS))
def test_every_level_makes_cases(level):
    for seed in range(3):
        case = make_case(seed, level)
        assert case.truth["level"] == level
        assert len(case.truth["effects"]) == {"L0": 0, "LP": 0, "L4": 2}.get(level, 1)


LOOPS = {
    "capstan_hysteresis": [
        {"log_ratio": 0.2, "law": law, "pulleys": 5, "far_share": 0.2, "presliding_um": 1.0, "stribeck": 0.1}
        for law in ("front", "dahl", "maxwell", "lugre")
    ],
    "coulomb_friction": [{"moment_n_mm": 0.005, "spread": 0.2}],
    "distributed_notch_friction": [{"friction": 0.4, "spread": 0.2}],
    "tube_hysteresis": [{"knee_strain": 0.001, "lower_plateau": 0.5, "compliance": 2.0}],
}


def loop(effects, steps, seed=0, rate=1.0):
    corners = np.array([1.3, 2.3, 1.8, 2.6, 1.3]) * MM
    drive = np.interp(np.linspace(0, 4, 4 * steps + 1), np.arange(5), corners)
    time = np.linspace(0, 40 / rate, drive.size)
    trace = simulate(S4, 20 * MM, drive, time, effects, np.random.default_rng(seed), largest=30.0)
    bend = trace.theta.sum(axis=1) * trace.weight
    return drive, trace.tension, bend


@pytest.mark.parametrize(("name", "parameters"), [(name, p) for name, options in LOOPS.items() for p in options])
def test_friction_dissipates_and_waits_on_reversal(name, parameters):
    drive, tension, bend = loop({name: parameters}, 60)
    work = np.sum((tension[1:] + tension[:-1]) / 2 * np.diff(drive))
    assert work > 1e-6
    release = np.interp(1.9 * MM, drive[180:][::-1], bend[180:][::-1])
    load = np.interp(1.9 * MM, drive[:60], bend[:60])
    assert release > load
    # Loops do not depend on the rate.
    assert np.allclose(loop({name: parameters}, 60, rate=10.0)[2], bend, atol=1e-12)


REFINED = [(name, p) for name, options in LOOPS.items() for p in options] + [
    ("tendon_creep", {"stretch_ratio": 0.2, "time_constant_s": 4.0}),
    ("tendon_permanent_set", {"threshold_n": 0.2, "power": 1.5, "scale_n": 1.0, "slack_um_per_n": 100.0}),
]


@pytest.mark.parametrize(("name", "parameters"), REFINED)
def test_finer_steps_change_little_and_less(name, parameters):
    finest = loop({name: parameters}, 160)[2][::160]
    coarse, fine = (np.abs(loop({name: parameters}, steps)[2][::steps] - finest).max() for steps in (20, 40))
    assert coarse < 2e-3 * finest.max()
    assert fine <= 0.7 * coarse + 1e-6 * finest.max()


def test_the_camera_fits_a_free_circle():
    from scipy.optimize import least_squares

    notches, length = 60, 30 * MM
    along = (np.arange(notches) + 0.5) / notches
    for profile in (1 + 0 * along, 1.3 - 0.6 * along, 0.8 + 0.6 * along**2):
        theta = 0.6 / notches * profile[None, :]
        angle = np.concatenate([[0.0], np.cumsum(theta[0])])
        x = np.concatenate([[0.0], np.cumsum(np.cos(angle[:-1] + theta[0] / 2))]) * length / notches
        y = np.concatenate([[0.0], np.cumsum(np.sin(angle[:-1] + theta[0] / 2))]) * length / notches
        fit = least_squares(
            lambda p, x=x, y=y: np.hypot(x - p[0], y - p[1]) / abs(p[2]) - 1, [0.0, 0.05, 0.05], x_scale=0.01
        )
        seen = circle_curvature(theta, 1.0, np.array([length]))[0]
        assert seen == pytest.approx(1 / abs(fit.x[2]), rel=0.01)


def test_hold_out_runs_are_whole_histories():
    played = play_protocol(*world_parts(7))
    assert isinstance(played, Played)
    assert np.all(np.diff(played.rows.run) >= 0)


def world_parts(seed):
    world, *_ = draw_world(seed, "L1")
    return world.actual, world.protocol, world.effects, world.curvature, world.streams


def test_the_narrowest_window_holds_its_share():
    along = np.linspace(0, 10, 101)
    power = np.where((along > 3.95) & (along < 6.05), 1.0, 0.001)
    low, high = narrowest(along, power)
    assert 3.9 <= low <= 4.3
    assert 5.7 <= high <= 6.1
    assert power[(along >= low) & (along <= high)].sum() >= 0.9 * power.sum()


@pytest.mark.parametrize("effect", ["backlash", "sensor_lag", "precurvature"])
def test_a_hidden_effect_would_show_in_its_further_recording(effect):
    case = make_case(3, "L2", effect)
    assert case.truth["effects"][0]["id"] == effect
    assert set(case.laboratory) == {"release", "holds", "lengths", "rates", "slack", "tension"}
    assert all(text.count("\n") > 100 for text in case.laboratory.values())
