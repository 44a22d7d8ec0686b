"""What recordings can decide, and that everything that says so says the same."""

import numpy as np
import pytest

from coast_cli.recordings.evidence import branch_rates, drive_speed, evidence_of
from coast_cli.recordings.model import JointRun, Recording, Recordings
from coast_cli.recordings.summary import can_decide
from coast_cli.spec.load import REFERENCE, load_config


@pytest.fixture
def config():
    return load_config(REFERENCE)


def run(drive, time=None, *, length=0.04, tension=None, name="a", middle="MT1", load=None):
    drive = np.asarray(drive, dtype=float)
    count = len(drive)
    return JointRun(
        name,
        "f.csv",
        np.arange(2, count + 2),
        None if time is None else np.asarray(time, dtype=float),
        None,
        middle,
        np.full(count, length),
        drive,
        tension,
        8e3 * drive[:, None],
        "curvature",
        load=load,
    )


UP = np.linspace(0.0, 4e-3, 60)


def test_two_lengths_close_together_and_four_released_samples():
    released = np.concatenate((UP, UP[-2:-6:-1]))
    runs = [run(released, length=0.0388), run(released, length=0.04, name="b")]
    held = evidence_of(runs)
    assert held.has_release
    assert held.released == 2
    assert not held.has_lengths
    said = " ".join(can_decide(Recordings(joint=Recording("joint", tuple(runs)))))
    assert "release is recorded in 2 of 2 runs" in said
    assert "one bending length" in said


def test_the_diagnosis_asks_the_same_of_its_runs(config):
    from coast_cli.diagnosis.joint.build import build_joint_problem

    for released in (1, 2, 3, 4, 20):
        for ratio in (1.0, 0.97, 0.94, 0.5):
            drive = np.concatenate((UP, UP[-2 : -2 - released : -1]))
            clock = np.arange(len(drive)) * 0.1
            runs = [
                run(drive, clock, length=0.04),
                run(drive, clock, length=0.04 * ratio, name="b"),
            ]
            problem = build_joint_problem(config, runs)
            held = evidence_of(runs)
            assert problem.holds["release"] == held.has_release
            assert problem.holds["rates"] == held.has_rates
            assert problem.holds["time"] == held.has_clock
            assert ("notch_friction" in [one.name for one in problem.base]) == held.has_lengths


def test_a_plan_of_the_same_runs_says_the_same(config):
    from coast_cli.diagnosis.joint.planning import plan

    for ratio, released in ((0.97, 4), (0.5, 4), (0.97, 0)):
        drive = np.concatenate((UP, UP[-2 : -2 - released : -1]))
        clock = np.arange(len(drive)) * 0.1
        runs = tuple(run(drive, clock, length=0.04 * factor, name=name) for factor, name in ((1.0, "a"), (ratio, "b")))
        held, planned = evidence_of(runs), plan(config, runs)
        assert ("notch_friction" in " ".join(planned.notes)) == held.has_lengths == (ratio == 0.5)
        backlash = next(row for row in planned.rows if row["effect"] == "backlash")
        assert (backlash["size"] is not None) == held.has_release == (released == 4)


@pytest.mark.parametrize(("speed", "differs"), [(1.0, False), (1.4, False), (1.6, True), (10.0, True)])
def test_rates(speed, differs):
    runs = [run(UP, np.arange(60.0)), run(UP, np.arange(60.0) / speed, name="b")]
    held = evidence_of(runs)
    assert held.has_rates == differs
    assert held.rate_ratio == pytest.approx(speed)


def test_a_hold_is_another_rate_and_needs_a_clock():
    held = np.concatenate((UP, np.full(20, UP[-1])))
    assert evidence_of([run(held, np.arange(80.0))]).has_rates
    assert not evidence_of([run(held)]).has_rates
    assert evidence_of([run(held)]).holds


def test_no_rate_of_nothing():
    drive = np.full(50, 1e-3)
    assert branch_rates(run(drive, np.arange(50.0))) == []
    noisy = drive + 1e-9 * np.random.default_rng(0).normal(size=50)
    assert branch_rates(run(noisy, np.arange(50.0))) == []
    assert branch_rates(run(UP, np.zeros(60))) == []
    moved, still = run(UP, np.arange(60.0)), run(drive[:1].repeat(60) + 1e-8 * UP, np.arange(60.0), name="b")
    assert evidence_of([moved, still]).rate_ratio == pytest.approx(1.0)


def test_the_speed_of_a_drive_is_none_in_holds_and_of_clocks_that_stand():
    held = np.concatenate((UP, np.full(30, UP[-1]), UP[::-1]))
    clock = np.arange(len(held)) * 0.1
    speed = drive_speed(run(held, clock))
    assert speed[5:55] == pytest.approx(np.full(50, 4e-3 / 5.9), rel=1e-6)
    assert not speed[65:85].any()
    stands = np.floor(np.arange(60) / 3.0)
    assert drive_speed(run(UP, stands)).max() < 2.0 * 3.0 * 4e-3 / 59
    assert not drive_speed(run(UP)).any()
    assert not drive_speed(run(UP, np.zeros(60))).any()
    assert not drive_speed(run(np.full(60, 1e-3) + 1e-12 * UP, np.arange(60.0))).max() > 1e-12


def test_devices_without_tubes_have_no_length_and_may_say_a_load():
    bare = [run(UP, np.arange(60.0), length=np.nan, middle="")]
    held = evidence_of(bare)
    assert held.lengths is None
    assert not held.has_lengths
    said = " ".join(can_decide(Recordings(joint=Recording("joint", tuple(bare)))))
    assert "no load is recorded" in said
    assert "bending length" not in said
    assert evidence_of([run(UP, load=np.full(60, 2.0))]).loads == 1


def test_no_runs_hold_nothing():
    held = evidence_of([])
    assert (held.runs, held.has_release, held.has_lengths, held.has_witness) == (0, False, False, False)
