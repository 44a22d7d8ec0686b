"""Every public class and function is defined once: two of a name drift apart."""

import ast
from collections import defaultdict
from pathlib import Path

import coast_cli

ROOT = Path(coast_cli.__file__).parent
# A command has the name of what it does; every output format renders.
MAY = {"calibrate", "check", "compare", "diagnose", "explore", "report", "stroke", "render"}
# Of the search for laws without a name, and known: this list may only grow shorter.
KNOWN = {"Scene", "Design", "unit_of"}


def defined():
    found = defaultdict(list)
    for path in sorted(ROOT.rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
                found[node.name].append(path.relative_to(ROOT).as_posix())
    return found


def test_no_name_of_the_diagnosis_is_defined_twice_anywhere():
    twice = {name: where for name, where in defined().items() if len(where) > 1 and name not in MAY}
    ours = {name: where for name, where in twice.items() if any(path.startswith("diagnosis/") for path in where)}
    assert set(ours) == KNOWN
