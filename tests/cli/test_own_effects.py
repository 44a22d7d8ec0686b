"""``--effects FILE.py``: the guide's example is named, saved and loaded again; what breaks the contract is refused."""

import csv
import json
import tomllib
from types import SimpleNamespace

import numpy as np
import pytest

from coast_cli.cli.guide import PAGES
from coast_cli.effects import own
from coast_cli.effects.catalogue import CATALOGUE
from coast_cli.errors import BadInput
from tests.modelled_joint import recording
from tests.photographed_tube import Bench, config_text, shape

SHEAR = 0.15
TEXT = (PAGES / "own-effects.md").read_text(encoding="utf-8")
EXAMPLE = TEXT.split("```python\n")[1].split("```")[0]


@pytest.fixture
def skew(tmp_path):
    path = tmp_path / "skew.py"
    path.write_text(EXAMPLE, encoding="utf-8")
    return path


def write(path, header, rows):
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])
    return path


def test_it_is_named_on_a_joint_and_saved_and_loaded(coast, skew, tmp_path, reference):
    with own.using_effects([skew]):
        runs = recording([CATALOGUE["picture_skew"](shear=SHEAR)], witness=True)
    rows = [
        (run.name, "OT4", "MT1", *(f"{value:.9g}" for value in row))
        for run in runs
        for row in zip(
            run.time, run.stroke * 1e3, run.bending_length * 1e3, run.tension, run.response[:, 0], strict=True
        )
    ]
    header = ["run", "outer", "middle", "time_s", "stroke_mm", "bending_length_mm", "tension_n", "curvature_per_m"]
    file, model = write(tmp_path / "joint.csv", header, rows), tmp_path / "model.toml"
    ran = coast("diagnose", reference, file, "--effects", skew, "--save-model", model, "--max-effects", 1, "-f", "json")
    assert ran.code == 0, ran.err
    found = json.loads(ran.out)
    assert [effect["id"] for effect in found["effects"]] == ["picture_skew"]
    assert found["effects"][0]["parameters"]["shear"]["value"] == pytest.approx(SHEAR, rel=0.1)
    assert found["provenance"]["effects"][0]["file"] == str(skew)
    saved = tomllib.loads(model.read_text())["corrections"]["picture_skew"]
    assert saved["recording"] == "joint"
    refused = coast("compare", model, file)
    assert refused.code == 3
    assert "`coast guide own-effects`" in refused.err
    assert coast("compare", model, file, "--effects", skew).code == 0


def test_it_is_named_on_photographs(coast, skew, tmp_path):
    rng, rows = np.random.default_rng(3), []
    for number, (name, natural) in enumerate((("A", 4.0), ("B", 9.0))):
        for up in (True, False):
            x, y = shape(Bench(natural=natural), up, points=60)
            places = np.stack([x + SHEAR * y, y], axis=1) * 1e3 + rng.normal(0.0, 0.02, (x.size, 2))
            run = f"{number}{'up' if up else 'down'}"
            rows += [(run, name, "up" if up else "down", f"{a:.6f}", f"{b:.6f}") for a, b in places]
    config = tmp_path / "tubes.toml"
    config.write_text(config_text({"A": (0.314, 4.0), "B": (0.314, 9.0)}), encoding="utf-8")
    file = write(tmp_path / "shapes.csv", ["run", "tube", "natural", "x_mm", "y_mm"], rows)
    ran = coast("diagnose", config, file, "--effects", skew, "--max-effects", 1, "-f", "json")
    assert ran.code == 0, ran.err
    assert "picture_skew" in [effect["id"] for effect in json.loads(ran.out)["effects"]]


def test_it_has_a_page_and_a_line_in_the_list(coast, skew):
    said = coast("explain", "picture_skew", "--effects", skew)
    assert said.code == 0
    assert said.out.count("picture_skew: rows of the picture are shifted") == 2  # of a joint, and of shapes
    assert "picture_skew" in coast("effects", "--effects", skew).out
    assert "picture_skew" not in coast("effects").out
    assert "picture_skew" not in CATALOGUE


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('    id = "picture_skew"\n', "", "its id must be"),
        ('"picture_skew"', '"backlash"', "there is an effect 'backlash' already"),
        ('    title = "rows of the picture are shifted"\n', "", "it says no title"),
        ('kind = "sensor"', 'kind = "camera"', "its kind is 'camera'; allowed: physics, sensor, parameter"),
        ("frozen=True", "frozen=False", "when it is run: TypeError"),
        ("    def see(", "    def look(", "it acts at OnImage and has no method see"),
        ("shear: float = 0.0", "shear: float = 0.1", "shear is 0.1 by default and its null is 0; they must agree"),
        ('"shear", 0.0', '"sheer", 0.0', "its parameter sheer is no field of the class"),
        ("0.0, -0.5, 0.5", "0.0, 0.1, 0.5", "the null of shear, 0, is not from 0.1 to 0.5"),
        (" if self.shear else response", " + 1.0", "at its null it changes what is predicted"),
        ("x + self.shear *", "x + np.log(-1.0 - self.shear) *", "at its null it changes"),
        ("history.bending_length[:, None]", "history.length", "it fails where it acts: AttributeError"),
        ("import numpy as np", "import numpy as np (", "SyntaxError"),
        ("class PictureSkew(OnSensor, OnImage)", "class _Hidden(OnSensor, OnImage)", "there is no effect in it"),
    ],
)
def test_what_breaks_the_contract_is_refused_with_the_reason(coast, tmp_path, old, new, reason):
    path = tmp_path / "broken.py"
    assert old in EXAMPLE
    path.write_text(EXAMPLE.replace(old, new), encoding="utf-8")
    ran = coast("effects", "--effects", path)
    assert (ran.code, ran.out) == (3, "")
    assert reason in ran.err
    assert "broken.py" in ran.err


def test_a_file_that_is_none_is_refused(coast, tmp_path):
    assert coast("effects", "--effects", tmp_path / "missing.py").code == 3
    text = tmp_path / "skew.txt"
    text.write_text(EXAMPLE, encoding="utf-8")
    assert "a .py file" in coast("effects", "--effects", text).err


def test_an_installed_package_takes_part_without_an_option(monkeypatch, skew):
    with own.using_effects([skew]):
        kind = CATALOGUE["picture_skew"]
    point = SimpleNamespace(name="picture_skew", value="my_package:PictureSkew", load=lambda: kind)
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: [point] if group == own.GROUP else [])
    monkeypatch.setattr("coast_cli.effects.catalogue.CATALOGUE", CATALOGUE)
    try:
        own.add_installed.__wrapped__()
        assert CATALOGUE["picture_skew"] is kind
        with pytest.raises(BadInput, match="already"):
            own.add_installed.__wrapped__()
    finally:
        CATALOGUE.pop("picture_skew", None)
