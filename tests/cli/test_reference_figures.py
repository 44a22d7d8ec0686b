"""The reference input gives the figures of the physics notes (an independent solution) to every printed digit."""

import json
from decimal import Decimal

import pytest

# pair: total pre-curvature (rad), ratio mean / series, EI mean / series (N m^2), as printed
PAIRS = {
    "S1": (".0871", "3.506", "4.723", "5.47e-5", "8.47e-6"),
    "S4": (".2626", "3.391", "1.130", "5.33e-5", "3.17e-6"),
    "S12": (".4464", "3.462", "3.225", "5.31e-5", "2.19e-6"),
}
COLUMNS = (
    "total_precurvature_rad",
    "rigidity_ratio_mean",
    "rigidity_ratio_series",
    "total_rigidity_mean_n_m2",
    "total_rigidity_series_n_m2",
)
STROKES = {(20, 20): 2.6001, (40, 20): 4.0002, (20, 40): 2.9955, (40, 40): 4.7913}
# natural curvature (1/m): tip angle (rad), tip x, y (m); ro .2, ri .165, d .35 mm, 188 pitches, E 45 GPa
BEAMS = {
    5.0: (-0.66270797828223, 0.087982123270705, -0.066789038374872),
    -5.0: (-1.40985211612583, 0.060216743875269, -0.086052930077382),
    -15.0: (-2.12682804094436, 0.030065655053199, -0.090728647097830),
}


def rows(ran):
    assert ran.code == 0, ran.err
    return json.loads(ran.out)["rows"]


def rounded(value, like):
    """Return value with as many significant digits as the printed figure has."""
    digits = len(Decimal(like).as_tuple().digits)
    return Decimal(f"{value:.{digits - 1}e}")


@pytest.fixture
def ranked(coast, reference):
    return rows(coast("rank-pairs", reference, "--format", "json"))


@pytest.mark.parametrize("sample", PAIRS)
def test_the_printed_figures_of_a_pair(ranked, sample):
    row = next(row for row in ranked if row["sample"] == sample)
    for column, printed in zip(COLUMNS, PAIRS[sample], strict=True):
        assert rounded(row[column], printed) == Decimal(printed), column


def test_s4_ranks_first_and_s1_is_straightest_and_stiffest(ranked):
    assert len(ranked) == 12
    assert [ranked[0][key] for key in ("rank", "sample", "outer", "middle")] == [1, "S4", "OT4", "MT1"]
    assert min(ranked, key=lambda row: row["total_precurvature_rad"])["sample"] == "S1"
    assert max(ranked, key=lambda row: row["total_rigidity_series_n_m2"])["sample"] == "S1"
    assert min(ranked, key=lambda row: row["rigidity_ratio_mean"])["sample"] == "S4"


def test_the_ratios_of_all_pairs_lie_in_the_printed_ranges(ranked):
    means = [row["rigidity_ratio_mean"] for row in ranked]
    series = [row["rigidity_ratio_series"] for row in ranked]
    assert (round(min(means), 2), round(max(means), 2)) == (3.39, 3.58)
    assert (round(min(series), 2), round(max(series), 1)) == (1.13, 13.5)


def test_the_four_strokes(coast, reference):
    found = rows(coast("stroke", reference, "--kappa", "20,40", "--x2", "20,40", "-f", "json"))
    assert len(found) == 4
    for row in found:
        assert row["stroke_mm"] == pytest.approx(STROKES[row["curvature_per_m"], row["bending_length_mm"]], abs=1e-4)


def test_the_inverse_returns_the_curvature(coast, reference):
    for curvature in (0.0, 1e-3, 20.0, 40.0, 150.0):
        there = rows(coast("stroke", reference, "--kappa", curvature, "--x2", "35", "-f", "json"))[0]
        back = rows(coast("stroke", reference, "--stroke", repr(there["stroke_mm"]), "--x2", "35", "-f", "json"))[0]
        assert back["curvature_per_m"] == pytest.approx(curvature, abs=1e-9)


@pytest.mark.parametrize("curvature", BEAMS)
def test_the_thirteen_digit_beams(coast, edited, curvature):
    tube = f"""name = "OT1"
outer_diameter_mm = 0.4
inner_diameter_mm = 0.33
depth_mm = 0.35
natural_curvature_per_m = {curvature}
"""
    old = 'name = "OT1"\ndepth_mm = 0.314                     # paper\nnatural_curvature_per_m = 0.8        # assumed\n'
    config = edited((old, tube), ("outer_diameter_mm = 0.36 ", "outer_diameter_mm = 0.32 "))
    tip = rows(coast("beam", config, "--tube", "OT1", "-f", "json"))[-1]
    angle, x, y = BEAMS[curvature]
    length = 188 * 0.6e-3
    assert tip["arc_length_mm"] == pytest.approx(1e3 * length)
    assert abs(tip["x_mm"] / 1e3 - x) < 1e-10 * length
    assert abs(tip["y_mm"] / 1e3 - y) < 1e-10 * length
    assert tip["angle_deg"] == pytest.approx(angle * 180 / 3.141592653589793, abs=1e-9)
