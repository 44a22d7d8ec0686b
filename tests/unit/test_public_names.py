"""Every public class and function is defined once: two of a name drift apart."""

import ast
from collections import defaultdict
from pathlib import Path

import coast_cli

ROOT = Path(coast_cli.__file__).parent


def defined():
    found = defaultdict(list)
    for path in sorted(ROOT.rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
                found[node.name].append(path.relative_to(ROOT).as_posix())
    return found


def is_a_command(name, path):
    """A command has the name of what it does, and its file the same."""
    return path == f"cli/{name}.py"


def is_a_format(name, path):
    """Every output format renders."""
    return name == "render" and path.startswith("output/")


def test_no_name_is_defined_twice():
    once = {
        name: [path for path in where if not is_a_command(name, path) and not is_a_format(name, path)]
        for name, where in defined().items()
    }
    assert {name: where for name, where in once.items() if len(where) > 1} == {}
