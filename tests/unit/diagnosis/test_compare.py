"""Errors run by run: against the model itself, against known differences, in every unit, and of shapes."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from coast_cli.diagnosis.compare import compare
from coast_cli.errors import BadInput
from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.joint import curvature_from_stroke, tip
from coast_cli.recordings.model import JointRun, Recording, Recordings, ShapeRun
from coast_cli.spec.build import build, build_joint
from coast_cli.spec.load import REFERENCE, load_config

LENGTH = 0.03
STROKE = np.linspace(1.5e-3, 4e-3, 40)


@pytest.fixture(scope="module")
def config():
    return load_config(REFERENCE)


@pytest.fixture(scope="module")
def exact(config):
    """Curvature of the model itself, by the closed form that the forward model does not use."""
    return curvature_from_stroke(build_joint(config, "OT4", "MT1"), STROKE, LENGTH).curvature


def joint(response, name="a", kind="curvature", **changes):
    response = np.atleast_2d(response).T if np.ndim(response) == 1 else response
    run = JointRun(
        name,
        "f.csv",
        np.arange(len(STROKE)),
        None,
        "OT4",
        "MT1",
        np.full(len(STROKE), LENGTH),
        STROKE,
        None,
        response,
        kind,
    )
    return replace(run, **changes)


def rows(config, *runs, shapes=()):
    recordings = Recordings(
        joint=Recording("joint", runs) if runs else None, shape=Recording("shape", shapes) if shapes else None
    )
    return {row["run"]: row for row in compare(config, recordings).rows()}


def test_the_model_against_itself_is_exact(config, exact):
    row = rows(config, joint(exact))["a"]
    assert row["rmse_curvature_per_m"] < 1e-5
    assert row["rmse_tip_mm"] < 1e-5
    assert row["n"] == 40


def test_a_known_offset_is_the_error_in_curvature_and_at_the_tip(config, exact):
    row = rows(config, joint(exact + 1.5))["a"]
    assert row["rmse_curvature_per_m"] == pytest.approx(1.5, rel=1e-4)
    (x, y), (other_x, other_y) = tip(exact, LENGTH), tip(exact + 1.5, LENGTH)
    assert row["rmse_tip_mm"] == pytest.approx(
        1e3 * np.sqrt(np.mean((x - other_x) ** 2 + (y - other_y) ** 2)), rel=1e-4
    )
    assert row["rmse_bend_deg"] is None
    assert row["noise_unit"] == "curvature_per_m"


def test_a_bend_is_told_in_degrees_and_as_curvature(config, exact):
    row = rows(config, joint((exact + 2.0) * LENGTH, kind="bend"))["a"]
    assert row["rmse_bend_deg"] == pytest.approx(np.degrees(2.0 * LENGTH), rel=1e-4)
    assert row["rmse_curvature_per_m"] == pytest.approx(2.0, rel=1e-4)
    assert row["noise_unit"] == "bend_deg"


def test_notches_are_told_one_by_one_and_as_the_segment(config, exact):
    notches = 50
    angle = np.repeat((exact * 0.6e-3)[:, None], notches, axis=1) + 0.01
    row = rows(config, joint(angle, kind="notch"))["a"]
    assert row["rmse_notch_deg"] == pytest.approx(np.degrees(0.01), rel=1e-3)
    assert row["rmse_curvature_per_m"] == pytest.approx(notches * 0.01 / LENGTH, rel=1e-3)
    assert row["n"] == 40 * notches


def test_the_pooled_row_weighs_by_samples(config, exact):
    short = joint(exact[:10] + 3.0, "b", stroke=STROKE[:10], bending_length=np.full(10, LENGTH), line=np.arange(10))
    found = rows(config, joint(exact + 1.0), short)
    assert list(found) == ["a", "b", "mean", "all"]
    assert found["mean"]["rmse_curvature_per_m"] == pytest.approx(2.0, rel=1e-4)
    assert found["all"]["n"] == 50
    assert found["all"]["rmse_curvature_per_m"] == pytest.approx(np.sqrt((40 * 1.0 + 10 * 9.0) / 50), rel=1e-4)


def test_kinds_are_pooled_where_they_can_be(config, exact):
    found = rows(config, joint(exact + 1.0), joint((exact + 1.0) * LENGTH, "b", kind="bend"))
    assert found["all"]["rmse_curvature_per_m"] == pytest.approx(1.0, rel=1e-4)
    assert found["all"]["noise"] is None
    assert found["all"]["noise_unit"] is None


def test_dropped_frames_do_not_count(config, exact):
    response = exact + 1.0
    response[::4] = np.nan
    row = rows(config, joint(response))["a"]
    assert row["n"] == 30
    assert row["rmse_curvature_per_m"] == pytest.approx(1.0, rel=1e-4)


def test_the_noise_is_that_of_the_recording_not_of_the_model(config, exact):
    noisy = exact * 1.3 + 0.2 * np.random.default_rng(0).normal(size=40)
    assert rows(config, joint(noisy))["a"]["noise"] == pytest.approx(0.2, rel=0.6)


def test_a_stroke_without_a_tendon_is_bad_input(config, exact):
    bare = config.model_copy(update={"tendon": None})
    with pytest.raises(BadInput, match="tendon"):
        rows(bare, joint(exact))


def sagging(config, name, natural=None, turn=1.0, shift=0.0):
    design = build(config)
    tube = design.tube(name)
    solution = solve_beam(replace(tube, natural_curvature=turn * tube.natural_curvature), design.gravity)
    at = np.linspace(0, solution.s.size - 1, 16).astype(int)
    outer = name if name.startswith("OT") else None
    return ShapeRun(
        name + (natural or ""),
        "f.csv",
        np.arange(16),
        outer,
        None if outer else name,
        solution.x[at],
        solution.y[at] + shift,
        natural,
    )


@pytest.mark.parametrize("name", ["OT3", "MT3"])
def test_shapes_at_equal_arc_length(config, name):
    row = rows(config, shapes=(sagging(config, name, shift=1e-3),))[name]
    assert row["rmse_shape_mm"] == pytest.approx(1.0, rel=0.05)
    assert row["rmse_tip_mm"] == pytest.approx(1.0, rel=0.1)
    assert row["rmse_curvature_per_m"] is None
    assert rows(config, shapes=(sagging(config, name),))[name]["rmse_shape_mm"] < 0.02


@pytest.mark.parametrize(("name", "usual", "other"), [("OT3", "up", "down"), ("MT3", "down", "up")])
def test_the_side_of_the_natural_curvature_counts(config, name, usual, other):
    assert rows(config, shapes=(sagging(config, name, usual),))[name + usual]["rmse_shape_mm"] < 0.02
    assert rows(config, shapes=(sagging(config, name, other, turn=-1.0),))[name + other]["rmse_shape_mm"] < 0.02
    assert rows(config, shapes=(sagging(config, name, other),))[name + other]["rmse_shape_mm"] > 1.0


def test_a_pair_bends_between_its_tubes(config):
    arc = np.linspace(0.0, 0.075, 30)
    run = ShapeRun("p", "f.csv", np.arange(30), "OT4", "MT1", arc, 0.0 * arc, None)
    (found,) = compare(config, Recordings(shape=Recording("shape", (run,)))).shape
    turn = np.arctan2(np.diff(found.y), np.diff(found.x))[-1]
    assert -0.45 < turn < -0.1  # rank-pairs gives -0.24 where each tube sags by itself; a photographed pair sags as one


def test_the_papers_headline_is_a_mean_over_runs():
    from coast_cli.diagnosis.compare import _mean

    paper = [1.104, 0.395, 1.024, 0.662, 0.422, 1.287]  # its Fig. 9 (b) and (c), mm
    found = _mean([{"rmse_tip_mm": value} for value in paper], {"run": "all", "n": 600, "rmse_tip_mm": 0.9})
    assert round(found["rmse_tip_mm"], 3) == 0.816


def test_a_long_run_is_compared_in_little_memory(config, monkeypatch):
    """120 bytes more a row, beside those of the run itself, keep ten million rows within 1.5 GB or near it."""
    monkeypatch.setattr("coast_cli.recordings.noise.LONGEST", 20_000)

    def peak(count):
        stroke = 2e-3 + 1.5e-3 * np.sin(np.arange(count) * 2.0 * np.pi / 2000)
        columns = np.full(count, LENGTH), stroke, None, (8e3 * stroke)[:, None]
        run = JointRun("r", "f.csv", np.arange(count), None, "OT4", "MT1", *columns, "curvature")
        tracemalloc.start()
        try:
            compare(config, Recordings(joint=Recording("joint", (run,)))).rows()
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    few, many = peak(100_000), peak(300_000)
    assert many - few < 120 * 200_000


def test_what_was_found_on_another_bench_does_not_move_the_errors_of_a_joint(config, exact):
    """A model saved from photographs: what belongs to their bench and camera stays with photographs."""
    of_photographs = {"camera_scale": {"scale": 1.3}, "tip_load": {"force_mn": 5.0}, "base_tilt": {"angle_deg": 3.0}}
    saved = {name: {**values, "recording": "shapes"} for name, values in of_photographs.items()}
    before = rows(config, joint(exact))["a"]
    assert rows(config.model_copy(update={"corrections": saved}), joint(exact))["a"] == before
    own = {"camera_scale": {"scale": 1.3, "recording": "joint"}}
    assert rows(config.model_copy(update={"corrections": own}), joint(exact))["a"] != before
