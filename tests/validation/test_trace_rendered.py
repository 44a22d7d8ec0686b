"""Traces against rendered photographs whose centreline and curvature are known.

Bounds of the issue: centreline within 0.3 px RMS, curvature within 1 %, over widths of 8 to 60 px, curvatures of 5 to 45
per metre (a tube of 0.5 mm), notches on either side or both, blur, gradient light, noise and specular lines.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from coast_cli.recordings.trace import trace_levels
from coast_cli.recordings.trace_image import BadFrame
from tests.rendered_tube import Scene, Tube, texture

pytest.importorskip("skimage", reason="not here: scikit-image")


def random_scene(seed):
    rng = np.random.default_rng(seed)
    width = float(np.exp(rng.uniform(np.log(8), np.log(60))))
    scale = 0.5 / width
    curvature = rng.uniform(5, 45) * scale * 1e-3
    length = min(rng.uniform(20, 60) / scale, 1100, 2.6 / curvature)
    pitch = rng.uniform(0.9, 1.5)
    tube = Tube(
        width,
        length,
        curvature * rng.choice([-1, 1]),
        (0, 0),
        rng.uniform(-0.4, 0.4),
        pitch=pitch,
        cut=pitch * rng.uniform(0.4, 0.6),
        depth=rng.uniform(0.5, 0.8),
        notch_side=int(rng.choice([-1, 1, -1, 1, 0])),
    )
    _, x, y, _, _ = tube.axis(1.0)
    margin = width + 25
    tube = replace(tube, start=(margin - x.min(), margin - y.min()))
    shape = (int(np.ptp(y) + 2 * margin), int(np.ptp(x) + 2 * margin))
    scene = Scene(
        shape,
        (tube,),
        gradient=tuple(rng.uniform(-0.5, 0.5, 2)),
        noise=rng.uniform(0, 6),
        blur=rng.uniform(0.4, 1.5),
        bright=bool(rng.random() < 0.2),
        streak=float(rng.choice([0, 0.3])),
        seed=seed,
    )
    return tube, scene, scale


def traced(scene, **options):
    return trace_levels(scene.image().astype(np.float32), mm_per_px=0.02, **options)


def off_axis(trace, tube):
    _, x, y, _, _ = tube.axis()
    px, py, std = trace.points_px(200)
    return cKDTree(np.stack([x, y], axis=1)).query(np.stack([px, py], axis=1))[0], std


@pytest.mark.parametrize("seed", range(16))
def test_random_tubes_are_traced_within_the_bounds(seed):
    tube, scene, scale = random_scene(seed)
    trace = trace_levels(scene.image().astype(np.float32), mm_per_px=scale)
    off, std = off_axis(trace, tube)
    assert np.sqrt(np.mean(off**2)) < 0.3
    assert trace.arc.curvature == pytest.approx(tube.curvature * (-1 if trace.mirrored else 1), rel=0.01)
    assert trace.tip - trace.clamp == pytest.approx(tube.length, abs=tube.pitch * tube.width)
    assert np.sqrt(np.mean(off**2)) < 6 * np.mean(std)
    assert trace.flag == ""


TUBE = Tube(20, 700, 1 / 600, (60, 500), 0.1)
SCENE = Scene((600, 900), (TUBE,), gradient=(0.3, 0.2), noise=3, blur=1)
HALF_WAY = tuple(np.array(TUBE.axis()[1:3])[:, 7000])
NEAR_TIP = tuple(np.array(TUBE.axis()[1:3])[:, -300])


@pytest.mark.parametrize(
    "tube",
    [
        replace(TUBE, curvature=0.0),
        replace(TUBE, depth=0.0),
        replace(TUBE, curvature=np.linspace(-1 / 400, 1 / 400, 50), start=(60, 300), angle=0.2),
        replace(TUBE, curvature=np.linspace(0, -1 / 200, 50), start=(60, 150), angle=0.0),
    ],
    ids=["straight", "uncut", "S", "sagging"],
)
def test_other_shapes_are_traced(tube):
    off, _ = off_axis(traced(replace(SCENE, tubes=(tube,))), tube)
    assert np.sqrt(np.mean(off**2)) < 0.1


def test_a_tube_bent_past_a_half_turn_is_traced():
    tube = Tube(14, 950, 1 / 180, (400, 560))
    trace = traced(replace(SCENE, tubes=(tube,)), clamp=(400, 560))
    assert np.sqrt(np.mean(off_axis(trace, tube)[0] ** 2)) < 0.1
    assert trace.arc.curvature == pytest.approx(1 / 180, rel=1e-3)


def test_a_tube_clamped_on_the_right_is_turned_round():
    tube = replace(TUBE, start=(840, 500), angle=np.pi - 0.1, curvature=-1 / 600)
    trace = traced(replace(SCENE, tubes=(tube,)), clamp=(840, 500))
    x, y, _ = trace.points_mm(20)
    assert trace.mirrored
    assert x[0] == y[0] == 0
    assert (np.diff(x) > 0).all()
    assert (np.diff(y) > 0).all()
    assert trace.curvature_per_m == pytest.approx(1e3 / (600 * 0.02), rel=0.01)


def test_the_clamp_cuts_off_what_lies_before_it():
    x, y = np.array(TUBE.axis()[1:3])[:, 4000]
    trace = traced(SCENE, clamp=(x, y))
    assert trace.tip - trace.clamp == pytest.approx(500, abs=3)


def test_a_fixture_dust_a_hair_and_uneven_ground_do_no_harm():
    tube = replace(TUBE, start=(100, 500))
    hair = Tube(3, 300, 1 / 300, (300, 500), 0.9, depth=0)
    levels = replace(SCENE, tubes=(tube, hair), blocks=((0, 430, 110, 570),)).image() + texture((600, 900), 1)
    rng = np.random.default_rng(3)
    rows, columns = np.mgrid[:600, :900]
    for _ in range(40):
        levels[(rows - rng.integers(600)) ** 2 + (columns - rng.integers(900)) ** 2 < rng.integers(2, 6) ** 2] = 40
    trace = trace_levels(np.clip(levels, 0, 255).astype(np.float32), mm_per_px=0.02, clamp=(111, 499))
    off, _ = off_axis(trace, tube)
    assert np.sqrt(np.mean(off**2)) < 0.1
    assert trace.tip - trace.clamp == pytest.approx(689, abs=4)


def test_glare_at_the_tip_is_flagged():
    assert traced(replace(SCENE, glare=(*NEAR_TIP, 30))).flag == "glare"


@pytest.mark.parametrize(
    ("flag", "scene", "clamp"),
    [
        ("no-tube", replace(SCENE, tubes=()), None),
        ("no-tube", replace(SCENE, tubes=(), blocks=((300, 200, 500, 400),)), None),
        ("two-tubes", replace(SCENE, tubes=(TUBE, replace(TUBE, start=(60, 250)))), None),
        ("two-tubes", replace(SCENE, tubes=(TUBE, Tube(20, 600, 0.0, (100, 150), -0.5))), None),
        ("two-tubes", replace(SCENE, glare=(*HALF_WAY, 40)), None),
        ("cut-off", replace(SCENE, tubes=(replace(TUBE, start=(350, 300)),)), None),
        ("cut-off", replace(SCENE, tubes=(Tube(20, 1000, 0.0, (-20, 400)),)), (0, 400)),
        ("off-clamp", SCENE, (500, 100)),
    ],
    ids=["empty", "block", "two", "crossing", "glare", "tip-outside", "both-borders", "clamp-elsewhere"],
)
def test_a_frame_without_one_whole_tube_is_refused(flag, scene, clamp):
    with pytest.raises(BadFrame) as raised:
        traced(scene, clamp=clamp)
    assert raised.value.flag == flag
    assert raised.value.exit_code == 3


@pytest.mark.parametrize("level", [0, 255])
def test_an_even_frame_shows_no_tube(level):
    with pytest.raises(BadFrame, match="no tube"):
        trace_levels(np.full((300, 300), level, np.float32), mm_per_px=0.02)
