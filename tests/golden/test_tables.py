"""The tables that people read, to the character; ``python tests/golden/test_tables.py`` writes them anew."""

import sys
from pathlib import Path

import pytest

from coast_cli.__main__ import main

GOLDEN = Path(__file__).parent
ROOT = GOLDEN.parents[1]
CONFIG = "configs/tubes.toml"
TABLES = {
    "rank-pairs": ("rank-pairs", CONFIG),
    "rank-pairs-series": ("rank-pairs", CONFIG, "--rigidity", "series", "--section", "chord"),
    "rank-pairs-coupled": ("rank-pairs", CONFIG, "--assembly", "coupled"),
    "stroke": ("stroke", CONFIG, "--kappa", "0:40:10", "--x2", "20,40"),
    "beam": ("beam", CONFIG, "--tube", "OT3", "--tube", "MT3", "--points", "6"),
    "check": ("check", CONFIG),
    "check-junit": ("check", CONFIG, "--format", "junit"),
    "explain": ("explain", "backlash"),
}


@pytest.mark.parametrize("name", TABLES)
def test_table(coast, monkeypatch, name):
    monkeypatch.chdir(ROOT)
    assert coast(*TABLES[name]).out == (GOLDEN / f"{name}.txt").read_text(encoding="utf-8")


if __name__ == "__main__":
    for name, words in TABLES.items():
        with (GOLDEN / f"{name}.txt").open("w", encoding="utf-8") as sys.stdout:
            main(words)
