"""What the layers below the command line say is said in the words of the field: a Python user has no ``--options``."""

import ast
import re
from pathlib import Path

import pytest

import coast_cli

PACKAGE = Path(coast_cli.__file__).parent
BELOW = sorted(
    path
    for layer in (
        "units.py",
        "errors.py",
        "rows.py",
        "mechanics",
        "effects",
        "spec",
        "recordings",
        "design",
        "diagnosis",
    )
    for path in (PACKAGE.rglob(f"{layer}/*.py") if not layer.endswith(".py") else [PACKAGE / layer])
)
OPTION = re.compile(r"(?<![\w-])--[a-z]")


@pytest.mark.parametrize("path", BELOW, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_text_names_an_option(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    assert [text for text in texts if OPTION.search(text)] == []


def test_there_are_layers_to_read():
    assert len(BELOW) > 60
