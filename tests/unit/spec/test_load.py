"""Each wrong input is refused in one sentence: the file, the line, the key, what was found and what is allowed."""

import os
from contextlib import suppress

import pytest

from coast_cli.errors import BadInput
from coast_cli.spec.config import Config
from coast_cli.spec.load import load_config, load_config_text


def refusal(text):
    with pytest.raises(BadInput) as caught:
        load_config_text(text, "tubes.toml")
    message = str(caught.value)
    assert "\n" not in message
    assert "Traceback" not in message
    return message


# what is replaced, by what, the line it stands on, and what the sentence must say
CHANGES = [
    ("depth_mm = 0.314", "depth_mm = -0.3", 24, ["outer.samples[0].depth_mm", "-0.3", "0.001 to 100"]),
    ("depth_mm = 0.314", "depth_mm = 0", 24, ["found 0;"]),
    ("depth_mm = 0.314", "depth_mm = nan", 24, ["found nan"]),
    ("depth_mm = 0.314", "depth_mm = inf", 24, ["found inf"]),
    ("depth_mm = 0.314", 'depth_mm = "0.3"', 24, ["'0.3'", "a number"]),
    ("depth_mm = 0.314", "depth_mm = true", 24, ["True", "a number"]),
    ("depth_mm = 0.314", "depth_mm = [0.3, 0.3]", 24, ["2 values", "188 values"]),
    ("depth_mm = 0.314", "depth_mm = []", 24, ["a number"]),
    ("depth_mm = 0.314", "depth_mm = 0.24", 24, ["outer radius, 0.25", "0.5"]),
    ("depth_mm = 0.314", "depth_mm = 0.5", 24, ["below the outer diameter, 0.5"]),
    ("depth_mm = 0.314", "dept_mm = 0.314", 24, ["no such key", "Did you mean depth_mm?"]),
    ("depth_mm = 0.314", "", 22, ["OT1 has no depth_mm"]),
    ("count = 188", "count = 0", 20, ["outer.notch.count", "whole number from 1"]),
    ("count = 188", "count = 1.5", 20, ["1.5", "whole number"]),
    (", count = 188", "", 22, ["OT1 has no notch.count"]),
    ("inner_diameter_mm = 0.40", "inner_diameter_mm = 0.60", 19, ["no wall is left", "0.5"]),
    ("outer_diameter_mm = 0.36", "outer_diameter_mm = 0.45", 44, ["no pair can be assembled", "MT1", "OT1"]),
    ('material = "nitinol"', 'material = "nitnol"', 17, ["no such material", "Did you mean nitinol?"]),
    ('material = "nitinol"', "", 22, ["OT1 has no material"]),
    ('name = "MT2"', 'name = "OT2"', 54, ["two tubes have this name"]),
    ('name = "MT2"', 'name = "M/2"', 54, ["letters, digits"]),
    ('name = "MT2"', "", 53, ["name", "required key is missing"]),
    ('pair = "OT4/MT1"', 'pair = "OT4/MT9"', 79, ["no middle tube", "MT9", "MT1, MT2, MT3"]),
    ('pair = "OT4/MT1"', 'pair = "OT4/MT1/X"', 79, ["more than two"]),
    ("version = 1", "version = 2", 7, ["found 2", "allowed: 1"]),
    ("version = 1", "verzion = 1", 7, ["verzion", "Did you mean version?"]),
    ("[tendon]", "[tendons]", 68, ["Did you mean tendon?"]),
    ("[environment]", "[[environment]]", 13, ["a table"]),
    ("gravity_m_per_s2 = 9.81", "gravity_m_per_s2 = -9.81", 14, ["0 to 1e+06"]),
    ("radius_mm = 0.038", "radius_mm = 0.08", 69, ["does not go into the bore of inner tube", "0.075"]),
    ("inner_diameter_mm = 0.15", "inner_diameter_mm = 0.25", 66, ["no wall is left"]),
    ("outer_diameter_mm = 0.25", "outer_diameter_mm = 0.29", 44, ["the inner tube", "MT1"]),
    ("min = 0.8, max = 4.0", "min = 5.0, max = 4.0", 83, ["min is above max"]),
    ("{ min = 0.8, max = 4.0 }", "{ }", 83, ["no limit"]),
    ("max_stroke_mm = {", "#", 85, ["max_tendon_strain", "max_stroke_mm"]),
    ("bending_length_mm = 40.0", "bending_length = 40.0", 84, ["Did you mean bending_length_mm?"]),
    ("youngs_modulus_gpa = 42.6", "youngs_modulus_gpa = { value = 1.0, min = 2.0, max = 3.0 }", 74, ["min <= value"]),
    ("youngs_modulus_gpa = 42.6", "youngs_modulus_gpa = { value = 1.0, min = 1.0, max = 1.0 }", 74, ["min < max"]),
    ("youngs_modulus_gpa = 42.6", "youngs_modulus_gpa = { value = 1, mn = 0.5, max = 3 }", 74, ["Did you mean min?"]),
    ("youngs_modulus_gpa = 42.6", "youngs_modulus_gpa = 0.0", 74, ["value, min, max"]),
    ("natural_curvature_per_m = 0.8", 'section = "sektor"', 25, ["'sector' or 'chord'"]),
    ("natural_curvature_per_m = 0.8", 'end_effect = "some"', 25, ["'none', 'table'"]),
    ("natural_curvature_per_m = 0.8", "end_effect = [0.1]", 25, ["1 values"]),
    ("natural_curvature_per_m = 0.8", "end_effect = -0.1", 25, ["0 to 100"]),
    ("[inner] ", "[inner", 63, ["not valid TOML"]),
    ("[checks]", "[corrections.backlsh]\n[checks]", 81, ["no such effect", "Did you mean backlash?"]),
    ("[checks]", "[corrections.backlash]\nwidth = 1.0\n[checks]", 82, ["no such parameter", "width_mm"]),
    ("[checks]", "[corrections.backlash]\nwidth_mm = -1.0\n[checks]", 82, ["found -1.0", "from 0 to"]),
]


@pytest.mark.parametrize(("old", "new", "line", "words"), CHANGES, ids=[new or f"no {old}" for old, new, *_ in CHANGES])
def test_a_wrong_value_is_refused_at_its_line(reference_text, old, new, line, words):
    assert old in reference_text
    message = refusal(reference_text.replace(old, new, 1))
    assert message.startswith(f"tubes.toml:{line}:"), message
    for word in words:
        assert word in message


def test_a_file_without_any_tube():
    assert "there is no tube" in refusal("[materials.m]\nyoungs_modulus_gpa = 1\ndensity_kg_per_m3 = 1000")


@pytest.mark.parametrize("text", ["", "# only a remark\n", "\n\n"])
def test_an_empty_file(text):
    assert "the file is empty" in refusal(text)


def test_a_truncated_file_is_refused_wherever_it_breaks_off(reference_text):
    end = reference_text.index("[checks]")
    for length in range(1, end, 97):
        with suppress(BadInput):  # some beginnings are whole configurations
            load_config_text(reference_text[:length], "tubes.toml")
    for length in range(reference_text.index("[tendon]") + 1, reference_text.index("length_mm = 388.68"), 7):
        assert refusal(reference_text[:length]).startswith("tubes.toml")


def test_deep_nesting_is_refused_not_crashed():
    assert "nested too deeply" in refusal("a = " + "[" * 100_000)


def test_a_number_of_thousands_of_digits_is_refused():
    assert "not valid TOML" in refusal("version = " + "9" * 5000)


def test_what_is_not_a_readable_text_file(tmp_path, reference_text):
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"version = 1\nname = '\xff\xfe'")
    for path, words in (
        (tmp_path / "absent.toml", "no such file"),
        (tmp_path, "a folder"),
        (binary, "binary.toml:2: not UTF-8"),
        (tmp_path / "nul\0.toml", "cannot be read"),
        (tmp_path / ("x" * 300), "cannot be read"),
    ):
        with pytest.raises(BadInput, match=words):
            load_config(path)
    (tmp_path / "tubes.toml").write_text(reference_text, encoding="utf-8")
    with pytest.raises(BadInput, match=r"Did you mean tubes.toml"):
        load_config(tmp_path / "tube.toml")


def test_a_file_without_permission(tmp_path, reference_text, monkeypatch):
    path = tmp_path / "tubes.toml"
    path.write_text(reference_text, encoding="utf-8")
    path.chmod(0)
    if os.access(path, os.R_OK):  # the superuser may read everything, so the refusal is made
        monkeypatch.setattr("pathlib.Path.open", lambda *_: (_ for _ in ()).throw(PermissionError(13, "denied")))
    with pytest.raises(BadInput, match="no permission"):
        load_config(path)


def test_a_byte_order_mark_is_no_error(tmp_path, reference_text):
    path = tmp_path / "tubes.toml"
    path.write_text("\ufeff" + reference_text, encoding="utf-8")
    assert load_config(path).model_dump() == load_config_text(reference_text).model_dump()


def test_the_configurations_of_others_load(shared):
    for path in sorted(shared.glob("*/tubes.toml")):
        assert isinstance(load_config(path), Config)


def test_bounds_of_a_calibratable_and_of_a_plain_number(reference_text):
    table = "youngs_modulus_gpa = { value = 42.6, min = 30.0, max = 80.0 }"
    config = load_config_text(reference_text.replace("youngs_modulus_gpa = 42.6", table))
    assert config.bounds("joint.youngs_modulus_gpa") == (42.6, 30.0, 80.0)
    assert config.bounds("joint.notch_friction") == (1.0063, 1.0, 10.0)
    assert config.bounds("materials.nitinol.youngs_modulus_gpa") == (45.0, 0.001, 10_000.0)


@pytest.mark.parametrize("path", ["/dev/zero", "a\0b"])
def test_a_stream_that_never_ends_and_a_name_that_cannot_be_are_refused(path):
    with pytest.raises(BadInput, match=r"too large|cannot be read"):
        load_config(path)


def test_more_notches_than_a_computer_holds_are_refused_before_any_is_made(reference_text):
    many = "".join(f'[[middle.samples]]\nname = "X{number}"\ndepth_mm = 0.25\n' for number in range(30))
    text = reference_text.replace("count = 125", "count = 100_000").replace("[inner]", many + "\n[inner]", 1)
    with pytest.raises(BadInput, match="too many notches on all tubes together; found 3300000; allowed: up to 2000000"):
        load_config_text(text)
