"""Steel tubes with one long notch, the kind of case of P's Fig. 6, by P's own method and as 3-D solids, frozen beside this file.

P's dimensions are not to be had: these are those of examples/solid/long_notch.py and examples/long_notch/tubes.toml.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.beam.projected import solve_beam_projected
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

DATA = Path(__file__).parent / "data" / "solid" / "long_notch.csv"
EXAMPLE = Path(__file__).parents[2] / "examples" / "long_notch" / "tubes.toml"
DEPTHS_MM = (0.314, 0.350, 0.376, 0.400)


def steel(depth_mm):
    one = np.ones(1)
    return NotchedTube("steel", 0.25e-3, 0.2e-3, depth_mm * 1e-3 * one, 0.11 * one, 2e-3 * one, 200e9, 8000.0)


def solid_tip(depth_mm):
    """Return the tip of the solid, m, the mean of notch up and down."""
    with DATA.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if float(row["depth_mm"]) == depth_mm]
    assert [row["notch"] for row in rows] == ["up", "down"]
    return np.mean([(float(row["x_mm"]), float(row["y_mm"])) for row in rows], axis=0) * 1e-3


@pytest.mark.parametrize("depth_mm", DEPTHS_MM)
def test_the_papers_method_in_twenty_steps_is_the_beam_and_the_solid(depth_mm):
    found, exact = solve_beam_projected(steel(depth_mm), 9.81), solve_beam(steel(depth_mm), 9.81)
    assert np.hypot(found.x[-1] - exact.x[-1], found.y[-1] - exact.y[-1]) < 0.02e-3
    x, y = solid_tip(depth_mm)
    off = np.hypot(found.x[-1] - x, found.y[-1] - y) / abs(y)
    print(
        f"depth {depth_mm:g} mm: sag {-1e3 * y:.3f} mm as a solid, {-1e3 * found.y[-1]:.3f} by the paper's method, {off:.2%}"
    )
    assert 0.002 < off < 0.01  # what is left: bending spreads from strip to ring, and the clamp holds a soft end


def test_the_example_has_the_same_tubes():
    for one, depth_mm in zip(build(load_config(EXAMPLE)).outer, DEPTHS_MM, strict=True):
        pieces, same = one.segments, steel(depth_mm).segments
        for name in ("length", "rigidity", "weight"):
            assert getattr(pieces, name) == pytest.approx(getattr(same, name), rel=1e-12)
