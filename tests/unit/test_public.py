"""The Python interface: light to import, complete, typed, and the same functions that the commands call."""

import ast
import os
import subprocess
import sys
from importlib import resources
from pathlib import Path

import pytest

import coast_cli

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "7_from_python.py"
PUBLIC = sorted(set(dir(coast_cli)) - {"__version__"})


def test_importing_it_loads_nothing_heavy():
    probe = "import sys, coast_cli; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    ran = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True, cwd=ROOT)
    assert not {"numpy", "scipy", "pydantic", "typer", "rich", "matplotlib"} & set(ran.stdout.split())


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_there_and_documented(name):
    found = getattr(coast_cli, name)
    assert isinstance(found, Path) or (found.__doc__ and found.__module__.startswith("coast_cli."))


def test_what_type_checkers_see_is_what_there_is():
    tree = ast.parse(Path(coast_cli.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {(alias.asname, node.module) for node in block.body for alias in node.names}
    assert seen == set(coast_cli._HOME.items())


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'rnak'"):
        coast_cli.rnak  # noqa: B018


SCRIPT = """
from pathlib import Path
from typing import Any

import coast_cli as coast
import numpy as np

config = coast.load_config(Path("tubes.toml"))
table = {"stroke_mm": np.linspace(0.0, 4.0, 40), "curvature_per_m": [1.0] * 40, "run": ["a"] * 40, "bending_length_mm": 30}
recordings = coast.read_recordings([table, "more.csv", Path("last.csv")], config, columns={"time_s": "t"}, pair="OT4/MT1")
found: coast.RecordedDiagnosis = coast.diagnose(config, recordings, hold_out=["a"], max_effects=2, noise=0.2)
largest: float = max(float(values.max()) for values in found.predict(recordings).values())
found.predict({"stroke_mm": [1.0, 2.0], "bending_length_mm": 30.0})
Path("model.toml").write_text(found.model_text())
found.plot("found.svg").render("png")
coast.calibrate(config, recordings, ["deadband_mm"], fixed={"notch_friction": 1.0}, weights={"a": 2.0}).to_dataframe()
coast.plan(found.model(), coast.sweep(config, (0.9e-3, 2.8e-3), [0.02]), noise=0.2).to_dataframe()
coast.explore(config).plot().figure()
coast.report(config, "report.html", recordings, pair="OT4/MT1", samples=0)
rows: list[dict[str, Any]] = coast.check_design(coast.build(config), "OT4/MT1")
coast.tolerance_rows(coast.build(config), "OT4/MT1", samples=10, seed=0)
"""


def test_a_users_script_passes_the_strictest_types(tmp_path):
    """The example, a script of the whole interface, and every name; the package is seen as installed, by its py.typed."""
    assert resources.files("coast_cli").joinpath("py.typed").is_file()
    every = tmp_path / "every.py"
    every.write_text("import coast_cli\n" + "".join(f"print(coast_cli.{name})\n" for name in PUBLIC), encoding="utf-8")
    whole = tmp_path / "whole.py"
    whole.write_text(SCRIPT, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--follow-imports=silent"]
    files = [f"--cache-dir={tmp_path / 'cache'}", str(EXAMPLE), str(every), str(whole)]
    there = {**os.environ, "MYPYPATH": str(ROOT)}
    ran = subprocess.run([*command, *files], capture_output=True, text=True, check=False, cwd=tmp_path, env=there)
    assert ran.returncode == 0, ran.stdout + ran.stderr
