from pathlib import Path

import pytest

from coast_cli.errors import BadInput
from coast_cli.spec.build import build
from coast_cli.spec.load import REFERENCE, load_config_text
from coast_cli.spec.superelastic import SuperelasticFields

TEXT = Path(REFERENCE).read_text()
GOOD = {"martensite_modulus_gpa": 25.0, "upper_plateau_mpa": 450.0, "lower_plateau_mpa": 180.0}


def config(**changes):
    values = GOOD | changes
    table = "\n".join(f"{name} = {value}" for name, value in values.items() if value is not None)
    return load_config_text(f"{TEXT}\n[materials.nitinol.superelastic]\n{table}\n", "tubes.toml")


def test_a_table_makes_every_tube_of_the_material_superelastic():
    design = build(config(temperature_c=37.0))
    for tube in (*design.outer, *design.middle):
        assert tube.superelastic.upper_plateau == pytest.approx(450e6 + 15 * 6.5e6)
        assert tube.superelastic.austenite_modulus == 45e9
    assert build(load_config_text(TEXT)).outer[0].superelastic is None


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        (
            {"lower_plateau_mpa": 450.0},
            "lower_plateau_mpa",
            "wrong order; found 450.0; allowed: below upper_plateau_mpa, 450",
        ),
        (
            {"martensite_modulus_gpa": 46.0},
            "martensite_modulus_gpa",
            "stiffer than austenite; found 46.0; allowed: at most",
        ),
        (
            {"temperature_c": -20.0},
            "temperature_c",
            "past the transformation, with no lower plateau left; found -20.0; allowed: above -5.69",
        ),
        (
            {"transformation_strain": 0.001},
            "transformation_strain",
            "wider than its plateau is long; found 0.001; allowed: above",
        ),
        (
            {"plateau_slope_gpa": 30.0},
            "plateau_slope_gpa",
            "no plateau; found 30.0; allowed: below martensite_modulus_gpa, 25",
        ),
        ({"upper_plateau_mpa": -1.0}, "upper_plateau_mpa", "not allowed; found -1.0; allowed: a number from 1 to 3000"),
        ({"upper_plateau_mpa": None}, "upper_plateau_mpa", "a required key is missing"),
        ({"plateau_mpa": 3.0}, "plateau_mpa", "there is no such key"),
    ],
)
def test_what_no_material_has_is_refused_in_one_sentence(changes, key, words):
    with pytest.raises(BadInput) as refused:
        config(**changes)
    message = str(refused.value)
    assert message.startswith("tubes.toml:")
    assert f"materials.nitinol.superelastic.{key}: " in message
    assert words in message
    assert "\n" not in message


def test_its_keys_are_explained():
    from coast_cli.output.glossary import look_up

    names = {row["name"] for row in look_up("materials.NAME.superelastic")}
    assert {f"materials.NAME.superelastic.{name}" for name in SuperelasticFields.model_fields} < names
    (key,) = look_up("materials.NAME.density_kg_per_m3")
    assert key["allowed"] == "from 100 to 30000"
