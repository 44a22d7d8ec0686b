"""Tables for controllers: the C header compiled and run against the model, the .npz read back, what is refused."""

import re
import shutil
import subprocess
import zlib

import numpy as np
import pytest

from coast_cli.design.stroke import stroke_table
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config

ACTUATOR = "\n[actuator]\nsteps_per_mm = 400.0\n"
PLAY = "\n[corrections.coulomb_friction]\nholds_per_m = 6.0\n"
PROGRAM = """
#include <stdio.h>
#include "table.h"
int main(void)
{
    float drive, length;
    while (scanf("%f %f", &drive, &length) == 2)
        printf("%.9g\\n", (double)coast_VALUE_at(drive, length));
    return coast_bending_length_mm[0] < 0.0f;
}
"""


@pytest.fixture
def configured(tmp_path, reference_text):
    def write(extra=""):
        path = tmp_path / "robot.toml"
        path.write_text(reference_text + extra, encoding="utf-8")
        return path

    return write


def answers(folder, value, points):
    """Compile a program round the table and return what it answers at points (drive, length)."""
    if shutil.which("cc") is None:
        pytest.skip("not here: a C compiler")
    (folder / "main.c").write_text(PROGRAM.replace("VALUE", value))
    flags = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-O1")
    subprocess.run(["cc", *flags, "-o", folder / "table", folder / "main.c"], check=True)
    lines = "\n".join(f"{drive!r} {length!r}" for drive, length in points)
    ran = subprocess.run([folder / "table"], input=lines, capture_output=True, text=True, check=True)
    return np.array(ran.stdout.split(), dtype=float)


def defined(text, name):
    return re.search(rf"#define COAST_{name} (\S+)", text)[1].rstrip("fu")


@pytest.mark.parametrize("extra", ["", PLAY])
@pytest.mark.parametrize(
    ("option", "span", "value"), [("--kappa", "8:40:4", "stroke_mm"), ("--stroke", "1.1:4.1:0.25", "curvature_per_m")]
)
def test_the_compiled_table_is_the_model_within_the_error_it_states(
    coast, configured, tmp_path, option, span, value, extra
):
    config = configured(extra)
    assert coast("stroke", config, option, span, "--x2", "20:40:5", "-o", tmp_path / "table.h").code == 0
    text = (tmp_path / "table.h").read_text()
    start, stop, _ = map(float, span.split(":"))
    random = np.random.default_rng(7)
    points = np.column_stack((random.uniform(start, stop, 300), random.uniform(20.0, 40.0, 300))).astype(np.float32)
    found = answers(tmp_path, value, points.astype(float).tolist())
    design = build(load_config(config))
    joint = design.joint()
    expected = []
    for drive, length in points.astype(float):
        given = {"curvatures": [drive]} if option == "--kappa" else {"strokes": [drive * 1e-3]}
        table = stroke_table(joint, [length * 1e-3], effects=design.effects, **given)
        expected.append(float(table.columns[value][0]))
    error = np.abs(found - expected).max()
    assert 0.2 * float(defined(text, "MAX_ERROR")) < error <= float(defined(text, "MAX_ERROR"))


def test_outside_the_table_its_ends_hold(coast, configured, tmp_path):
    coast("stroke", configured(), "--kappa", "0:40:10", "--x2", "20,40", "-o", tmp_path / "table.h")
    ends = answers(tmp_path, "stroke_mm", [(-5.0, 10.0), (0.0, 20.0), (99.0, 99.0), (40.0, 40.0)])
    assert ends[0] == ends[1]
    assert ends[2] == ends[3] == pytest.approx(4.7913, abs=1e-4)


def test_one_bending_length_is_a_table_too(coast, configured, tmp_path):
    coast("stroke", configured(), "--kappa", "0:40:10", "--x2", "30", "-o", tmp_path / "table.h")
    assert answers(tmp_path, "stroke_mm", [(20.0, 30.0)])[0] == pytest.approx(2.78982, abs=1e-5)


def test_steps_and_checksum_are_those_of_the_table(coast, configured, tmp_path):
    config = configured(ACTUATOR)
    outputs = ("-o", tmp_path / "table.h", "-o", tmp_path / "table.npz", "-o", tmp_path / "table.csv")
    assert coast("stroke", config, "--kappa", "0:40:10", "--x2", "20,40", *outputs).code == 0
    with np.load(tmp_path / "table.npz") as table:
        known = dict(table)
    text = (tmp_path / "table.h").read_text()
    crc = zlib.crc32(known["stroke_mm"].astype("<f4").tobytes())
    assert int(defined(text, "CRC32"), 16) == int(known["crc32"]) == crc
    np.testing.assert_array_equal(known["stroke_steps"], np.rint(400.0 * known["stroke_mm"]))
    rows = re.search(r"coast_stroke_steps.*?= \{(.*?)\};", text, re.DOTALL)[1]
    np.testing.assert_array_equal([int(one) for one in re.findall(r"\d+", rows)], known["stroke_steps"].ravel())
    csv = (tmp_path / "table.csv").read_text().splitlines()
    place = csv[0].split(",").index("stroke_steps")
    assert [int(line.split(",")[place]) for line in csv[1:]] == known["stroke_steps"].ravel().tolist()
    assert str(known["pair"]) == "OT4/MT1"
    assert 0.0 < float(known["max_error"]) < 0.02


def test_the_same_table_has_the_same_bytes(coast, configured, tmp_path):
    config = configured()
    for name in ("a", "b"):
        outputs = ("-o", tmp_path / f"{name}.h", "-o", tmp_path / f"{name}.npz")
        coast("stroke", config, "--kappa", "0:40:10", "--x2", "20,40", *outputs)
    for suffix in (".h", ".npz"):
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


@pytest.mark.parametrize(
    ("words", "extra", "told"),
    [
        (("--kappa", "20", "--x2", "20"), "", "needs two curvatures"),
        (("--kappa", "20,10", "--x2", "20"), "", "each above the last"),
        (("--kappa", "0:40:10", "--x2", "40,20"), "", "each above the last"),
        (("--kappa", "0:400:0.001", "--x2", "20"), "", "at most 100000"),
        (
            ("--kappa", "0:40:10", "--x2", "20"),
            "\n[corrections.precurvature]\ncurvature_per_m = 6.0\n",
            "no pull holds 0 1/m",
        ),
    ],
)
def test_a_table_that_a_controller_cannot_use_is_refused_and_not_written(
    coast, configured, tmp_path, words, extra, told
):
    ran = coast("stroke", configured(extra), *words, "-o", tmp_path / "table.h", "-o", tmp_path / "rows.csv")
    assert (ran.code, ran.out) == (2, "")
    assert told in ran.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["robot.toml"]


def test_the_way_back_is_a_table_of_its_own_where_the_model_has_one(coast, configured, tmp_path):
    words = ("--kappa", "10:40:10", "--x2", "20,40", "--branch", "release")
    play = configured("\n[corrections.backlash]\nwidth_mm = 0.2\n")
    assert coast("stroke", play, *words, "-o", tmp_path / "table.h").code == 0
    assert "on release." in (tmp_path / "table.h").read_text()
    back = answers(tmp_path, "stroke_mm", [(20.0, 20.0)])[0]
    assert coast("stroke", play, *words[:4], "-o", tmp_path / "table.h").code == 0
    assert back == pytest.approx(answers(tmp_path, "stroke_mm", [(20.0, 20.0)])[0] - 0.2, abs=2e-3)
    (tmp_path / "table.h").unlink()
    ran = coast("stroke", configured(), *words, "-o", tmp_path / "table.h")
    assert ran.code == 2
    assert "branch release: there is no such branch" in ran.err
    assert not (tmp_path / "table.h").exists()
