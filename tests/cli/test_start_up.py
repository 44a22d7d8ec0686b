"""Start-up stays light: told by the modules that are loaded, not by milliseconds."""

import json
import subprocess
import sys

import pytest

HEAVY = {"numpy", "scipy", "pydantic", "matplotlib", "rich", "skimage", "numba"}
PROBE = """
import json
import sys
from coast_cli.__main__ import main
code = main(sys.argv[1:])
names = {name.partition(".")[0] for name in sys.modules}
own = sorted(name for name in sys.modules if name.startswith("coast_cli."))
sys.stderr.write("\\n" + json.dumps([code, sorted(names), own]))
"""


def loaded(*words):
    command = [sys.executable, "-c", PROBE, *map(str, words)]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(ran.stderr.splitlines()[-1])


@pytest.mark.parametrize("words", [("--help",), ("--version",)])
def test_help_loads_nothing_heavy(words):
    _, modules, _ = loaded(*words)
    assert not HEAVY & set(modules)


@pytest.mark.parametrize("words", [("guide",), ("guide", "path")])
def test_the_guide_loads_nothing_heavy_and_no_other_command(words):
    code, modules, own = loaded(*words)
    assert code == 0
    assert not (HEAVY - {"pydantic"}) & set(modules)  # typer itself loads pydantic to run a command
    assert not {"coast_cli.cli.options", "coast_cli.spec", "coast_cli.effects"} & set(own)


def test_ranking_loads_neither_scipy_nor_plots_nor_other_commands(reference):
    code, modules, own = loaded("rank-pairs", reference)
    assert code == 0
    assert not {"scipy", "matplotlib", "skimage", "numba"} & set(modules)
    assert [name for name in own if name.startswith("coast_cli.cli.")] == [
        "coast_cli.cli.app",
        "coast_cli.cli.common",
        "coast_cli.cli.examples",
        "coast_cli.cli.options",
        "coast_cli.cli.paths",
        "coast_cli.cli.rank_pairs",
    ]
    others = ("coast_cli.diagnosis", "coast_cli.recordings", "coast_cli.effects")
    asked = {"coast_cli.effects", "coast_cli.effects.own"}  # whether a file of the user's own effects was given
    assert not [name for name in own if name.startswith(others) and name not in asked]
