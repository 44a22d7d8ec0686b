"""Paths: the curve that a file says, whatever its units, and one sentence for what is wrong with it."""

import numpy as np
import pytest

from coast_cli.errors import BadInput
from coast_cli.recordings.planar_path import path_of_curvature, read_path


@pytest.fixture
def written(tmp_path):
    def write(text):
        file = tmp_path / "path.csv"
        file.write_text(text, encoding="utf-8")
        return str(file)

    return write


def test_a_constant_curvature_is_a_circle():
    path = path_of_curvature(np.array([0.0, 0.05]), np.array([25.0, 25.0]))
    s = path.arc_length
    np.testing.assert_allclose(path.x, np.sin(25.0 * s) / 25.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(path.y, (1.0 - np.cos(25.0 * s)) / 25.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(path.angle, 25.0 * s, rtol=0, atol=1e-12)


def test_a_curvature_that_grows_evenly_is_a_clothoid():
    from scipy.special import fresnel

    path = path_of_curvature(np.array([0.0, 0.06]), np.array([0.0, 40.0]))
    size = np.sqrt(np.pi * 0.06 / 40.0)
    y, x = fresnel(path.arc_length / size)
    np.testing.assert_allclose(path.x, size * x, rtol=0, atol=1e-14)
    np.testing.assert_allclose(path.y, size * y, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "arc_length_mm,curvature_per_m\n0,0\n20,0\n40,35\n",
        "s_mm,kappa_per_mm\n0,0\n20,0\n40,0.035\n",
        "kappa_per_m;s_m\n0;0\n0;0,02\n35;0,04\n",
        "S_UM\tKappa_per_mm\r\n0\t0\r\n20000\t0\r\n40000\t0.035\r\n",
    ],
)
def test_units_and_names_are_those_of_the_header(written, text):
    path = read_path(written(text))
    np.testing.assert_allclose(path.rows, [0.0, 0.02, 0.04], rtol=1e-12)
    np.testing.assert_allclose(path.curvature_at(path.rows), [0.0, 0.0, 35.0], rtol=1e-12, atol=1e-12)
    assert path.notes == ()


def test_points_are_a_spline_moved_to_start_along_x(written):
    angle = 0.3 + np.linspace(0.0, 2.0, 41)
    lines = [f"{12.0 + 25.0 * np.sin(a):.12f},{-7.0 - 25.0 * np.cos(a):.12f}" for a in angle]
    path = read_path(written("x_mm,y_mm\n" + "\n".join(lines) + "\n"))
    assert path.length == pytest.approx(0.05, rel=1e-6)
    np.testing.assert_allclose(path.curvature_at(path.rows[2:-2]), 40.0, rtol=2e-3)
    circle = path_of_curvature(np.array([0.0, 0.05]), np.array([40.0, 40.0]))
    for seen, exact in zip(path.place_at(path.rows), circle.place_at(path.rows), strict=True):
        np.testing.assert_allclose(seen, exact, rtol=0, atol=2e-6)
    assert "cubic spline through 41 points" in path.notes[0]


def test_the_spline_converges_with_more_than_the_third_power_of_the_spacing(written):
    errors = []
    for count in (6, 11, 21):
        angle = np.linspace(0.0, 2.0, count)
        lines = "\n".join(f"{25.0 * np.sin(a):.15g},{25.0 * (1.0 - np.cos(a)):.15g}" for a in angle)
        errors.append(abs(read_path(written(f"x_mm,y_mm\n{lines}\n")).length - 0.05))
    assert errors[0] / errors[1] > 8.0
    assert errors[1] / errors[2] > 8.0


def test_a_path_counts_from_its_first_row_and_says_so(written):
    path = read_path(written("s_mm,kappa_per_m\n5,10\n25,10\n"))
    assert path.rows.tolist() == [0.0, pytest.approx(0.02)]
    assert "starts at 5 mm" in path.notes[0]


def test_columns_that_are_not_used_are_named(written):
    path = read_path(written("s_mm,kappa_per_m,radius\n0,10,1\n25,10,1\n"))
    assert "'radius' is not used" in path.notes[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("s_mm,kapa_per_mm\n0,0\n1,0\n", ":1: a column is missing; found 's_mm, kapa_per_mm'"),
        ("s_mm,kapa_per_mm\n0,0\n1,0\n", "Did you mean kappa_per_mm"),
        ("arclength_mm,curvature_per_m\n0,0\n1,0\n", "Did you mean arc_length_mm"),
        ("s_mm,kappa\n0,0\n1,0\n", ":1:2: kappa: curvature without a unit; allowed: kappa_per_m kappa_per_mm."),
        ("s_inch,kappa_per_m\n0,0\n1,0\n", ":1:1: s_inch: arc_length with a unit that is not known; allowed: s_m s_mm"),
        ("x_mm,y_ft\n0,0\n1,0\n", ":1:2: y_ft: y with a unit that is not known"),
        ("a,b\n0,0\n1,0\n", "no path; found 'a, b'; allowed: arc_length_mm and curvature_per_m"),
        ("s_mm,arc_length_mm,kappa_per_m\n0,0,1\n", "arc_length stands in two columns"),
        ("s_mm,kappa_per_m\n0,0\n2,0\n1,0\n", ":4:1: s_mm: the arc length does not grow; found '1 mm after 2 mm'"),
        ("s_mm,kappa_per_m\n0,0\n0,9\n", ":3:1: s_mm: the arc length does not grow"),
        ("s_mm,kappa_per_m\n0,0\n1,nan\n", ":3:2: kappa_per_m: not a number; found 'nan'"),
        ("s_mm,kappa_per_m\n0,0\n1,\n", ":3:2: kappa_per_m: an empty cell"),
        ("s_mm,kappa_per_m\n0,0\n1,1e9\n", ":3:2: kappa_per_m: the curvature is out of range"),
        ("s_m,kappa_per_m\n0,0\n900,1\n", "the path is too long; found '900 m'"),
        ("s_mm,kappa_per_m\n0,0\n", "a path of 1 rows"),
        ("s_mm,kappa_per_m\n", "a header and no rows"),
        ("", "the file is empty"),
        ("x_mm,y_mm\n0,0\n1,0\n1,0\n2,0\n", ":4: two points coincide"),
        ("x_mm,y_mm\n0,0\n1,0\n2,0\n", "a path of 3 points; allowed: at least four"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence_with_its_place(written, text, said):
    with pytest.raises(BadInput) as refused:
        read_path(written(text))
    assert said in str(refused.value)
    assert "path.csv" in str(refused.value)


def test_a_file_that_is_not_there_is_said():
    with pytest.raises(BadInput, match=r"absent\.csv: cannot be read"):
        read_path("absent.csv")


def in_space(angle, lift=0.0, tilt=0.0):
    """Return a CSV of an arc of 80 degrees over 40 mm in a plane rolled by an angle (rad), its last points lifted (mm)."""
    along = np.linspace(0.0, 40.0, 41)
    kappa = np.radians(80.0) / 40.0
    x, across = np.sin(kappa * along) / kappa, (1.0 - np.cos(kappa * along)) / kappa
    y, z = across * np.cos(angle), across * np.sin(angle) + lift * (along > 30.0)
    x, y = x * np.cos(tilt) - y * np.sin(tilt), x * np.sin(tilt) + y * np.cos(tilt)
    rows = "\n".join(f"{a:.6f},{b:.6f},{c:.6f}" for a, b, c in zip(x, y, z, strict=True))
    return f"x_mm,y_mm,z_mm\n{rows}\n"


@pytest.mark.parametrize("degrees", [0.0, 30.0, -75.0])
@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_points_of_any_plane_are_the_path_in_it(written, degrees, tilt):
    path = read_path(written(in_space(np.radians(degrees), tilt=tilt)))
    assert np.degrees(path.roll) == pytest.approx(degrees, abs=0.05)
    assert path.length == pytest.approx(0.04, abs=1e-6)
    np.testing.assert_allclose(path.curvature_at(np.array([0.005, 0.02, 0.035])), np.radians(80.0) / 0.04, rtol=2e-3)
    assert "of one plane" in path.notes[0]


def test_a_bend_to_the_right_in_a_plane_stays_one(written):
    path = read_path(written(in_space(np.radians(180.0 - 20.0))))
    assert np.degrees(path.roll) == pytest.approx(-20.0, abs=0.05)
    assert path.curvature_at(np.array([0.02]))[0] == pytest.approx(-np.radians(80.0) / 0.04, rel=2e-3)


def test_a_path_that_leaves_its_plane_is_refused_where_it_does(written):
    with pytest.raises(BadInput, match=r"^[^ ]*:\d+.*z_mm.* leaves the plane of its start.*within 0.1 mm"):
        read_path(written(in_space(0.3, lift=2.0)))


def test_a_path_of_curvature_has_no_z(written):
    with pytest.raises(BadInput, match="a path of curvature has no z"):
        read_path(written("s_mm,kappa_per_m,z_mm\n0,10,0\n25,10,1\n"))
