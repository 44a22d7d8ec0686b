"""A law without a name in a saved model: the commands take it, and say where it is used outside the range it was seen in."""

from pathlib import Path

import numpy as np
import pytest

from coast_cli.__main__ import main

CONFIG = Path(__file__).parents[2] / "configs" / "tubes.toml"
LAW = """
[corrections.unnamed_1]
stage = "structure"
variable = "curvature"
memory = "friction"
setting = 1e-4
low = 0.0
high = {high}
weights = [1.5, 0.2]
"""
SEEN = "unnamed_1 was seen for kappa from 0 to"


@pytest.fixture
def model(tmp_path):
    def write(high):
        path = tmp_path / f"model_{high:g}.toml"
        path.write_text(CONFIG.read_text(encoding="utf-8") + LAW.format(high=high), encoding="utf-8")
        return path

    return write


@pytest.fixture
def recording(tmp_path):
    stroke = np.concatenate([np.linspace(0.0, 3.0, 30), np.linspace(3.0, 0.0, 30)])
    bent = 14.3 * np.maximum(stroke - 1.2, 0.0) + 0.2 * np.random.default_rng(1).normal(size=stroke.size)
    rows = (f"a,{2.0 * i:g},20,{s:.4f},{k:.4f}\n" for i, (s, k) in enumerate(zip(stroke, bent, strict=True)))
    path = tmp_path / "recording.csv"
    path.write_text("run,time_s,bending_length_mm,stroke_mm,curvature_per_m\n" + "".join(rows), encoding="utf-8")
    return path


@pytest.fixture
def planned(tmp_path):
    path = tmp_path / "path.csv"
    path.write_text("arc_length_mm,curvature_per_m\n" + "".join(f"{s},20\n" for s in range(0, 40, 5)), encoding="utf-8")
    return path


@pytest.mark.parametrize("command", ["compare", "stroke", "path", "diagnose"])
def test_a_law_outside_the_range_it_was_seen_in_is_told_on_stderr(command, model, recording, planned, capsys):
    words = {
        "compare": [recording],
        "stroke": ["--kappa", "5,20", "--x2", "20"],
        "path": ["--path", planned],
        "diagnose": [recording, "--max-effects", "0", "--format", "json"],
    }[command]
    for high, told in ((60.0, False), (12.0, True)):
        main([command, str(model(high)), *map(str, words)])
        streams = capsys.readouterr()
        assert streams.out
        assert (f"{SEEN} {high:g} 1/m" in streams.err.replace("\n", " ")) is told


def test_a_law_moves_what_is_answered(model, capsys):
    main(["stroke", str(CONFIG), "--kappa", "20", "--x2", "20", "--format", "csv"])
    before = capsys.readouterr().out
    main(["stroke", str(model(60.0)), "--kappa", "20", "--x2", "20", "--format", "csv"])
    assert capsys.readouterr().out != before


def test_what_a_slow_pull_does_not_show_is_said(tmp_path, capsys):
    text = CONFIG.read_text(encoding="utf-8") + LAW.format(high=60.0)
    changes = {"friction": "relaxation", "1e-4": "2.0"}, {"friction": "maximum"}
    for change, words in zip(changes, ("acts with time", "takes tension by what was before"), strict=True):
        made = text
        for old, new in change.items():
            made = made.replace(f'"{old}"', f'"{new}"').replace(f"= {old}", f"= {new}")
        path = tmp_path / "model.toml"
        path.write_text(made, encoding="utf-8")
        main(["stroke", str(path), "--kappa", "20", "--x2", "20"])
        assert words in capsys.readouterr().err
