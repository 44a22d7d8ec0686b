"""What ``help()`` says of the public functions: a unit of whatever has one, and an example that runs."""

import doctest
import inspect
import re

import numpy as np
import pytest

import coast_cli as coast

FUNCTIONS = sorted(name for name in dir(coast) if inspect.isfunction(getattr(coast, name)))
CLASSES = sorted(
    name
    for name in dir(coast)
    if inspect.isclass(getattr(coast, name)) and not issubclass(getattr(coast, name), Exception)
)
UNIT = re.compile(r"\b(SI|m|mm|rad|deg|degrees|Pa|N|s|kg/m|m/s\^2|1/m|N m\^2|noise levels)\b|units?\b")
# What takes and gives names, texts and files alone.
WITHOUT = {"RankOptions", "load_config", "load_config_text", "load_mapping", "model_text"}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_its_example_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function = getattr(coast, name)
    found = doctest.DocTestParser().get_doctest(inspect.getdoc(function), {"coast": coast, "np": np}, name, None, 0)
    assert found.examples
    said = []
    ran = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS, verbose=False).run(found, out=said.append)
    assert ran.failed == 0, "".join(said)


@pytest.mark.parametrize("name", sorted({*FUNCTIONS, *CLASSES} - WITHOUT))
def test_help_shows_units(name):
    assert UNIT.search(inspect.getdoc(getattr(coast, name)))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_is_explained(name):
    """By a line of its own, or in the words of the first sentence."""
    function = getattr(coast, name)
    said = inspect.getdoc(function)
    missing = [one for one in inspect.signature(function).parameters if not re.search(rf"\b{one}\b", said)]
    assert missing == []
