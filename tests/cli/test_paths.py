"""What is read is never written, and no file is written twice: refused before the run, by both names."""

import os
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import get_type_hints

import pytest

from coast_cli.cli.app import COMMANDS
from coast_cli.cli.paths import Reads, Writes

ROOT = Path(__file__).parents[2]
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"


@pytest.fixture
def bench(tmp_path, reference, monkeypatch):
    """A folder with every kind of input, and links that lead to them."""
    shutil.copy(reference, tmp_path / "tubes.toml")
    shutil.copy(ROOT / "examples" / "explore.toml", tmp_path / "explore.toml")
    shutil.copy(RECORDING, tmp_path / "rec.csv")
    (tmp_path / "soft.csv").symlink_to("rec.csv")
    os.link(tmp_path / "rec.csv", tmp_path / "hard.csv")
    (tmp_path / "page.html").symlink_to("rec.csv")
    (tmp_path / "picture.png").symlink_to("rec.csv")
    (tmp_path / "table.json").symlink_to("tubes.toml")
    (tmp_path / "frame.png").write_bytes(b"")
    (tmp_path / "frame.overlay.png").write_bytes(b"")
    (tmp_path / "configs").mkdir()
    shutil.copy(reference, tmp_path / "configs" / "tubes.toml")
    (tmp_path / "default.csv").symlink_to("configs/tubes.toml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


CASES = [
    ("compare tubes.toml rec.csv -o rec.csv", "-o rec.csv", "RECORDING rec.csv"),
    ("compare tubes.toml rec.csv -o soft.csv", "-o soft.csv", "RECORDING rec.csv"),
    ("compare tubes.toml rec.csv -o hard.csv", "-o hard.csv", "RECORDING rec.csv"),
    ("compare tubes.toml soft.csv -o configs/../rec.csv", "-o configs/../rec.csv", "RECORDING soft.csv"),
    ("compare tubes.toml rec.csv --plot picture.png", "--plot picture.png", "RECORDING rec.csv"),
    ("recordings rec.csv --config tubes.toml -o table.json", "-o table.json", "--config tubes.toml"),
    ("diagnose tubes.toml rec.csv --save-model tubes.toml", "--save-model tubes.toml", "CONFIG tubes.toml"),
    ("diagnose tubes.toml rec.csv --report page.html", "--report page.html", "RECORDING rec.csv"),
    ("diagnose tubes.toml rec.csv -o new.json -o ./new.json", "-o new.json", "-o new.json"),
    ("report tubes.toml rec.csv -o page.html", "-o page.html", "RECORDING rec.csv"),
    ("calibrate tubes.toml rec.csv -o tubes.toml", "-o tubes.toml", "CONFIG tubes.toml"),
    ("design tubes.toml --target stroke_mm=1 --save tubes.toml", "--save tubes.toml", "CONFIG tubes.toml"),
    ("explore explore.toml --all q.csv -o q.csv", "-o q.csv", "--all q.csv"),
    ("explore explore.toml --all rec.csv -o soft.csv", "-o soft.csv", "--all rec.csv"),
    ("rank-pairs tubes.toml -o table.json", "-o table.json", "CONFIG tubes.toml"),
    ("path tubes.toml --path rec.csv -o rec.csv", "-o rec.csv", "--path rec.csv"),
    ("plan tubes.toml --protocol rec.csv -o rec.csv", "-o rec.csv", "--protocol rec.csv"),
    ("stroke --kappa 1 --x2 20 -o default.csv", "-o default.csv", "CONFIG configs/tubes.toml"),
    (
        "trace frame.png frame.overlay.png --scale 1 --overlay .",
        "--overlay frame.overlay.png",
        "IMAGE frame.overlay.png",
    ),
    ("trace frame.png --kind joint --scale 1 --drive rec.csv -o hard.csv", "-o hard.csv", "--drive rec.csv"),
]


@pytest.mark.parametrize(("line", "written", "other"), CASES, ids=[line for line, *_ in CASES])
def test_a_file_that_would_be_lost_is_refused_by_both_names(coast, bench, line, written, other):
    before = {path.name: path.read_bytes() for path in bench.iterdir() if path.is_file()}
    ran = coast(*line.split())
    assert (ran.code, ran.out) == (3, "")
    assert f"{written} " in ran.err
    assert other in ran.err
    assert ran.err.count("\n") == 1
    assert {path.name: path.read_bytes() for path in bench.iterdir() if path.is_file()} == before


def test_stdout_appended_to_an_input_is_refused(bench):
    before = (bench / "rec.csv").read_bytes()
    with (bench / "rec.csv").open("a") as appended:
        words = [sys.executable, "-m", "coast_cli", "compare", "tubes.toml", "rec.csv", "-f", "csv"]
        path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        environment = {**os.environ, "PYTHONPATH": path}
        ran = subprocess.run(words, stdout=appended, stderr=subprocess.PIPE, text=True, env=environment, check=False)
    assert ran.returncode == 3
    assert "stdout would be written to RECORDING rec.csv" in ran.stderr
    assert (bench / "rec.csv").read_bytes() == before


def test_files_apart_are_written(coast, bench):
    ran = coast("rank-pairs", "tubes.toml", "-o", "a.csv", "-o", "a.json", "-f", "json")
    assert ran.code == 0
    assert (bench / "a.json").read_text(encoding="utf-8") == ran.out


def names_a_file(hint):
    kind, *marks = hint.__origin__, *hint.__metadata__
    metavar = next((mark.metavar or "" for mark in marks if hasattr(mark, "metavar")), "")
    return "Path" in str(kind) or "FILE" in metavar


def test_every_parameter_that_names_a_file_says_whether_it_is_read_or_written():
    silent, said = [], 0
    for name, place in COMMANDS.items():
        module, function = place.split(":")
        hints = get_type_hints(getattr(import_module(module), function), include_extras=True)
        for parameter, hint in hints.items():
            if hasattr(hint, "__metadata__") and names_a_file(hint):
                said += 1
                if not any(isinstance(mark, Reads | Writes) for mark in hint.__metadata__):
                    silent.append(f"{name} {parameter}")
    assert silent == []
    assert said > 40
