"""The JSON Schema is a schema, takes what the documents take, refuses what they refuse, and has no null in it."""

import json
import tomllib

import jsonschema
import pytest

from coast_cli.spec.schema import config_schema


@pytest.fixture
def validator():
    schema = config_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_there_is_no_null_branch():
    assert "null" not in json.dumps(config_schema())


def test_it_accepts_the_reference(validator, reference_text):
    validator.validate(tomllib.loads(reference_text))


def test_it_accepts_a_calibratable_number_and_a_depth_for_each_notch(validator, reference_text):
    text = reference_text.replace("= 42.6", "= { value = 42.6, min = 1.0, max = 2000.0 }")
    validator.validate(tomllib.loads(text.replace("depth_mm = 0.314", f"depth_mm = {[0.3] * 188}")))


def test_it_accepts_the_configurations_of_others(validator, shared):
    for path in sorted(shared.glob("*/tubes.toml")):
        validator.validate(tomllib.loads(path.read_text()))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("depth_mm = 0.314", "depth = 0.314"),
        ("depth_mm = 0.314", "depth_mm = -0.3"),
        ("depth_mm = 0.314", "depth_mm = 'deep'"),
        ("count = 188", "count = 1.5"),
        ("version = 1", "version = 2"),
        ("youngs_modulus_gpa = 42.6", "youngs_modulus_gpa = { value = 42.6 }"),
        ("length_mm = 388.68", ""),
    ],
)
def test_it_refuses_what_the_documents_refuse(validator, reference_text, old, new):
    assert not validator.is_valid(tomllib.loads(reference_text.replace(old, new, 1)))


def test_every_key_says_what_it_means():
    schema = config_schema()
    tables = [schema, *(table for name, table in schema["$defs"].items() if name != "Calibrated")]
    assert all("description" in key for table in tables for key in table["properties"].values())
