"""Beams against whole notched tubes solved as 3-D solids (examples/solid/tubes.py), frozen beside this file.

The mean of a tube's two flips, notches up and down, cancels the offset of the neutral axis, which a beam does not have.
"""

import csv
import re
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.end_effect import end_length
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

FOLDER = Path(__file__).parent / "data" / "solid"
FILES = ("radial", "radial_held_out", "flat", "flat_held_out")
TUBES = [
    (name, tube)
    for name in FILES
    for tube in re.findall(r"^(\w+)_up,", (FOLDER / f"{name}.csv").read_text(), re.MULTILINE)
]
TUBES = list(dict.fromkeys(TUBES))


def shapes(name):
    """Points of every run, m, from the clamp."""
    points = defaultdict(list)
    with (FOLDER / f"{name}.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            points[row["run"]].append((float(row["x_mm"]), float(row["y_mm"])))
    return {run: 1e-3 * np.array(rows) for run, rows in points.items()}


@pytest.fixture(scope="module")
def design():
    return build(load_config(FOLDER / "tubes.toml"))


def beam(design, tube, scale, section):
    """Middles of the rings of the beam, (count, 2), with `scale` times the table's end effect."""
    chosen = replace(design.tube(tube), section=section)
    ro, ri = chosen.outer_radius, chosen.inner_radius
    extra, notes = end_length(ro, ri, chosen.depth, chosen.cut, chosen.uncut, section)
    assert notes == ()
    # the clamp keeps its face plane, as the middle of a ring twice as long would
    behind, _ = end_length(ro, ri, chosen.depth[0], chosen.cut[0], 2.0 * chosen.uncut[0], section)
    extra[0] = (extra[0] + behind) / 2.0
    solution = solve_beam(replace(chosen, end_length=scale * extra), design.gravity)
    assert solution.verdict.converged
    points = np.column_stack([solution.x, solution.y])
    return (points[:-1:2] + points[1::2]) / 2


def section_of(tube):
    return "chord" if tube.startswith("F") else "sector"


def solid(name, tube):
    both = shapes(name)
    return ((both[f"{tube}_up"] + both[f"{tube}_down"]) / 2)[1:]


@pytest.mark.parametrize(("name", "tube"), TUBES)
def test_the_table_predicts_the_shape(design, name, tube):
    truth = solid(name, tube)
    deflection = -truth[-1, 1]
    with_effect = np.linalg.norm(beam(design, tube, 1.0, section_of(tube)) - truth, axis=1).max()
    without = np.linalg.norm(beam(design, tube, 0.0, section_of(tube)) - truth, axis=1).max()
    assert with_effect < 0.011 * deflection
    assert without > 15 * with_effect


@pytest.mark.parametrize(("name", "tube"), TUBES)
def test_the_shape_alone_gives_the_extra_cut_length_of_the_cell(design, name, tube):
    from scipy.optimize import brentq

    truth = solid(name, tube)
    scale = brentq(lambda s: beam(design, tube, s, section_of(tube))[-1, 1] - truth[-1, 1], 0.0, 2.0, xtol=1e-4)
    assert scale == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("tube", [tube for _, tube in TUBES if tube.startswith("F")])
def test_the_sector_cannot_stand_for_a_flat_cut(design, tube):
    name = next(n for n, t in TUBES if t == tube)
    truth = solid(name, tube)
    assert beam(design, tube, 1.0, "sector")[-1, 1] > 0.9 * truth[-1, 1]


@pytest.mark.parametrize(("name", "tube"), TUBES)
def test_the_centreline_lengthens_by_the_neutral_axis_offset_times_the_turn(design, name, tube):
    model = design.tube(tube)
    offset = float(replace(model, section=section_of(tube)).notch.neutral_axis[0])
    straight = model.length - model.cut[0] - model.uncut[0] / 2
    for notch, sign in (("up", 1.0), ("down", -1.0)):
        steps = np.diff(shapes(name)[f"{tube}_{notch}"], axis=0)
        turn = abs(np.arctan2(steps[-1, 1], steps[-1, 0]))
        lengthened = np.hypot(*steps.T).sum() - straight
        assert lengthened == pytest.approx(sign * offset * turn, rel=0.08)
