"""The summary: what is in a recording, and what it can and cannot decide."""

import numpy as np
import pytest

from coast_cli.recordings.model import JointRun, Recording, Recordings, ShapeRun
from coast_cli.recordings.summary import can_decide, summary_rows

UP = np.linspace(0.0, 4e-3, 60)
DOWN = np.linspace(4e-3, 0.0, 60)[1:]


def joint(drive, name="a", *, length=0.03, rate=1e-4, clock=True, tension=False, driven_by_tension=False):
    rng = np.random.default_rng(0)
    count = len(drive)
    travelled = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(drive)))))
    return JointRun(
        name,
        "f.csv",
        np.arange(2, count + 2),
        travelled / rate if clock else None,
        "OT4",
        "MT1",
        np.full(count, length),
        None if driven_by_tension else drive,
        300.0 * drive if tension or driven_by_tension else None,
        (8e3 * drive + 0.1 * rng.normal(size=count))[:, None],
        "curvature",
    )


def of(*runs):
    return Recordings(joint=Recording("joint", runs))


def said(*runs):
    return " ".join(can_decide(of(*runs)))


def test_a_row_says_what_is_in_the_run():
    (row,) = summary_rows(of(joint(np.concatenate((UP, DOWN)))))
    assert (row["run"], row["pair"], row["n"], row["dropped"], row["cycles"]) == ("a", "OT4/MT1", 119, 0, 1)
    assert (row["load"], row["release"], row["hold"]) == (60, 59, 0)
    assert (row["drive"], row["drive_from"], row["drive_to"]) == ("stroke_mm", 0.0, pytest.approx(4.0))
    assert row["bending_length_to_mm"] == pytest.approx(30.0)
    assert row["response"] == "curvature_per_m"
    assert row["duration_s"] == pytest.approx(80.0)
    assert row["noise"] == pytest.approx(0.1, rel=0.5)


@pytest.mark.parametrize(
    ("runs", "words"),
    [
        ([joint(UP)], "loading only"),
        ([joint(np.concatenate((UP, DOWN)))], "release is recorded in 1 of 1 runs"),
        ([joint(np.concatenate((UP, DOWN)))], "loads a second time"),
        ([joint(UP)], "never holds"),
        ([joint(UP, clock=False)], "no clock: nothing about rate or time"),
        ([joint(UP), joint(UP, "b", clock=False)], "no clock in 1 of 2 runs"),
        ([joint(UP), joint(UP, "b", rate=4e-4)], "rates differ by 4.0 times"),
        ([joint(UP)], "one rate only"),
        ([joint(UP), joint(UP, "b")], "one bending length"),
        ([joint(UP), joint(UP, "b", length=0.02)], "bending lengths from 20 to 30 mm"),
        ([joint(UP)], "stroke without tension"),
        ([joint(UP, tension=True)], "stroke and tension"),
        ([joint(UP, driven_by_tension=True)], "driven by tension"),
        ([joint(UP)], "one run: held out are blocks"),
        ([joint(UP), joint(UP, "b"), joint(UP, "c", length=0.02)], "2 runs repeat"),
        ([joint(UP)], "noise of all runs together"),
    ],
)
def test_what_it_can_and_cannot_decide(runs, words):
    assert words in said(*runs)


def test_a_hold_allows_creep():
    assert "never holds" not in said(joint(np.concatenate((UP, np.full(40, 4e-3), DOWN))))


def shape(natural, name="s"):
    arc = np.linspace(0.0, 0.1, 40)
    return ShapeRun(name, "f.csv", np.arange(2, 42), "OT1", None, arc, -2.0 * arc**2, natural)


@pytest.mark.parametrize(
    ("runs", "words"),
    [([shape(None)], "one way up only"), ([shape("up"), shape("down", "t")], "both ways up")],
)
def test_shapes(runs, words):
    recordings = Recordings(shape=Recording("shape", tuple(runs)))
    assert words in " ".join(can_decide(recordings))
    rows = summary_rows(recordings)
    assert list(rows[0]) == list(summary_rows(of(joint(UP)))[0])
    assert rows[0]["response_to"] == pytest.approx(102.0, rel=0.01)
