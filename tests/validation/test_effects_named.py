"""Effects are named in recordings that another forward model made, in three noise colours; clean ones raise no alarm.

A few seeds of the table that ``python -m tests.validation.named`` prints, with floors under what it shows.
"""

from collections import Counter

import numpy as np
import pytest

from coast_cli.effects.catalogue import effects_of
from coast_cli.mechanics.joint import curvature_from_stroke
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config
from tests.independent_joint import Left, Truth, noise, simulate, stroke_for, sweep
from tests.validation.named import COLOURS, DRAWS, FAMILIES, SHOWN, clean, diagnosed, make, outcome, wilson

SEEDS = 2
OF_THE_RIG = {
    "bending_length_label",
    "camera_saturation",
    "frozen_frames",
    "load_cell_offset",
    "load_cell_scale",
    "lost_steps",
    "notch_closure",
    "periodic_disturbance",
    "run_differs",
    "transmission_compliance",
    "tube_hysteresis",
    "viscous_friction",
}


def test_the_second_model_agrees_with_the_first_where_nothing_is_left_out():
    truth = Truth()
    top = stroke_for(35.0, 0.03, truth)
    clock, stroke = sweep(top, 0.2e-3, top / 40)
    seen, tension, largest = simulate(truth, "OT4", "MT1", 0.03, clock, stroke)
    exact = curvature_from_stroke(build_joint(load_config(REFERENCE), "OT4", "MT1"), stroke, 0.03)
    assert seen == pytest.approx(exact.curvature, abs=2e-3)
    assert tension == pytest.approx(exact.tension, abs=1e-4)
    assert largest == pytest.approx(exact.tension.max(), abs=1e-4)


@pytest.mark.parametrize("colour", COLOURS)
def test_noise_has_the_level_that_was_asked(colour):
    levels = [noise(np.random.default_rng(seed), 300, 0.2, colour).std() for seed in range(40)]
    assert np.mean(levels) == pytest.approx(0.2, rel=0.1)


def test_every_joint_effect_is_drawn_and_in_one_family():
    # What a bench does wrong, and what was added since, is drawn by the concealed rig; so are faces that touch, which the
    # reference pair's do at some 900 per m only.
    assert set(DRAWS) | OF_THE_RIG == set(effects_of("joint"))
    assert sorted(SHOWN) == sorted(effect for family in FAMILIES.values() for effect in family)


def test_left_out_parts_change_the_recording():
    clock, stroke = sweep(3.5e-3, 0.2e-3, 0.1e-3)
    plain, _, _ = simulate(Truth(), "OT4", "MT1", 0.03, clock, stroke)
    for effect, draw in DRAWS.items():
        left = draw(np.random.default_rng(1), 30.0, 1.4)
        seen, tension, _ = simulate(Truth(left), "OT4", "MT1", 0.03, clock, stroke)
        assert np.all(np.isfinite(seen))
        assert np.all(tension >= 0.0)
        assert (left == Left()) == (effect == "distributed_notch_friction")
        if left != Left() and effect != "bending_length_offset":
            assert np.abs(seen - plain).max() > 0.05


@pytest.mark.parametrize("family", FAMILIES)
def test_effects_are_named_first(family):
    told = {}
    for place, effect in enumerate(FAMILIES[family]):
        for seed in range(place, place + SEEDS):
            case = make(effect, seed)
            told[effect, seed] = outcome(case, diagnosed(case))
    counts = Counter(told.values())
    # Names are withheld where the drawn form leaves more noise widths than the fitted one may: they are told as closest.
    assert counts["first"] >= 0.5 * len(told), told
    assert counts["first"] + counts["closest"] >= 0.6 * len(told), told
    assert counts["first"] + counts["group"] + counts["closest"] >= 0.8 * len(told), told
    assert counts["wrong"] <= 0.1 * len(told), told


@pytest.mark.parametrize("colour", COLOURS)
def test_clean_recordings_raise_no_alarm(colour):
    verdicts = [diagnosed(clean(seed, colour)).verdict for seed in range(7)]
    assert set(verdicts) <= {"agrees", "parameters"}


def test_what_is_in_no_catalogue_is_seldom_given_a_name():
    cases = (make("ripple along the stroke", seed, level="L6") for seed in range(4))
    told = [outcome(case, diagnosed(case)) for case in cases]
    assert sum(result == "unexplained" for result in told) >= 3, told


def test_wilson_intervals_are_those_of_the_textbook():
    # Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3: 81/263, 0/20 and 29/29.
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=1e-4)
    assert wilson(29, 29) == pytest.approx((0.8830, 1.0), abs=1e-4)
