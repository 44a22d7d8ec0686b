"""The rig shares no code with what it judges."""

import ast
import subprocess
import sys
from pathlib import Path

import examples.concealed

PACKAGE = Path(examples.concealed.__file__).parent
ALLOWED = {"numpy", "scipy", "matplotlib", "cryptography", "distributed", "examples"}


def imported(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} imports relatively"
            found.add((node.module or "").split(".")[0])
    return found


def test_no_module_of_the_rig_imports_the_library():
    modules = sorted(PACKAGE.rglob("*.py"))
    assert len(modules) > 8
    for path in modules:
        outside = {name for name in imported(path) if name not in sys.stdlib_module_names} - ALLOWED
        assert not outside, f"{path.name} imports {outside}"
        assert "import_module" not in path.read_text(encoding="utf-8")


def test_making_cases_loads_nothing_of_the_library():
    code = (
        "import sys; from examples.concealed.seal import build;"
        "build(('joint', 3, None, None)); build(('shape', 3, 'L0', None));"
        "sys.exit(any(name.split('.')[0] == 'coast_cli' for name in sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=PACKAGE.parents[1], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
