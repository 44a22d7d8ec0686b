"""Every page shows real output: each ``console`` block is run and compared; run as a script, it writes them anew.

The blocks of the README and of the guide stand alone, those of the walk through the examples follow one another. The
guide's Python runs, and the README gives the CI its test command, word for word. Tables are those of a terminal of 100
columns.
"""

import doctest
import os
import re
import shlex
import subprocess
import sys
import tomllib
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from coast_cli.__main__ import main
from coast_cli.cli.app import COMMANDS
from coast_cli.cli.guide import PAGES

ROOT = Path(__file__).parents[2]
README, WALK = ROOT / "README.md", ROOT / "examples" / "README.md"
GUIDE = sorted(PAGES.glob("*.md"))
WIDTH = "100"
BLOCK = re.compile(
    r"(?<=^```console\n)\$ (?P<program>coast|python) (?P<words>.*)\n(?P<shown>(?:.*\n)*?)(?=^```$)", re.MULTILINE
)


def blocks(page):
    found = BLOCK.finditer(page.read_text(encoding="utf-8"))
    return [(match["program"], match["words"], match["shown"]) for match in found]


def enter(folder):
    """Make a folder the top of the checkout, as far as the pages name it, where files may be written."""
    for name in ("configs", "examples", "tests"):
        (folder / name).symlink_to(ROOT / name)
    os.chdir(folder)
    os.environ["COLUMNS"] = WIDTH


def printed(program, words):
    if program == "python":
        there = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
        command = [sys.executable, *shlex.split(words)]
        return subprocess.run(command, capture_output=True, encoding="utf-8", check=True, env=there).stdout
    stdout, sys.stdout = sys.stdout, StringIO()
    try:
        main(shlex.split(words))
        return sys.stdout.getvalue()
    finally:
        sys.stdout = stdout


@pytest.fixture
def top(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", WIDTH)
    enter(tmp_path)


def shown_by_command():
    """Each command that the README or the guide shows, with what every page shows of it."""
    found = {}
    for page in (README, *GUIDE):
        for program, words, shown in blocks(page):
            found.setdefault((program, words), []).append((page.name, shown))
    return found


@pytest.mark.parametrize(("command", "pages"), shown_by_command().items(), ids=[key[1] for key in shown_by_command()])
@pytest.mark.usefixtures("top")
def test_the_output_shown_is_what_the_command_prints(command, pages):
    text = printed(*command)
    for _, shown in pages:
        assert text == shown


@pytest.mark.usefixtures("top")
def test_the_walk_goes_from_step_to_step():
    steps = re.findall(r"^## (\d)\. ", WALK.read_text(encoding="utf-8"), re.MULTILINE)
    assert steps == [str(number) for number in range(1, len(steps) + 1)]
    assert len(blocks(WALK)) >= len(steps)
    for program, words, shown in blocks(WALK):
        assert printed(program, words) == shown, words


@pytest.mark.usefixtures("top")
def test_the_python_of_the_guide_does_what_it_shows():
    page = PAGES / "python.md"
    found = re.findall(r"^```pycon\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    examples = doctest.DocTestParser().get_doctest("".join(found), {}, page.stem, str(page), 0)
    assert len(examples.examples) >= 5
    assert doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(examples).failed == 0


def test_links_of_the_pages_lead_somewhere():
    for page in (README, WALK, *GUIDE, *(ROOT / ".github").glob("*.md")):
        for link in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), (page.name, link)


def test_the_figure_of_the_layers_is_what_import_linter_keeps():
    figure = (ROOT / ".github" / "ARCHITECTURE.md").read_text(encoding="utf-8")
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    layers = [re.findall(r"[a-z]+", layer) for layer in linter["contracts"][0]["layers"]]
    assert re.findall(r'^    (\w+)\["', figure, re.MULTILINE) == [
        name for layer in layers for name in layer if name not in {"errors", "signals", "rows", "version"}
    ]
    height = {name: place for place, layer in enumerate(layers) for name in layer}
    arrows = re.findall(r"^    (\w+) --> (\w+)$", figure, re.MULTILINE)
    assert {below for _, below in arrows} == set(height) - {"main", "errors", "signals", "rows", "version"}
    assert all(height[above] + 1 == height[below] for above, below in arrows)


def test_there_are_outputs_to_compare():
    assert len(blocks(README)) == 2
    assert len(shown_by_command()) >= 10


def test_the_readme_is_short_and_leads_to_everything():
    text = README.read_text(encoding="utf-8")
    assert len(text.encode()) <= 12 * 1024
    listed = re.findall(r"`coast ([\w-]+)`", text[text.index("## Commands") : text.index("More pages")])
    assert sorted(listed) == sorted(COMMANDS)
    assert {f"coast_cli/guide/{page.name}" for page in GUIDE} <= set(re.findall(r"\]\(([^)]+)\)", text))


@pytest.mark.parametrize(("page", "heading"), [("trust", "| figure |"), ("formats", "| code |")])
def test_the_tables_of_the_readme_are_those_of_the_guide(page, heading):
    def rows(path):
        text = path.read_text(encoding="utf-8")
        return text[text.index(heading) :].partition("\n\n")[0].splitlines()

    shown = rows(README)
    assert len(shown) > 5
    assert [row for row in rows(PAGES / f"{page}.md") if row in shown] == shown


def test_the_ci_calls_the_test_command_of_the_readme():
    commands = re.findall(r"^```sh\n(.*)\n```$", README.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(commands) == 2
    assert "coast rank-pairs configs/tubes.toml" in commands[0]
    assert commands[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()


if __name__ == "__main__":
    for place in (README, WALK, *GUIDE):
        with TemporaryDirectory() as scratch:
            enter(Path(scratch))
            text = BLOCK.sub(
                lambda match: f"$ {match['program']} {match['words']}\n{printed(match['program'], match['words'])}",
                place.read_text(encoding="utf-8"),
            )
            os.chdir(ROOT)
        place.write_text(text, encoding="utf-8")
