"""``coast trace`` end to end on small frames: rows, flags, overlays, refusals; and the circle on exact points."""

import csv
import gc
import json
import tracemalloc

import numpy as np
import pytest

from coast_cli.recordings.read import read_recordings
from coast_cli.recordings.trace import trace_image
from coast_cli.recordings.trace_image import BadFrame
from coast_cli.recordings.trace_spline import fit_arc
from tests.rendered_tube import Scene, Tube

PIL = pytest.importorskip("PIL.Image", reason="not here: scikit-image")


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")

    def save(name, *tubes, seed=0):
        PIL.fromarray(Scene((240, 360), tubes, noise=2, seed=seed).image()).save(folder / name)

    save("a.png", Tube(12, 260, 1 / 400, (0, 180)), seed=1)
    save("b.png", Tube(12, 260, 1 / 300, (0, 180)), seed=2)
    save("empty.png")
    return folder


def test_a_shape_goes_out_and_comes_back(coast, frames, tmp_path):
    out = tmp_path / "shape.csv"
    ran = coast("trace", frames / "a.png", "--scale", 0.04, "--clamp", "0,180", "--tube", "OT4", "-o", out)
    assert (ran.code, ran.out) == (0, "")
    (run,) = read_recordings([out]).shape.runs
    assert run.name == "a"
    assert len(run.x) == 60
    assert run.x[0] == run.y[0] == 0
    assert run.y[-1] == pytest.approx(400 * 0.04e-3 * (1 - np.cos(260 / 400)), rel=0.02)


def test_a_joint_takes_its_drive_and_keeps_a_dropped_frame(coast, frames, tmp_path):
    drive = tmp_path / "drive.csv"
    drive.write_text("stroke_mm,bending_length_mm,middle\n1,10,MT1\n2,10,MT1\n3,10,MT1\n")
    out = tmp_path / "joint.csv"
    images = [frames / name for name in ("a.png", "empty.png", "b.png")]
    ran = coast("trace", *images, "--scale", 0.04, "--kind", "joint", "--drive", drive, "-o", out)
    assert ran.code == 0
    assert "no tube" in ran.err
    assert [row["flag"] for row in csv.DictReader(out.read_text().splitlines())] == ["", "no-tube", ""]
    (run,) = read_recordings([out]).joint.runs
    assert run.response[:, 0] == pytest.approx([62.5, np.nan, 83.333], rel=0.01, nan_ok=True)
    assert run.stroke == pytest.approx([1e-3, 2e-3, 3e-3])


def test_the_same_frame_gives_the_same_bytes_and_its_digest(coast, frames):
    words = ("trace", frames / "a.png", "--scale", 0.04, "-f", "json")
    first = coast(*words)
    assert first.out == coast(*words).out
    assert len(json.loads(first.out)["provenance"]["recordings"][0]["sha256"]) == 64


def test_overlays_are_pictures_of_the_frame(coast, frames, tmp_path):
    assert coast("trace", frames / "a.png", "--scale", 0.04, "--overlay", tmp_path / "a.png").code == 0
    with PIL.open(tmp_path / "a.png") as picture:
        red = (np.asarray(picture) == (0xE6, 0x19, 0x4B)).all(axis=2).sum()
        assert picture.width >= 1200
    assert red > 500
    folder = tmp_path / "all"
    words = ("--scale", 0.04, "--kind", "joint", "--overlay", folder)
    assert coast("trace", frames / "a.png", frames / "empty.png", *words).code == 0
    assert sorted(path.name for path in folder.iterdir()) == ["a.overlay.png", "empty.overlay.png"]


def test_a_frame_that_shows_no_tube_stops_a_shape_file(coast, frames, tmp_path):
    out = tmp_path / "shape.csv"
    ran = coast("trace", frames / "a.png", frames / "empty.png", "--scale", 0.04, "-o", out)
    assert ran.code == 3
    assert "empty.png: no tube is seen" in ran.err
    assert not out.exists()
    assert coast("trace", frames / "empty.png", "--scale", 0.04, "--kind", "joint").code == 3


@pytest.mark.parametrize(
    ("code", "text", "words"),
    [
        (3, "cannot be read as an image", ("text.png",)),
        (3, "no such image", ("missing.png",)),
        (3, "is a folder", (".",)),
        (3, "too small", ("tiny.png",)),
        (3, "too large", ("huge.png",)),
        (3, "several frames", ("film.gif",)),
        (3, "cannot be read", ("short.png",)),
        (3, "one row a frame", ("a.png", "--kind", "joint", "--drive", "drive.csv")),
        (2, "--scale", ("a.png", "--scale", "0")),
        (2, "--clamp", ("a.png", "--clamp", "3")),
        (2, "--kind", ("a.png", "--kind", "film")),
        (2, "--points", ("a.png", "--points", "2")),
        (2, "give a folder", ("a.png", "a.png", "--overlay", "one.png")),
    ],
)
def test_what_cannot_be_traced_is_refused_in_one_sentence(coast, frames, tmp_path, monkeypatch, code, text, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.png").write_bytes((frames / "a.png").read_bytes())
    (tmp_path / "short.png").write_bytes((frames / "a.png").read_bytes()[:3000])
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "drive.csv").write_text("stroke_mm\n1\n2\n")
    PIL.new("L", (8, 8)).save(tmp_path / "tiny.png")
    PIL.new("1", (20_000, 6_000)).save(tmp_path / "huge.png")
    grey = [PIL.new("L", (64, 64), level) for level in (0, 200)]
    grey[0].save(tmp_path / "film.gif", save_all=True, append_images=grey[1:])
    ran = coast("trace", "--scale", "0.04", *words)
    assert (ran.code, ran.out) == (code, "")
    assert text in ran.err
    assert "Traceback" not in ran.err
    assert "internal" not in ran.err


def test_a_missing_extra_is_named(coast, frames, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    ran = coast("trace", frames / "a.png", "--scale", 0.04)
    assert ran.code == 2
    assert "pip install 'coast-cli[vision]'" in ran.err


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "I;16", "P"])
def test_other_kinds_of_pixels_give_the_same_trace(frames, tmp_path, mode):
    from coast_cli.recordings.trace import trace_image

    with PIL.open(frames / "a.png") as picture:
        grey = np.asarray(picture)
        other = PIL.fromarray(grey.astype(np.uint16) * 257) if mode == "I;16" else picture.convert(mode)
    other.save(tmp_path / "other.png")
    ours = trace_image(tmp_path / "other.png", mm_per_px=0.04)
    assert ours.curvature_per_m == pytest.approx(62.5, rel=0.01)


@pytest.mark.parametrize("curvature", [0.0, 0.002, -0.004, 0.02])
def test_a_circle_through_exact_points_is_found(curvature):
    s = np.linspace(0, 250, 300)
    x = 40 + (np.sin(curvature * s) / curvature if curvature else s)
    y = 90 - ((1 - np.cos(curvature * s)) / curvature if curvature else 0 * s)
    arc = fit_arc(x, y)
    assert arc.curvature == pytest.approx(curvature, abs=1e-9)
    foot = arc.foot(x[100], y[100] + 1e-3)
    assert foot[:2] == pytest.approx((x[100], y[100]), abs=2e-3)
    assert np.cos(foot[2] - curvature * s[100]) == pytest.approx(1)


def test_the_curvature_error_covers_noise():
    rng = np.random.default_rng(0)
    s = np.linspace(0, 400, 400)
    scores = []
    for _ in range(200):
        off = rng.normal(0, 0.3, s.size)
        angle = s / 500
        arc = fit_arc((500 + off) * np.sin(angle), (500 + off) * np.cos(angle))
        scores.append((arc.curvature - 1 / 500) / arc.std)
    assert 0.8 < np.std(scores) < 1.3


def test_a_refused_photograph_does_not_stay_in_memory(tmp_path):
    from PIL import Image

    path = tmp_path / "noise.png"
    Image.fromarray(np.random.default_rng(3).integers(0, 255, (400, 500), dtype=np.uint8)).save(path)
    kept = []
    gc.disable()
    tracemalloc.start()
    try:
        for _ in range(2):  # the first loads modules
            before = tracemalloc.get_traced_memory()[0]
            with pytest.raises(BadFrame):
                trace_image(path, mm_per_px=0.05)
            kept.append(tracemalloc.get_traced_memory()[0] - before)
    finally:
        tracemalloc.stop()
        gc.enable()
    assert kept[1] < 400 * 500  # less than a byte a pixel
