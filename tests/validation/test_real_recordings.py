"""Recordings that others made, judged on runs that no fit saw: notched wrists and a tendon in a sheath.

They lie outside the project, in ``shared/recordings`` beside it, and are never copied into it. Figures in the comments
are what was measured when the test was written; asserted is what the contract asks for, or less where it is not reached.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from coast_cli.diagnosis.compare import compare
from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.holdout import hold_out
from coast_cli.diagnosis.model_file import model_text
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config, load_config_text

RECORDINGS = Path(__file__).parents[2].parent / "shared" / "recordings"
WRIST, SHEATH = RECORDINGS / "notched_wrist", RECORDINGS / "tendon_sheath"
BENDS = ("000", "090", "180")
SPLITS = {
    "A": (("A1",), ("A2",), ("A3",)),
    "C": (("C4", "C5"), ("C1", "C2"), ("C3",), ("C2", "C4"), ("C1", "C5")),
}

pytestmark = pytest.mark.skipif(not RECORDINGS.is_dir(), reason="not here")


@cache
def wrist(name):
    config = load_config(WRIST / "tubes.toml")
    return config, read_recordings([WRIST / f"wrist_{name}.csv"], config)


@cache
def sheath(bend):
    config = load_config(SHEATH / "tubes.toml")
    return config, read_recordings([SHEATH / f"sheath_{bend}.csv"], config)


@cache
def diagnosed_wrist(name, held_out):
    config, recordings = wrist(name)
    return diagnose_joint(config, recordings.joint.runs, named_hold_out=held_out)


@cache
def diagnosed_sheath(bend):
    config, recordings = sheath(bend)
    return diagnose_joint(config, recordings.joint.runs)


def samples(name, runs):
    return sum(int(np.isfinite(run.response).sum()) for run in wrist(name)[1].joint.runs if run.name in runs)


def pooled(parts):
    """Return the RMS of (RMS, number of samples) pairs."""
    squares, counts = zip(*((error**2 * count, count) for error, count in parts), strict=True)
    return np.sqrt(sum(squares) / sum(counts))


def own_lines(name, held_out=()):
    """Return the error (degrees) of a straight line through zero for every notch, held out; with no run, of its own fit."""
    runs = wrist(name)[1].joint.runs
    train = [run for run in runs if run.name not in held_out]
    held_out = held_out or tuple(run.name for run in runs)
    tension = np.concatenate([run.tension for run in train])
    bend = np.concatenate([run.response for run in train])
    slope = (tension @ bend) / (tension @ tension)
    error = np.concatenate([np.outer(run.tension, slope) - run.response for run in runs if run.name in held_out])
    return np.degrees(np.sqrt(np.mean(error**2)))


def straight_line(bend):
    """Return the error (degrees) after the first cycle of one gain, fitted before: the base model without dead band."""
    run = sheath(bend)[1].joint.runs[0]
    held = hold_out([run]).rows[0]
    stroke, seen = run.stroke, run.response[:, 0]
    gain = (stroke[~held] @ seen[~held]) / (stroke[~held] @ stroke[~held])
    return np.degrees(np.sqrt(np.mean((gain * stroke[held] - seen[held]) ** 2)))


SPLITS_FLAT = [(name, held) for name, splits in SPLITS.items() for held in splits]


def test_wrist_straight_lines_are_four_degrees_off():
    # One line a notch, on runs held out: A 2.2 to 2.5, C 4.5 to 4.9, all splits together 4.00; its authors print 3.97.
    assert pooled([(own_lines(*split), samples(*split)) for split in SPLITS_FLAT]) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(("name", "held_out"), SPLITS_FLAT)
def test_wrist_one_modulus_for_all_notches_is_no_better_than_lines(name, held_out):
    # The base model refitted: A 3.2 to 3.5, C 7.0 to 7.6.
    assert diagnosed_wrist(name, held_out).comparison.refitted.held_out > own_lines(name, held_out)


@pytest.mark.parametrize(("name", "held_out"), SPLITS_FLAT)
def test_wrist_every_split_is_predicted_far_better_than_by_the_line(name, held_out):
    comparison = diagnosed_wrist(name, held_out).comparison
    assert comparison.held_out_runs == held_out
    # Measured: A1 0.82, A2 1.30, A3 0.95; C4 C5 1.24, C1 C2 1.59, C3 0.97, C2 C4 1.02, C1 C5 1.30; together 1.19.
    assert comparison.with_effects.held_out < 0.45 * comparison.refitted.held_out
    assert comparison.with_effects.held_out < 1.75
    assert comparison.tip_mm_with_effects < comparison.tip_mm_refitted


def test_wrist_held_out_error_reaches_that_of_its_authors_model():
    parts = [
        (diagnosed_wrist(name, held).comparison.with_effects.held_out, samples(name, held))
        for name, held in (("A", ("A3",)), ("C", ("C4", "C5")))
    ]
    assert pooled(parts) < 1.15  # 1.11 was measured; its authors' corrected model errs by 1.15


def test_wrist_a_is_named():
    answer = diagnosed_wrist("A", ("A3",))
    # Five effects leave 2.4 noise widths of 9: told as closest and kept in the model, but not given as names.
    named = [effect.id for effect in answer.effects] or list(answer.attempts)
    assert answer.verdict in ("physics", "ambiguous", "unexplained")
    assert {"distributed_notch_friction", "tube_superelasticity", "notch_closure"} <= set(named)
    assert {"precurvature", "camera_offset"} & set(named)
    assert answer.model_effects


@pytest.mark.parametrize("held_out", SPLITS["C"])
def test_wrist_c_closes_and_yields(held_out):
    answer = diagnosed_wrist("C", held_out)
    named = {effect.id for effect in answer.effects} or set(answer.attempts)
    assert {"tube_superelasticity", "notch_closure"} <= named


def test_wrist_a_model_halves_the_line_on_wrist_c():
    config, recordings = wrist("A")
    model = load_config_text(model_text(config, diagnosed_wrist("A", ()), recordings), "model.toml")
    modulus = f"[joint]\nyoungs_modulus_gpa = {modulus_of_a()}"
    text = (WRIST / "tubes.toml").read_text(encoding="utf-8")
    line = load_config_text(text.replace("[joint]\nyoungs_modulus_gpa = 40.0", modulus), "line.toml")
    # Measured: 5.97 by the line fitted on A, 4.67 by lines fitted on C itself, 2.56 by the model fitted on A. It was 2.28
    # before a knee beyond what nitinol is known for had its price.
    assert error_on_c(line) > 4.0
    assert error_on_c(model) < 0.5 * error_on_c(line)
    assert error_on_c(model) < 0.56 * own_lines("C")


def error_on_c(config):
    rows = {row["run"]: row for row in compare(config, wrist("C")[1]).rows()}
    return rows["all"]["rmse_notch_deg"]


def modulus_of_a():
    config, recordings = wrist("A")
    problem = build_joint_problem(config, recordings.joint.runs)
    return problem.values(fit(problem).coordinates)["youngs_modulus_gpa"]


@pytest.mark.parametrize("bend", BENDS)
def test_sheath_hysteresis_is_named(bend):
    answer = diagnosed_sheath(bend)
    assert answer.verdict in ("physics", "ambiguous")
    assert answer.effects[0].id in ("backlash", "capstan_hysteresis", "coulomb_friction")


@pytest.mark.parametrize("bend", BENDS)
def test_sheath_after_the_first_cycle_is_predicted_80_percent_better_than_by_a_line(bend):
    comparison = diagnosed_sheath(bend).comparison
    assert "first full cycle" in comparison.rule
    # Measured: 0.89, 0.90, 0.93.
    assert 1.0 - comparison.with_effects.held_out / straight_line(bend) > 0.8


@pytest.mark.parametrize(("bend", "share"), [("000", 0.8), ("090", 0.7), ("180", 0.4)])
def test_sheath_is_better_too_than_a_line_with_a_dead_band(bend, share):
    # Measured: 0.86, 0.79, 0.57. The dead band alone already predicts most of the short rise that follows at 180.
    comparison = diagnosed_sheath(bend).comparison
    assert 1.0 - comparison.with_effects.held_out / comparison.refitted.held_out > share


@pytest.mark.parametrize(("bend", "branch"), [("000", "release"), ("090", "release"), ("180", "load")])
def test_sheath_mismatch_is_on_the_branch_that_the_dead_band_does_not_take(bend, branch):
    # At 180 the refitted dead band takes up the play of the release, so that loading is missed.
    where = diagnosed_sheath(bend).where
    assert ("direction", branch) in [(region.axis, region.value) for region in where]


def test_sheath_play_grows_with_the_bend_of_the_sheath():
    widths = [diagnosed_sheath(bend).effects[0].parameters["width_mm"].value for bend in BENDS]
    assert widths == sorted(widths)
    assert all(width > 1.0 for width in widths)
