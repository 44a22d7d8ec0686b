"""Traces that end before the tip, begin after the clamp, have gaps and smeared noise: what is not seen is not counted."""

from __future__ import annotations

import numpy as np
import pytest

from coast_cli.diagnosis.compare import compare
from coast_cli.diagnosis.shapes import diagnose_shapes
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config_text
from tests.photographed_tube import LENGTH, Bench, config_text, shape


def _smeared(random: np.random.Generator, count: int, noise: float, width: int) -> np.ndarray:
    """White noise, or noise that neighbouring points share."""
    kernel = np.ones(width) / np.sqrt(width)
    unit = random.standard_normal((count, 2))
    return noise * np.stack([np.convolve(unit[:, axis], kernel, "same") for axis in (0, 1)], axis=1)


def _recorded(tmp_path, seed, *, whole=False, scale=1.0, ends=None):
    """Tubes of random depth and curvature both ways up, their traces cut at random unless they are whole."""
    random = np.random.default_rng([seed, 4711])
    tubes = {
        name: (round(random.uniform(0.26, 0.34), 3), round(random.uniform(1, 9), 1)) for name in "AB"[: 1 + seed % 2]
    }
    noise, width = float(np.exp(random.uniform(np.log(15e-6), np.log(60e-6)))), int(random.choice([1, 1, 3, 5]))
    lines = ["run,tube,natural,x_mm,y_mm"]
    for number, (tube, side) in enumerate((tube, side) for tube in tubes for side in ("up", "down")):
        depth, natural = tubes[tube]
        count = int(random.integers(70, 200))
        along = np.linspace(0.0, 1.0, count)
        points = np.stack(shape(Bench(depth=depth * 1e-3, natural=natural), up=side == "up", points=count), axis=1)
        end = 1.0 - (random.uniform(0.0, 0.12) if ends is None else ends)
        start, gap = random.choice([0.0, random.uniform(0.02, 0.2)]), random.uniform(0.3, 0.7)
        hidden = (along > end) | (along < start) | ((along > gap) & (along < gap + 0.1))
        seen = (scale * points + _smeared(random, count, noise, width))[~hidden | whole]
        lines += [f"s{number},{tube},{side},{1e3 * x:.5f},{1e3 * y:.5f}" for x, y in seen]
    path = tmp_path / "shapes.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    config = load_config_text(config_text(tubes), "tubes.toml")
    return config, read_recordings([path], config), noise


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_what_is_not_seen_is_not_counted(tmp_path, seed):
    config, recordings, noise = _recorded(tmp_path, seed)
    found = diagnose_shapes(config, recordings.shape.runs)
    assert found.verdict in ("agrees", "parameters")
    assert found.comparison.with_effects.held_out < 1.6e3 * noise * np.sqrt(2.0)
    assert any("before the tip" in note for note in found.notes)


def test_traces_that_all_end_two_millimetres_early_are_no_smaller_picture(tmp_path):
    config, recordings, noise = _recorded(tmp_path, 2, ends=2e-3 / LENGTH)
    assert diagnose_shapes(config, recordings.shape.runs).verdict in ("agrees", "parameters")
    assert compare(config, recordings).rows()[-1]["rmse_shape_mm"] < 1.6e3 * noise * np.sqrt(2.0)


@pytest.mark.parametrize("scale", [0.97, 1.03])
def test_a_smaller_or_larger_picture_of_whole_tubes_is_the_camera(tmp_path, scale):
    config, recordings, _ = _recorded(tmp_path, 3, whole=True, scale=scale)
    found = diagnose_shapes(config, recordings.shape.runs)
    assert [effect.id for effect in found.effects] == ["camera_scale"]
    assert found.effects[0].parameters["scale"].value == pytest.approx(scale, abs=0.004)
