"""P, "Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023): what its text states.

P's Tables I and II are not to be had; the tubes are the reference input, which respects every bound that the text
implies. The figures of pairs and strokes come from an independent solution.
"""

from pathlib import Path

import numpy as np
import pytest

from coast_cli.mechanics.joint import curvature_from_stroke, stroke
from coast_cli.mechanics.pairs import pair_table
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

# pair: total pre-curvature (rad), ratio mean, ratio series, total EI mean, series (N m^2)
PAIRS = {
    ("OT1", "MT1"): (0.0871, 3.506, 4.723, 5.47e-5, 8.47e-6),
    ("OT4", "MT1"): (0.2626, 3.391, 1.130, 5.33e-5, 3.17e-6),
    ("OT4", "MT3"): (0.4464, 3.462, 3.225, 5.31e-5, 2.19e-6),
}
# curvature (1/m), bending length (mm): stroke (mm) of OT4/MT1
STROKES = {(20.0, 20.0): 2.6001, (40.0, 20.0): 4.0002, (20.0, 40.0): 2.9955, (40.0, 40.0): 4.7913}


@pytest.fixture(scope="module")
def design():
    return build(load_config(Path(__file__).parents[2] / "configs" / "tubes.toml"))


@pytest.mark.parametrize("names", PAIRS, ids="/".join)
def test_figures_of_pairs(design, names):
    table = pair_table([design.tube(names[0])], [design.tube(names[1])], design.gravity)
    total, ratio_mean, ratio_series, total_mean, total_series = PAIRS[names]
    assert round(table.total_precurvature.item(), 4) == total
    assert round(table.ratio_mean.item(), 3) == ratio_mean
    assert round(table.ratio_series.item(), 3) == ratio_series
    assert table.total_mean.item() == pytest.approx(total_mean, abs=0.5e-7)
    assert table.total_series.item() == pytest.approx(total_series, abs=0.5e-8)


def test_findings_of_the_paper(design):
    table = pair_table(design.outer, design.middle, design.gravity)
    # S1 has the lowest pre-curvature and the highest rigidity, S4 the lowest ratio; numbering is middle-major.
    assert np.argmin(table.total_precurvature) == 0
    assert np.argmax(table.total_series) == 0
    assert np.argmin(table.ratio_mean) == 3
    # The mean ratio hardly sees the notch, the series ratio does.
    assert (table.ratio_mean.min(), table.ratio_mean.max()) == pytest.approx((3.39, 3.58), abs=0.005)
    assert (table.ratio_series.min(), table.ratio_series.max()) == pytest.approx((1.13, 13.5), abs=0.05)


@pytest.mark.parametrize("point", STROKES)
def test_strokes(design, point):
    curvature, length = point[0], point[1] * 1e-3
    joint = design.joint("OT4/MT1")
    found = stroke(joint, curvature, length)
    assert float(found.stroke) * 1e3 == pytest.approx(STROKES[point], abs=0.5e-4)
    back = curvature_from_stroke(joint, found.stroke, length)
    assert float(back.curvature) == pytest.approx(curvature, abs=1e-9)
