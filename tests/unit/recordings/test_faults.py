"""What benches get wrong: frames that repeat, views that end, and what only looks like it."""

import numpy as np
import pytest

from coast_cli.recordings.faults import (
    clipped_rows,
    copied_rows,
    fault_notes,
    faults_of,
    frozen_rows,
    has_flat_end,
    quantum_of,
)
from coast_cli.recordings.model import JointRun
from coast_cli.recordings.noise import estimate_noise, recording_noise


def sweep(count=400):
    return np.concatenate((np.linspace(0.0, 5.0, count // 2), np.linspace(5.0, 0.0, count - count // 2)))


def frozen(rng, values, share):
    """Return values with bursts of 2 to 9 frames that repeat, and which rows repeat."""
    held, at = np.zeros(len(values), bool), 1
    values = values.copy()
    while at < len(values):
        length = int(rng.integers(1, 9)) if rng.random() < share / 5.0 else 0
        values[at : at + length] = values[at - 1]
        held[at : at + length] = True
        at += max(length, 1) + 1
    return values, held


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("level", [0.02, 0.22, 1.0])
def test_frozen_frames_are_found_and_the_noise_is_not_theirs(seed, level):
    rng = np.random.default_rng(seed)
    drive = sweep()
    values, held = frozen(rng, 8.0 * drive + level * rng.normal(size=400), rng.uniform(0.05, 0.35))
    found = frozen_rows(values, drive)
    assert (found == held).mean() > 0.99
    assert estimate_noise(values, drive).level == pytest.approx(level, rel=0.35)


def test_frozen_frames_of_a_rounded_camera_jump():
    rng = np.random.default_rng(1)
    drive = sweep()
    values, held = frozen(rng, np.round(8.0 * drive + 0.01 * rng.normal(size=400), 1), 0.3)
    found = frozen_rows(values, drive)
    assert not (found & ~held & ~np.append(False, np.diff(values) == 0)).any()
    assert found.sum() > 0.5 * held.sum()


@pytest.mark.parametrize("seed", range(4))
def test_bursts_of_a_coarse_camera_catch_up(seed):
    rng = np.random.default_rng(seed)
    drive, step, level = sweep(rng.integers(80, 300)), rng.uniform(0.1, 0.4), rng.uniform(0.05, 0.3)
    clean = np.round((8.0 * drive + level * rng.normal(size=len(drive))) / step) * step
    assert not frozen_rows(clean, drive).any()
    values = clean.copy()
    held = np.zeros(len(drive), bool)
    for start in rng.choice(len(drive) // 12 - 1, 5, replace=False) * 12 + 3:
        values[start + 1 : start + 8] = values[start]
        held[start + 1 : start + 8] = True
    found = frozen_rows(values, drive)
    assert found[held].mean() > 0.5
    assert not (found & ~np.append(False, np.diff(values) == 0)).any()


def test_what_rests_is_not_frozen():
    rng = np.random.default_rng(2)
    drive = sweep()
    state, played = 0.0, []
    for value in drive:
        state = min(max(state, value - 0.6), value)
        played.append(state)
    played = 8.0 * np.array(played)
    assert not frozen_rows(played, drive).any()
    assert not frozen_rows(np.round(played, 1), drive).any()
    assert not frozen_rows(np.round(played + 0.05 * rng.normal(size=400), 1), drive).any()
    held = np.concatenate((drive[:200], np.full(100, 5.0), drive[200:]))
    assert not frozen_rows(8.0 * held, held).any()
    assert not frozen_rows(8.0 * drive + rng.normal(size=400), drive).any()


def test_a_view_that_ends():
    rng = np.random.default_rng(3)
    drive = sweep()
    for noise in (0.0, 0.1, 1.0):
        values = np.minimum(8.0 * drive + noise * rng.normal(size=400), 30.0)
        found = clipped_rows(values, drive)
        assert found.sum() == (values == 30.0).sum()
    values = np.maximum(-8.0 * drive, -30.0)
    assert clipped_rows(values, drive).sum() == (values == -30.0).sum()


@pytest.mark.parametrize("seed", range(6))
def test_an_end_is_flat_be_it_sharp_or_soft(seed):
    rng = np.random.default_rng(seed)
    drive = sweep(rng.integers(60, 300))
    open_view = 8.0 * np.maximum(drive - rng.uniform(0.0, 1.0), 0.0)
    level, noise = rng.uniform(0.5, 0.85) * open_view.max(), rng.uniform(0.05, 0.8)
    soft = rng.uniform(0.002, 0.015) * level
    seen = level - soft * np.logaddexp(0.0, (level - open_view) / soft) + noise * rng.normal(size=len(drive))
    assert has_flat_end(seen, drive)
    assert not has_flat_end(open_view + noise * rng.normal(size=len(drive)), drive)
    assert not has_flat_end(np.zeros(len(drive)), drive)


def test_what_ends_by_itself_is_not_clipped():
    rng = np.random.default_rng(4)
    drive = sweep()
    state, played = 0.0, []
    for value in drive:
        state = min(max(state, value - 0.6), value)
        played.append(state)
    smooth = 2.5 * (1.0 - np.cos(np.pi * drive / 5.0))
    for values in (8.0 * drive, 8.0 * np.array(played), np.round(8.0 * smooth, 1), 8.0 * drive + rng.normal(size=400)):
        assert not clipped_rows(values, drive).any()
    held = np.concatenate((drive[:200], np.full(100, 5.0), drive[200:]))
    assert not clipped_rows(np.round(8.0 * held, 2), held).any()


def test_a_coarse_camera_at_the_top_and_a_slack_device_are_not_clipped():
    rng = np.random.default_rng(6)
    for count in (77, 150, 400):
        smooth = 2.5 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, count)))
        for step in (0.5, 1.0, 2.0):
            values = (
                np.round((8.0 * np.maximum(smooth - 1.0, 0.0) + 0.35 * step * rng.normal(size=count)) / step) * step
            )
            assert not clipped_rows(np.maximum(values, 0.0), smooth).any()
            assert not frozen_rows(np.maximum(values, 0.0), smooth).any()


def test_steps_of_rounding():
    rounded = np.round(np.random.default_rng(5).normal(size=300), 1)
    rounded[[20, 90]] += 3.01234
    assert quantum_of(rounded) == pytest.approx(0.1, rel=0.02)
    assert quantum_of(np.round(np.random.default_rng(5).normal(size=300), 2)) == pytest.approx(0.01)
    assert quantum_of(np.random.default_rng(5).normal(size=300)) == 0.0
    assert quantum_of(np.zeros(5)) == 0.0


def run_of(drive, response, time=None, *, stroke=True):
    response = np.asarray(response, dtype=float)
    rows = response[:, None] if response.ndim == 1 else response
    count = len(drive)
    return JointRun(
        "a",
        "f.csv",
        np.arange(2, count + 2),
        time,
        None,
        "MT1",
        np.full(count, 0.03),
        1e-3 * drive if stroke else None,
        None if stroke else drive,
        rows,
        "curvature" if rows.shape[1] == 1 else "notch",
    )


@pytest.mark.parametrize("clock", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_rows_that_stand_twice_do_not_change_the_noise(seed, clock):
    rng = np.random.default_rng(seed)
    steps = np.cumsum(rng.uniform(0.3, 1.7, 60))
    drive = np.concatenate([steps, steps[::-1]])
    time = np.cumsum(rng.uniform(0.05, 0.15, 120))
    level = rng.uniform(0.05, 0.5)
    response = 0.4 * drive + level * rng.normal(size=120)
    copies = np.sort(np.concatenate([np.arange(120), rng.choice(120, 50, replace=False)]))
    once = run_of(drive, response, time if clock else None)
    twice = run_of(drive[copies], response[copies], time[copies] if clock else None)
    assert copied_rows(twice).sum() == 50
    assert recording_noise([twice]).level == pytest.approx(recording_noise([once]).level, rel=1e-9)


def said(drive, response, time=None):
    return " ".join(fault_notes([run_of(drive, response, time)]))


def clean(rng, drive, level=0.2):
    return 8.0 * drive + level * rng.normal(size=len(drive))


CLOCK = 0.1 * np.arange(400)


def test_a_clean_run_has_no_faults():
    rng = np.random.default_rng(10)
    for _ in range(20):
        assert fault_notes([run_of(sweep(), clean(rng, sweep()), CLOCK)]) == ()


@pytest.mark.parametrize("seed", range(8))
def test_a_breathing_is_found_with_its_period(seed):
    rng = np.random.default_rng(seed)
    period = rng.uniform(0.6, 4.5)
    values = clean(rng, sweep()) + 1.0 * np.sin(2.0 * np.pi * CLOCK / period)
    swing = faults_of(run_of(sweep(), values, CLOCK)).swing
    assert swing is not None
    assert swing.period == pytest.approx(period, rel=0.03)
    assert swing.amplitude == pytest.approx(1.0, rel=0.25)
    assert f"{swing.period:.3g} s in run a" in said(sweep(), values, CLOCK)


def test_what_follows_the_drive_is_no_swing():
    rng = np.random.default_rng(11)
    drive = sweep()
    screw = clean(rng, drive) + 1.0 * np.sin(2.0 * np.pi * drive / 0.7)
    assert faults_of(run_of(drive, screw, CLOCK)).swing is None
    assert faults_of(run_of(drive, clean(rng, drive))).swing is None


def test_duplicates_missing_and_standing_clocks_are_said_with_their_share():
    rng = np.random.default_rng(12)
    twice = np.sort(np.concatenate((np.arange(400), rng.choice(400, 266, replace=False))))
    values = clean(rng, sweep())
    text = said(sweep()[twice], values[twice], CLOCK[twice])
    assert "rows are duplicates of the row before: 40 % in run a" in text
    assert "time stamps repeat: 40 % in run a" in text
    assert "frames repeat" not in text
    values[rng.choice(400, 40, replace=False)] = np.nan
    assert "responses are missing: 10 % in run a" in said(sweep(), values, CLOCK)
    stood = np.floor(CLOCK / 0.3) * 0.3
    assert "time stamps repeat: 66 % in run a" in said(sweep(), clean(rng, sweep()), stood)


def test_drives_that_stand_shake_or_are_not_followed():
    rng = np.random.default_rng(13)
    still = np.full(400, 3.0)
    assert "the drive never moves in run a" in said(still, rng.normal(size=400), CLOCK)
    noisy = sweep() + 0.05 * rng.normal(size=400)
    assert faults_of(run_of(noisy, clean(rng, sweep()))).drive_noise == pytest.approx(0.01, rel=0.3)
    assert "the drive is noisy: 0.81 % of its travel in run a" in said(noisy, clean(rng, sweep()), CLOCK)
    assert "does not follow the drive in run a" in said(sweep(), rng.normal(size=400), CLOCK)
    assert "are the two exchanged?" in said(clean(rng, sweep(), 0.3) / 8.0, 8.0 * sweep(), CLOCK)
    assert "exchanged" not in said(sweep(), clean(rng, sweep(), 0.3), CLOCK)


def test_many_runs_are_one_sentence():
    rng = np.random.default_rng(14)
    runs = [run_of(np.full(400, 3.0), rng.normal(size=400)) for _ in range(30)]
    notes = fault_notes(runs)
    assert len(notes) == 1
    assert "and 27 more" in notes[0]


def test_rows_that_hold_no_news_can_be_asked_for():
    rng = np.random.default_rng(15)
    values, held = frozen(rng, clean(rng, sweep()), 0.2)
    found = faults_of(run_of(sweep(), np.minimum(values, 30.0), CLOCK))
    assert (found.useless == (held | (values >= 30.0))).mean() > 0.98
    assert found.clipped.sum() == (values >= 30.0).sum()
