"""Deciding numbers are set on tuning seeds, in copies of the package, and the best of each is written."""

import json

import pytest

from coast_cli.diagnosis import thresholds
from examples.concealed import tune
from examples.concealed.tune import Trial, best, line_of, put, with_value

MODULE = "from typing import Final\n\n# nats\nSURE: Final[float] = 0.95  # share\nSURE_OF_ALL = 3\n"


def test_one_number_is_replaced_and_the_rest_of_the_line_stays():
    assert with_value("SURE", 0.9, MODULE) == MODULE.replace("0.95", "0.9")
    assert with_value("SURE_OF_ALL", 4, MODULE) == MODULE.replace("= 3", "= 4")
    with pytest.raises(ValueError, match="no line 'SUR = NUMBER'"):
        with_value("SUR", 1.0, MODULE)


def test_every_threshold_of_the_diagnosis_is_found_and_can_be_moved():
    text = (tune.ROOT / tune.THRESHOLDS).read_text(encoding="utf-8")
    found = {name: value for name, value in vars(thresholds).items() if isinstance(value, thresholds.Threshold)}
    assert len(found) > 20
    for name, value in found.items():
        assert float(line_of(name, text)[2]) == value
        assert float(line_of(name, with_value(name, 0.125, text))[2]) == 0.125


def test_what_stands_wins_ties_and_the_best_is_written(tmp_path):
    trials = [
        Trial("SURE", 0.95, 0.5),
        Trial("SURE", 0.9, 0.5),
        Trial("SURE_OF_ALL", 3, 0.5),
        Trial("SURE_OF_ALL", 4, 0.6),
    ]
    assert {name: trial.value for name, trial in best(trials).items()} == {"SURE": 0.95, "SURE_OF_ALL": 4}
    (tmp_path / "m.py").write_text(MODULE)
    put(trials, tmp_path / "m.py", tmp_path)
    assert (tmp_path / "m.py").read_text() == MODULE.replace("= 3", "= 4")


def test_seeds_that_are_scored_are_refused(tmp_path):
    with pytest.raises(ValueError, match="below 30000"):
        tune.tune(tmp_path, range(29_999, 30_001), {"SURE": [0.9]}, 1)


def test_each_value_is_tried_in_a_copy_of_the_package(tmp_path, monkeypatch):
    root, out = tmp_path / "root", tmp_path / "out"
    (root / "coast_cli" / "diagnosis").mkdir(parents=True)
    (root / tune.THRESHOLDS).write_text("SURE = 1\n")

    def answer(question):
        # The higher number calls everything a snap.
        value = (question.root / tune.THRESHOLDS).read_text()
        words = (
            {"verdict": "agrees"}
            if value == "SURE = 1\n"
            else {"verdict": "physics", "effects": [{"id": "snap_through"}]}
        )
        question.target.write_text(json.dumps({"diagnosis": words, "seconds": 1.0}))

    monkeypatch.setattr(tune, "answer", answer)
    trials = tune.tune(out, range(1), {"SURE": [2.0]}, 1, root=root)
    assert [(trial.value, trial.score) for trial in trials] == [(1.0, 1.0), (2.0, -2.0)]
    assert (root / tune.THRESHOLDS).read_text() == "SURE = 1\n"
