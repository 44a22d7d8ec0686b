"""Beams of two finite-element codes, frozen as data; examples/frames has the scripts that made them.

OpenSees: corotational frame elements. CalculiX: quadratic beams, expanded to solids, so they stretch and shear a little.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from coast_cli.mechanics.beam import solve_beam
from coast_cli.mechanics.tube import NotchedTube

DATA = Path(__file__).parent / "data"


def rows(name: str) -> list[dict[str, float]]:
    with (DATA / name).open() as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def tip_error(row: dict[str, float]) -> float:
    """Distance of the code's tip from ours over the length."""
    one = np.ones(188)
    tube = NotchedTube(
        "reference",
        0.2e-3,
        0.165e-3,
        0.35e-3 * one,
        0.3e-3 * one,
        0.3e-3 * one,
        45e9,
        6450.0,
        row["natural_curvature_per_m"],
    )
    solution = solve_beam(tube, 9.81)
    return float(np.hypot(solution.x[-1] - row["tip_x_m"], solution.y[-1] - row["tip_y_m"])) / tube.length


@pytest.mark.parametrize("curvature", [5.0, -5.0, -15.0])
def test_opensees_converges_to_our_answer(curvature):
    chosen = [row for row in rows("opensees_beams.csv") if row["natural_curvature_per_m"] == curvature]
    tips = np.array([[row["tip_x_m"], row["tip_y_m"]] for row in chosen])
    assert [row["elements_per_piece"] for row in chosen] == [1.0, 2.0, 4.0]
    # One element a piece is good to five digits. Finer ones converge with the square of their length, to our tip but
    # for the 1e-7 by which the code's axial stiffness lets the beam stretch.
    assert tip_error(chosen[0]) < 3e-6
    steps = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    assert steps[0] / steps[1] == pytest.approx(4.0, rel=0.02)
    limit = tips[2] + (tips[2] - tips[1]) / 3.0
    assert tip_error(chosen[2] | {"tip_x_m": limit[0], "tip_y_m": limit[1]}) < 1e-7


@pytest.mark.parametrize("row", rows("calculix_beams.csv"), ids=lambda row: f"k0 = {row['natural_curvature_per_m']}")
def test_calculix_agrees(row):
    assert tip_error(row) < 5e-5
