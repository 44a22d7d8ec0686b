"""Fixtures that every test may use: run a command line in this process, the reference input, recordings of others."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import settings

from coast_cli.__main__ import main

ROOT = Path(__file__).parents[1]
REFERENCE = ROOT / "configs" / "tubes.toml"

# The same examples on every machine, however slow it is; `--hypothesis-profile search` looks for others.
settings.register_profile("same", derandomize=True, deadline=None)
settings.register_profile("search", max_examples=2000, deadline=None)
settings.load_profile("same")
for name in ("COLUMNS", "FORCE_COLOR", "PY_COLORS", "TTY_COMPATIBLE", "TTY_INTERACTIVE"):
    os.environ.pop(name, None)  # what tests compare is plain and as wide as it comes, whatever started them


@dataclass(frozen=True)
class Ran:
    """What a command line did."""

    code: int
    out: str
    err: str


@pytest.fixture(autouse=True)
def _no_line_a_minute(monkeypatch):
    """A busy machine may take minutes for a command; what it says meanwhile is tested on its own."""
    monkeypatch.setattr("coast_cli.output.progress._SECONDS", 1e6)


@pytest.fixture
def coast(capsys) -> Callable[..., Ran]:
    """Run ``coast`` with the given words and return its exit code, stdout and stderr."""

    def run(*words: object) -> Ran:
        capsys.readouterr()
        code = main([str(word) for word in words])
        out, err = capsys.readouterr()
        return Ran(code, out, err)

    return run


@pytest.fixture
def reference() -> Path:
    """Path of the reference input."""
    return REFERENCE


@pytest.fixture
def reference_text() -> str:
    """Text of the reference input."""
    return REFERENCE.read_text(encoding="utf-8")


@pytest.fixture
def edited(tmp_path, reference_text) -> Callable[..., Path]:
    """Write the reference input with texts replaced, each of which must occur, and return its path."""

    def write(*changes: tuple[str, str], name: str = "tubes.toml") -> Path:
        text = reference_text
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new, 1)
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def shared() -> Path:
    """Folder of recordings made by others, which stand beside the checkout and never in it."""
    folder = ROOT.parent / "shared" / "recordings"
    if not folder.is_dir():
        pytest.skip("not here: ../shared/recordings")
    return folder
