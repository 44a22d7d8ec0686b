"""Notch patterns: the notches are the tube's, and a program that is not ours reads the drawing."""

import json

import ezdxf
import numpy as np
import pytest

from coast_cli.mechanics.section import notched_section
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config


def rows(ran):
    assert ran.code == 0, ran.err
    return json.loads(ran.out)["rows"]


def test_notches_are_where_the_tube_has_them(coast, reference):
    found = rows(coast("pattern", reference, "--tube", "OT1", "--kerf", "0.02", "-f", "json"))
    tube = build(load_config(reference)).tube("OT1")
    assert [row["notch"] for row in found] == list(range(1, tube.count + 1))
    for number, row in enumerate(found):
        assert row["start_mm"] == pytest.approx(0.6 * number + 0.3)
        assert row["end_mm"] == pytest.approx(0.6 * (number + 1))
        assert row["laser_end_mm"] - row["laser_start_mm"] == pytest.approx(0.28)
        assert row["laser_width_mm"] == pytest.approx(row["width_mm"] - 0.02)
    assert found[-1]["end_mm"] == pytest.approx(tube.length * 1e3)


def test_what_the_notch_leaves_of_the_skin_is_the_strip_of_the_model(coast, reference):
    row = rows(coast("pattern", reference, "--tube", "OT3", "-f", "json"))[0]
    tube = build(load_config(reference)).tube("OT3")
    area = notched_section(tube.outer_radius, tube.inner_radius, tube.depth, "sector").area[0]
    kept = np.radians(360.0 - row["angle_deg"])
    assert kept / 2.0 * (tube.outer_radius**2 - tube.inner_radius**2) == pytest.approx(area, rel=1e-12)
    assert row["width_mm"] == pytest.approx(np.radians(row["angle_deg"]) * 0.25)


def test_the_drawing_is_read_back_by_another_program(coast, reference, tmp_path):
    file = tmp_path / "tubes.dxf"
    ran = coast("pattern", reference, "--tube", "OT4", "--tube", "MT2", "--kerf", "0.02", "-o", file)
    assert (ran.code, ran.out) == (0, "")
    drawing = ezdxf.readfile(file)
    assert drawing.dxfversion == "AC1009"
    assert not drawing.audit().errors
    space = drawing.modelspace()
    cuts, outlines = ([one for one in space.query("POLYLINE") if one.dxf.layer == name] for name in ("CUT", "OUTLINE"))
    assert len(cuts) == 188 + 125
    assert all(one.is_closed for one in (*cuts, *outlines))
    assert [one.dxf.text for one in space.query("TEXT")] == ["OT4", "MT2"]
    found = rows(coast("pattern", reference, "--tube", "OT4", "--tube", "MT2", "--kerf", "0.02", "-f", "json"))
    middles = {"OT4": 0.0, "MT2": np.pi * 0.5 + 1.0}
    for row, cut in zip(found, cuts, strict=True):
        corners = np.array([tuple(point)[:2] for point in cut.points()])
        low, high = corners.min(axis=0), corners.max(axis=0)
        assert (low[0], high[0]) == pytest.approx((row["laser_start_mm"], row["laser_end_mm"]), abs=1e-6)
        assert high[1] - low[1] == pytest.approx(row["laser_width_mm"], abs=2e-6)
        assert (low[1] + high[1]) / 2.0 == pytest.approx(middles[row["tube"]], abs=2e-6)
    for tube, outline in zip(("OT4", "MT2"), outlines, strict=True):
        size = np.ptp([tuple(point)[:2] for point in outline.points()], axis=0)
        radius, length = {"OT4": (0.25, 112.8), "MT2": (0.18, 75.0)}[tube]
        assert size == pytest.approx((length, 2.0 * np.pi * radius), abs=2e-6)


@pytest.mark.parametrize("kerf", ["0.3", "0.5", "1e9"])
def test_a_kerf_wider_than_the_cut_is_refused(coast, reference, tmp_path, kerf):
    ran = coast("pattern", reference, "--tube", "OT4", "--kerf", kerf, "-o", tmp_path / "x.dxf")
    assert ran.code == 3
    assert "kerf: a kerf as wide as notch 1 of OT4 leaves no path inside it" in ran.err
    assert not list(tmp_path.iterdir())


def test_notches_of_many_depths_have_their_own_widths(coast, edited):
    depths = ", ".join(f"{0.3 + 0.0005 * k:.4f}" for k in range(188))
    config = edited(("depth_mm = 0.314 ", f"depth_mm = [{depths}] "))
    width = [row["width_mm"] for row in rows(coast("pattern", config, "--tube", "OT1", "-f", "json"))]
    assert np.all(np.diff(width) > 0.0)
