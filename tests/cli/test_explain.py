"""``coast explain`` and ``coast effects``: everything has an entry, a table explains its keys, an effect has a page."""

import json

import pytest

from coast_cli.design.signature import SHOWN, signature
from coast_cli.effects.catalogue import CATALOGUE, effects_of
from coast_cli.effects.effect import declared

# What changes the response of the drive shown by less, in the whole of its range: the tubes are light, lengths are known.
FAINT = {
    "gravity",
    "bending_length_offset",
    "leadscrew_pitch_error",
    # of another column than the response, of a load that a joint alone does not have, or of rows that are left out
    "camera_saturation",
    "frozen_frames",
    "load_cell_scale",
    "load_cell_offset",
}


def rows(ran):
    assert ran.code == 0
    return json.loads(ran.out)["rows"]


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.parametrize("width", ["20", "80"])
def test_every_effect_has_a_page_that_fits(coast, monkeypatch, name, width):
    monkeypatch.setenv("COLUMNS", width)
    ran = coast("explain", name)
    assert (ran.code, ran.err) == (0, "")
    assert max(map(len, ran.out.splitlines())) <= int(width)
    said = "".join(ran.out.split())
    for recording in CATALOGUE[name].recordings:
        effect = declared(CATALOGUE[name], recording)
        for part in (effect.title, effect.equation, effect.decided_by, effect.source):
            assert "".join(part.split()) in said
    assert ("Signature:" in said) == ("joint" in CATALOGUE[name].recordings)


@pytest.mark.parametrize("name", effects_of("joint"))
def test_a_signature_shows_what_the_effect_does(name):
    found = signature(CATALOGUE[name])
    assert (found.change >= SHOWN) == (name not in FAINT)
    for parameter, value in zip(found.effect.parameters, found.effect.values(), strict=True):
        assert parameter.low <= value <= parameter.high


def test_a_signature_is_drawn(coast, tmp_path):
    pictures = [tmp_path / "one.svg", tmp_path / "two.svg"]
    for picture in pictures:
        assert coast("explain", "backlash", "--plot", picture).code == 0
    assert pictures[0].read_bytes() == pictures[1].read_bytes()
    assert b"curvature" in pictures[0].read_bytes()
    assert coast("explain", "lens_distortion", "--plot", tmp_path / "no.svg").code == 2


def test_effects_are_listed_by_stage(coast):
    found = rows(coast("effects", "-f", "json"))
    assert sorted(row["effect"] for row in found) == sorted(CATALOGUE)
    stages = [row["stage"] for row in found]
    assert list(dict.fromkeys(stages)) == ["drive", "tendon", "transmission", "structure", "sensor"]
    assert {row["of"] for row in found} == {"a joint", "shapes", "both"}


def test_a_table_explains_its_keys_with_what_is_typical_and_who_knows(coast):
    found = {row["name"]: row for row in rows(coast("explain", "joint", "-f", "json"))}
    assert found["joint.deadband_mm"]["typical"] == "1.2"
    assert found["joint.deadband_mm"]["source"].startswith("paper")
    assert found["joint.deadband_mm"]["allowed"] == "from 0 to 100"
    assert set(found) >= {"joint", "joint.pair", "joint.youngs_modulus_gpa"}
    assert len(rows(coast("explain", "checks", "-f", "json"))) > 5


def test_without_a_name_everything_is_listed(coast):
    found = rows(coast("explain", "-f", "json"))
    assert {"backlash", "outer.samples[].depth_mm", "score", "checks.max_stroke_mm"} <= {row["name"] for row in found}
