"""Every number that can change a verdict stands in one place, with unit, meaning and how it was set."""

import ast
from pathlib import Path

import pytest

import coast_cli.diagnosis
from coast_cli.diagnosis import thresholds
from coast_cli.diagnosis.thresholds import ALL, Threshold, thresholds_digest

ROOT = Path(coast_cli.diagnosis.__file__).parent
DECIDING = [
    "contest",
    "judge",
    "locate",
    "holdout",
    "together",
    "spread",
    "compare",
    "model_file",
    "recorded",
    "joint/case",
    "joint/openworld",
    "../recordings/evidence",
    *(f"joint/{name}" for name in ("axes", "build", "candidates", "errors", "holdout", "judge", "outliers", "problem")),
    "joint/structure",
    "joint/words",
    *(
        f"shapes/{name}"
        for name in ("build", "errors", "holdout", "judge", "leftover", "problem", "stretches", "words")
    ),
]
# How far is searched, how finely, and what keeps numbers finite: they cost time, and decide nothing.
EFFORT = {
    "_GROWN_FROM",
    "_ALWAYS_FINISHED",
    "_DIGITS",
    "_UNSEEN",
    "_MOST_CHANGES",
    "_BINS",
    "_MOST_VALUES",
    "_RIDGE",
    "_FLAT",
    "_WIDE",
    "_TRIVIAL",
    "_MOST_SAMPLES",
    "_WIDTHS",
    "_SMOOTHED",
    "_REFINED",
    "_FINER",
    "_LOOSENED",
    "_REMEMBERED",
    "_REACH",
    "_MODULUS_RANGE",
}


def has_number(node):
    return any(
        isinstance(part, ast.Constant) and isinstance(part.value, int | float) and not isinstance(part.value, bool)
        for part in ast.walk(node)
    )


@pytest.mark.parametrize("module", DECIDING)
def test_no_deciding_number_stands_elsewhere(module):
    for node in ast.parse((ROOT / f"{module}.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and has_number(node.value):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = {part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)}
            assert names <= EFFORT | {"_EFFORT", "EFFORT", "_INCIDENTAL"}, f"{module}: {sorted(names)}"


def test_each_has_a_unit_a_meaning_and_how_it_was_set():
    assert len(ALL) > 50
    for name, value in ALL.items():
        assert name.isupper()
        assert value.meaning, name
        assert value.set_by, name
        assert isinstance(value.unit, str), name


def test_a_threshold_is_a_number():
    assert 2.0 * Threshold(1.5, "nats", "x", "y") == 3.0
    assert thresholds.EFFECT_NATS == 7.0


def test_the_digest_tells_sets_of_thresholds_apart(monkeypatch):
    before = thresholds_digest()
    assert before == thresholds_digest()
    monkeypatch.setitem(ALL, "EFFECT_NATS", Threshold(8.0, "nats", "x", "y"))
    assert thresholds_digest() != before
