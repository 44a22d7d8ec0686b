"""Every input of a configuration is listed once, with what its file says of it; defaults of the program among them."""

import tomllib

import pytest

from coast_cli.output.labels import label_text
from coast_cli.output.report_inputs import Sources, inputs_of, inputs_section, said_of
from coast_cli.spec.load import load_config, load_config_text

SMALL = """# Tubes of the bench.
# "guess" = assumed.

[materials.nitinol]
youngs_modulus_gpa = 45.0  # supplier
density_kg_per_m3 = 6450.0

[middle]  # one wrist
material = "nitinol"
# assumed, as on the drawing
# of the stock
outer_diameter_mm = 0.5
inner_diameter_mm = 0.4
notch = { cut_mm = 0.3, uncut_mm = 0.3, count = 3 }  # cut: Assumed

[[middle.samples]]
name = "A"
depth_mm = [
  0.30,  # first
  0.31,
  0.32,
]
"""


@pytest.fixture
def small():
    return {".".join(map(str, one.path)): one for one in inputs_of(load_config_text(SMALL))}


def test_a_source_is_the_comment_beside_a_key_or_right_above_it(small):
    assert small["materials.nitinol.youngs_modulus_gpa"].source == "supplier"
    assert small["middle.outer_diameter_mm"].source == "assumed, as on the drawing of the stock"
    assert small["middle.inner_diameter_mm"].source == ""
    assert small["middle.notch.count"].source == "cut: Assumed"


def test_what_the_file_leaves_out_is_a_default(small):
    left_out = {name for name, one in small.items() if not one.given}
    assert left_out == {
        "environment.gravity_m_per_s2",
        "middle.section",
        "middle.end_effect",
        "middle.natural_curvature_per_m",
    }
    assert small["middle.natural_curvature_per_m"].value == 0.0
    assert small["middle.section"].value == "sector"


def test_inputs_are_counted(small):
    assert said_of(list(small.values())) == (
        "4 of 12 marked as assumed in the file, 4 left to defaults of the program, 3 without a stated source"
    )


def test_the_head_of_the_file_and_of_its_tables_are_told_apart():
    sources = Sources(load_config_text(SMALL))
    assert sources.head == ["Tubes of the bench.", '"guess" = assumed.']
    assert sources.of(("middle",)) == "one wrist"
    assert sources.of(("materials", "nitinol")) == ""


def test_each_key_of_the_file_is_listed_once(reference, reference_text):
    config = load_config(reference)
    listed = [one.path for one in inputs_of(config) if one.given]
    assert len(listed) == len(set(listed))

    def leaves(value, path=()):
        items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        if not items:
            yield path
        for key, inner in items:
            yield from leaves(inner, (*path, key))

    known = {path for path in leaves(tomllib.loads(reference_text)) if path[-1] != "name"}
    assert set(listed) == {path for path in known if path[0] not in {"version", "checks"}}


def test_a_list_and_a_range_are_written_short():
    text = SMALL.replace("youngs_modulus_gpa = 45.0", "youngs_modulus_gpa = { value = 45.0, min = 40.0, max = 50.0 }")
    html = inputs_section(load_config_text(text))
    assert "3 values, 0.3 to 0.32" in html
    assert "45 (40 to 50)" in html
    assert "<mark>Assumed</mark>" in html


def test_effects_of_a_model_are_inputs_too(reference_text):
    config = load_config_text(reference_text + "\n[corrections.backlash]\nwidth_mm = 0.18  # fitted\n")
    assert "corrections.backlash" in inputs_section(config)
    assert next(one for one in inputs_of(config) if one.path[0] == "corrections").source == "fitted"


@pytest.mark.parametrize(
    ("values", "texts"),
    [
        ((53.321, 5.0, -0.25), ["53.32", "5.00", "-0.25"]),
        ((0.26257, -0.000157), ["0.2626", "-0.0002"]),
        ((1123.8, 6.9), ["1124", "7"]),
        ((12345.6,), ["12346"]),
        ((0.0, -0.0), ["0", "0"]),
        ((0.5, -0.00001), ["0.5000", "0.0000"]),
        ((None, 0.5), ["-", "0.5000"]),
        ((float("nan"), 2.0), ["-", "2.000"]),
        ((), []),
    ],
)
def test_a_column_has_one_number_of_decimals(values, texts):
    assert label_text(values) == texts
