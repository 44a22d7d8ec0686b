"""Pictures of the README and the guide: made by the command that the page names, small, and with the numbers of today.

Pictures of matplotlib are compared by their curves, each in the box of all of them, so that another version's margins and
letters do not matter; a drawing that is our own by all its numbers.
"""

import re

import numpy as np
import pytest

from coast_cli.cli.guide import PAGES
from tests.conftest import ROOT

TEXTS = {path: path.read_text(encoding="utf-8") for path in (ROOT / "README.md", *PAGES.glob("*.md"))}
COMMAND = re.compile(r"`coast ([^`]*)coast_cli/guide/(\w+)\.svg`")
COMMANDS = {name: words for text in TEXTS.values() for words, name in COMMAND.findall(text)}
PICTURES = sorted(path.stem for path in PAGES.glob("*.svg"))
LARGEST = 40_000  # bytes
CURVE = re.compile(r'<path d="(M [^"]*)"[^>]*style="fill: none; stroke: #(?!ebebeb|000000)\w{6}')
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
OFF = 0.01  # of the box of all curves


def curves(text):
    """Return the curves of a picture in the box of all of them, each as many points along it."""
    raw = [np.array(NUMBER.findall(path), dtype=float).reshape(-1, 2) for path in CURVE.findall(text)]
    raw = [points for points in raw if np.ptp(points[:, 1]) > 0.0]  # which a line of the legend has not
    every = np.concatenate(raw)
    low, high = every.min(axis=0), every.max(axis=0)
    return [dense((points - low) / (high - low)) for points in raw]


def dense(points, count=400):
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    at = np.linspace(0.0, along[-1], count)
    return np.stack([np.interp(at, along, axis) for axis in points.T], axis=1)


def apart(one, other):
    """Return how far the points of one curve are from the other, at most, and the other way round."""
    distance = np.hypot(*np.moveaxis(one[:, None] - other[None], -1, 0))
    return max(distance.min(axis=0).max(), distance.min(axis=1).max())


def test_every_picture_is_named_by_a_command_and_shown():
    assert sorted(COMMANDS) == PICTURES
    shown = {name for text in TEXTS.values() for name in re.findall(r"!\[[^\]]+\]\([\w/]*?(\w+)\.svg\)", text)}
    assert sorted(shown) == PICTURES


@pytest.mark.parametrize("name", PICTURES)
def test_it_is_what_its_command_draws_today(coast, tmp_path, monkeypatch, name):
    kept = (PAGES / f"{name}.svg").read_text(encoding="utf-8")
    assert len(kept.encode()) <= LARGEST
    monkeypatch.chdir(ROOT)
    made = tmp_path / "made.svg"
    assert coast(*COMMANDS[name].split(), made).code == 0
    drawn = made.read_text(encoding="utf-8")
    if "matplotlib" not in kept:
        old, new = (np.array(NUMBER.findall(text), dtype=float) for text in (kept, drawn))
        np.testing.assert_allclose(new, old, rtol=1e-3, atol=0.02)
        return
    before, after = curves(kept), curves(drawn)
    assert len(before) == len(after) >= 2
    assert max(apart(*pair) for pair in zip(before, after, strict=True)) <= OFF


def test_another_curve_would_be_seen():
    kept = (PAGES / "strokes.svg").read_text(encoding="utf-8")
    found = curves(kept)
    bent = found[0] * [1.0, 1.0 + 3 * OFF]
    assert apart(found[0], bent) > OFF
