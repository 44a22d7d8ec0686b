"""The table [joint] of a device without tubes: what it takes, what it refuses, and which commands need tubes."""

import subprocess
import sys

import pytest

from coast_cli.errors import BadInput
from coast_cli.mechanics.transmission import Transmission
from coast_cli.output.glossary import look_up
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config_text
from coast_cli.spec.mistakes import mistakes
from coast_cli.spec.transmission import build_transmission

TEXT = '[joint]\nkind = "transmission"\nratio = -9.0\nzero_mm = { value = 8.0, min = 0.0, max = 10.0 }\n'


def refusal(text):
    with pytest.raises(BadInput) as caught:
        load_config_text(text, "device.toml")
    return str(caught.value)


def test_it_needs_no_tubes():
    config = load_config_text(TEXT)
    assert config.joint.pair is None
    assert config.bounds("joint.zero_mm") == (8.0, 0.0, 10.0)
    built = build_transmission(config.joint, "force", by_stroke=False)
    assert built == Transmission(ratio=-9.0, zero=8.0, ratio_unit=1.0, drive_unit=1.0)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("ratio = -9.0\n", "", 1, ["joint.ratio", "a required key is missing"]),
        ("ratio", "ratoi", 3, ["no such key", "Did you mean ratio?"]),
        ("-9.0", "inf", 3, ["from -1e+06 to 1e+06"]),
        ("-9.0", "{ value = 1, min = 2, max = 3 }", 3, ["min <= value"]),
        ("transmission", "gear", 2, ["'notched' (the usual) or 'transmission'"]),
        ("[joint]", "[materials.m]\nyoungs_modulus_gpa = 1\ndensity_kg_per_m3 = 900\n[joint]", 1, ["has no tubes"]),
        ("zero_mm", "deadband_mm", 4, ["no such key", "load_ratio"]),
    ],
)
def test_what_is_wrong_is_said_at_its_line(old, new, line, words):
    message = refusal(TEXT.replace(old, new, 1))
    assert message.startswith(f"device.toml:{line}:"), message
    for word in words:
        assert word in message


def test_what_needs_tubes_refuses_it_in_one_sentence():
    with pytest.raises(BadInput, match="a transmission has no tubes, which this needs"):
        build(load_config_text(TEXT))


def test_commands_of_tubes_answer_with_3(tmp_path):
    path = tmp_path / "device.toml"
    path.write_text(TEXT)
    assert mistakes(path)[1] == []
    answer = subprocess.run(
        [sys.executable, "-m", "coast_cli", "rank-pairs", str(path)], capture_output=True, text=True, check=False
    )
    assert answer.returncode == 3
    assert answer.stdout == ""
    assert answer.stderr.count("\n") == 1


def test_a_notched_joint_still_needs_its_materials(reference_text):
    start, end = reference_text.index("[materials"), reference_text.index("[outer]")
    assert "materials: a required key is missing" in refusal(reference_text[:start] + reference_text[end:])


def test_its_keys_are_explained():
    assert {row["name"] for row in look_up("joint")} >= {"joint.ratio", "joint.zero_mm", "joint.youngs_modulus_gpa"}
