"""What users copy into their own CI runs as it stands: the workflow's steps and the hooks' entries, in a repository.

The repository's own workflow and hooks name what is here.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WORKFLOW = (ROOT / "examples" / "ci" / "designs.yml").read_text(encoding="utf-8")
HOOKS = (ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8")
STEPS = re.findall(r"^ +- run: (.+)$", WORKFLOW, re.MULTILINE)
ENTRIES = dict(re.findall(r"^- id: (\S+)\n(?: .*\n)*?  entry: (.+)$", HOOKS, re.MULTILINE))


@pytest.fixture
def repository(tmp_path, reference):
    """A repository with one design, and a shell in it that finds `coast`; pip only says what it was asked for."""
    (tmp_path / "configs").mkdir()
    shutil.copy(reference, tmp_path / "configs" / "tubes.toml")
    programs = tmp_path / "programs"
    programs.mkdir()
    for name, line in (("coast", f'{sys.executable} -m coast_cli "$@"'), ("python", 'echo "python $@"')):
        (programs / name).write_text(f"#!/bin/sh\n{line}\n", encoding="utf-8")
        (programs / name).chmod(0o755)
    there = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT), "COAST": "coast-cli"}

    def run(line):
        return subprocess.run(
            ["bash", "-ec", line], cwd=tmp_path, env=there, capture_output=True, text=True, check=False
        )

    return tmp_path, run


def test_every_step_of_the_workflow_is_tried():
    assert len(STEPS) == WORKFLOW.count("run:") == 3
    assert "\t" not in WORKFLOW
    assert set(re.findall(r"uses: (\S+)@v\d+$", WORKFLOW, re.MULTILINE)) == {
        "actions/checkout",
        "actions/setup-python",
        "actions/upload-artifact",
    }


def test_the_workflow_passes_a_good_design(repository):
    folder, run = repository
    ran = [run(step) for step in STEPS]
    assert [one.returncode for one in ran] == [0, 0, 0], ran
    assert ran[0].stdout == "python -m pip install coast-cli\n"
    assert ran[2].stdout == "::notice title=coast check::5 limits hold\n"
    assert 'failures="0"' in (folder / "checks.xml").read_text(encoding="utf-8")


def test_the_workflow_fails_a_bad_design_at_its_line_and_keeps_the_report(repository):
    folder, run = repository
    config = folder / "configs" / "tubes.toml"
    config.write_text(config.read_text(encoding="utf-8").replace("value = 6.0", "value = 4.0"), encoding="utf-8")
    assert run(STEPS[1]).returncode == 0
    ran = run(STEPS[2])
    assert ran.returncode == 1
    assert ran.stdout.startswith("::error file=configs/tubes.toml,line=84,title=coast check::")
    assert '<failure message="OT4/MT1: max_stroke_mm' in (folder / "checks.xml").read_text(encoding="utf-8")
    config.write_text("version = 1\n[outre]\n", encoding="utf-8")
    assert run(STEPS[1]).returncode == 3


@pytest.mark.parametrize("hook", ["coast-validate", "coast-check"])
def test_each_hook_passes_good_files_and_stops_bad_ones(repository, hook):
    folder, run = repository
    files = "configs/tubes.toml"
    assert set(ENTRIES) == {"coast-validate", "coast-check"}
    assert run(f"{ENTRIES[hook]} {shlex.quote(files)}").returncode == 0
    config = folder / files
    old, new, code = {
        "coast-validate": ("depth_mm = 0.314", "depth_mm = 3.14", 3),
        "coast-check": ("max_tendon_strain = 0.012", "max_tendon_strain = 0.008", 1),
    }[hook]
    config.write_text(config.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    assert run(f"{ENTRIES[hook]} {shlex.quote(files)}").returncode == code


def test_hooks_see_configurations_only():
    for pattern in re.findall(r"^  files: (.+)$", HOOKS, re.MULTILINE):
        assert re.search(pattern, "configs/tubes.toml")
        assert not re.search(pattern, "pyproject.toml")


def test_the_own_workflow_runs_everything_and_both_ends_of_the_dependencies():
    text = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    steps = re.findall(r"- run: (.+)$", text, re.MULTILINE)
    assert steps[0] == ".ci/run"
    assert os.access(ROOT / steps[0], os.X_OK)
    assert set(re.findall(r"versions: (\w+) }", text)) == {"lowest", "newest"}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f">={re.findall(r'python: .([0-9.]+).,', text)[0]}" == project["requires-python"]
    pinned = constraints("lowest")
    for name in map(re.compile(r"[\w-]+").match, project["dependencies"]):
        assert f"{name[0]}==" in pinned
    assert "numba==" in pinned
    assert constraints("newest") == ""


def constraints(versions):
    command = [sys.executable, str(ROOT / ".ci" / "constraints.py"), versions]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_the_own_hooks_call_what_ci_calls():
    text = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    entries = re.findall(r"entry: ([^,]+),", text)
    assert len(entries) == text.count("- { id:") == 6
    called = re.findall(r"^\.venv/bin/(.+)$", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)
    for program in ("ruff check", "ruff format --check", "mypy", "lint-imports"):
        assert any(line.startswith(program) for line in called)
        assert any(entry.startswith(program) for entry in entries)
    for hook in ENTRIES.values():
        assert hook in entries
