"""A mapping is proposed for files that nobody has mapped, and recordings are written with our columns."""

import math

import numpy as np
import pytest

from coast_cli.errors import BadInput
from coast_cli.recordings.convert import write_recordings
from coast_cli.recordings.mapping import load_mapping
from coast_cli.recordings.read import read_recordings
from coast_cli.recordings.suggest import suggest

ROWS = [
    (0.1 * i, 10.0 * math.sin(i / 8), -12.5 * math.sin(i / 8 - 0.1) + 3.0, 0.2 * math.sin(i / 8)) for i in range(100)
]


def table(header, separator=",", rows=ROWS, decimal="."):
    lines = [separator.join(f"{cell:.3f}".replace(".", decimal) for cell in row) for row in rows]
    return "\n".join([*header, *lines]) + "\n"


FILES = {
    "units in names": table(["time_s,motor_deg,jaw_deg,jaw_torque_n_m"]),
    "plain names": table(["t,Command,Angle,current"]),
    "camel case": table(["Time,motorPosition,tipAngle,tempC"]),
    "spaces": table(["t cmd bend temp"], separator="  "),
    "decimal commas": table(["Zeit;Motor;Angle;x"], separator=";", decimal=","),
    "no header": table([], rows=[row[:3] for row in ROWS]),
    "no header and decimal commas": table([], separator=";", decimal=",", rows=[row[:3] for row in ROWS]),
    "comments and units": table(["% rig 7", "", "time,motor,jaw,load", "s,deg,deg,N"]),
    "lines before": table(["Rig 7", "made on Monday", "time,motor,jaw,load"]),
    "other order": table(["x,jaw,command,stamp"], rows=[row[::-1] for row in ROWS]),
}


@pytest.mark.parametrize("name", FILES)
def test_what_is_proposed_reads_the_file(name, tmp_path):
    path, mapping = tmp_path / "foreign.csv", tmp_path / "map.toml"
    path.write_text(FILES[name], encoding="utf-8")
    text = suggest(str(path))
    mapping.write_text(text, encoding="utf-8")
    assert text.count("\n") <= 12
    (run,) = read_recordings([path], columns=load_mapping(mapping)).joint.runs
    assert run.time == pytest.approx([row[0] for row in ROWS])
    assert abs(np.corrcoef(run.stroke, [row[1] for row in ROWS])[0, 1]) > 0.999
    assert abs(np.corrcoef(run.response[:, 0], [row[2] for row in ROWS])[0, 1]) > 0.999
    assert np.corrcoef(run.stroke, run.response[:, 0])[0, 1] > 0.9  # the sign is turned, and said


def test_columns_of_runs_are_found(tmp_path):
    path = tmp_path / "a.csv"
    lines = [
        "specimen,trial,command,angle_deg",
        *(f"{i // 50},{i // 25 % 2},{r[1]},{r[2]}" for i, r in enumerate(ROWS)),
    ]
    path.write_text("\n".join(lines))
    assert 'run = ["specimen", "trial"]' in suggest(str(path))


def test_nothing_to_suggest(tmp_path):
    path = tmp_path / "a.csv"
    for text in ("a,b\nx,y\nz,w\n", "a,b\n1,1\n1,1\n1,1\n", "time_s,stroke_mm\n1,2\n2,3\n3,4\n"):
        path.write_text(text)
        with pytest.raises(BadInput, match="nothing to suggest"):
            suggest(str(path))


def test_every_shared_file_is_read_by_what_is_proposed(shared, tmp_path):
    mapping = tmp_path / "map.toml"
    for path in sorted(shared.glob("*/*.csv")):
        text = suggest(str(path))
        mapping.write_text(text)
        assert text.count("\n") <= 12
        read = read_recordings([path], columns=load_mapping(mapping))
        assert read.joint.runs
        for run in read.joint.runs:
            follows = np.corrcoef(run.drive[run.valid], run.response[run.valid].sum(axis=1))[0, 1]
            assert follows > 0.7


@pytest.mark.parametrize(
    "text",
    [
        "run,time_s,outer,middle,bending_length_mm,stroke_mm,tension_n,curvature_per_m\na,0,O,M,30,1,2,3.5\na,1,O,M,30,2,3,\n",
        "run,tension_n,notch_1_deg,notch_2_deg,load_n_m\n=x,1,2,3,4\n=x,2,3,4,5\n",
        "stroke_mm,position_mm,load_n\n1,2,3\n2,3,4\n",
        "stroke_mm,force_n\n1,2\n2,3\n",
        "run,outer,middle,natural,x_mm,y_mm\na,O,,up,0,0\na,O,,up,1,2\na,O,,up,2,3\n",
    ],
)
def test_what_is_converted_is_read_the_same(text, tmp_path):
    first, second = tmp_path / "a.csv", tmp_path / "b.csv"
    first.write_text(text)
    read = read_recordings([first])
    with second.open("w") as stream:
        write_recordings(read, stream)
    again = read_recordings([second])
    for one, other in zip(*((r.joint or r.shape).runs for r in (read, again)), strict=True):
        for name in vars(one):
            if name not in ("source", "line", "branches", "name"):
                np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert again.run_names in (read.run_names, ("a",))
    assert "'=x" in second.read_text() or "=x" not in text


def test_runs_of_unlike_columns_are_converted_apart(coast, tmp_path):
    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    one.write_text("stroke_mm,bend_deg\n1,2\n2,3\n")
    other.write_text("stroke_mm,force_n\n1,2\n2,3\n")
    ran = coast("recordings", one, other, "--convert", tmp_path / "ours.csv")
    assert ran.code == 2
    assert "bend_deg, force_n" in ran.err
    assert not (tmp_path / "ours.csv").exists()
    assert coast("recordings", one, "--convert", one).code == 3


def test_suggest_edit_convert(coast, tmp_path):
    path, mapping, ours = (tmp_path / name for name in ("foreign.csv", "map.toml", "ours.csv"))
    path.write_text(FILES["comments and units"])
    ran = coast("recordings", path, "--suggest")
    assert ran.code == 0
    mapping.write_text(ran.out)
    ran = coast("recordings", path, "--columns", mapping, "--convert", ours)
    assert (ran.code, ran.out) == (0, "")
    assert "1 runs" in ran.err
    assert ours.read_text().startswith("run,time_s,stroke_mm,bend_deg")
    assert coast("recordings", ours).code == 0
    assert coast("recordings", path, path, "--suggest").code == 2
    assert coast("recordings", tmp_path / "none.csv", "--suggest").code == 3
