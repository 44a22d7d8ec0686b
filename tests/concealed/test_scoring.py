"""Answers are asked once, kept whole, and judged as the aims say."""

import json
import math

import pytest

from examples.concealed import runner, scorer
from examples.concealed.judge import judge
from examples.concealed.runner import requests
from examples.concealed.scorer import Rate
from examples.concealed.seal import build_all, unseal, write

LEVELS = ("L0", "LP", "L1", "L2", "L4", "L5", "L6")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("cases")
    write(out, build_all([("joint", 40 + i, level, None) for i, level in enumerate(LEVELS)], 1))
    return out


def said(verdict, *effects, alternatives=(), kind="physics"):
    return {
        "verdict": verdict,
        "effects": [{"id": name, "kind": kind, "component": "", "confidence": 0.9} for name in effects],
        "alternatives": [list(group) for group in alternatives],
        "where": [],
        "next_recording": "release sweeps at two bending lengths",
    }


def oracle(truth):
    """The answer that knows."""
    level = truth["level"]
    if level == "L6":
        return said("unexplained")
    if level in ("L0", "LP"):
        return said("agrees" if level == "L0" else "parameters")
    answer = said(truth["effects"][0]["kind"], *(effect["id"] for effect in truth["effects"]))
    answer["where"] = truth["where"]
    for effect, true in zip(answer["effects"], truth["effects"], strict=True):
        effect.update(kind=true["kind"], component=true["component"])
    return answer


def answered(out, monkeypatch, reply):
    truths, asked = unseal(out), []

    def ask(case, recordings, held_out, _model, _without):
        asked.append(case.name)
        assert all(path.exists() for path in recordings)
        return {"exit": 0, "seconds": 1.0, "held_out": held_out, "stderr": "", "diagnosis": reply(truths[case.name])}

    monkeypatch.setattr(runner, "ask", ask)
    runner.run(out, 2)
    return asked


def test_an_oracle_scores_full_marks_and_is_asked_once(made, monkeypatch):
    asked = answered(made, monkeypatch, oracle)
    assert set(asked) == set(unseal(made))
    assert answered(made, monkeypatch, oracle) == []
    scores = scorer.score(made, errors=False)
    assert scores.mean_score == 1.0
    assert scores.false_alarms.value == 0
    assert scores.named_first.value == 1
    assert scores.told_apart.value == 1
    assert "| named first, L1 | 100.0 % |" in scores.table()
    assert (made / "table.md").read_text() == scores.table()


def test_an_answer_that_always_finds_a_snap_is_punished(made, monkeypatch):
    for path in (made / "answers").glob("*.json"):
        path.unlink()
    answered(made, monkeypatch, lambda _truth: said("physics", "snap_through"))
    scores = scorer.score(made, errors=False)
    assert scores.false_alarms.value == 1
    assert scores.mean_score < -1
    assert scores.worst(3)[0].score == -2


def test_a_failed_answer_is_asked_again(made, monkeypatch):
    for path in (made / "answers").glob("*.json"):
        path.unlink()
    first = answered(made, monkeypatch, lambda truth: None if truth["level"] == "L1" else oracle(truth))
    again = answered(made, monkeypatch, oracle)
    assert len(first) > len(again) == 1


def test_an_interrupted_run_leaves_only_whole_answers(made, monkeypatch):
    for path in (made / "answers").glob("*.json"):
        path.unlink()
    count = []

    def reply(truth):
        count.append(1)
        if len(count) == 3:
            raise KeyboardInterrupt
        return oracle(truth)

    with pytest.raises(KeyboardInterrupt):
        answered(made, monkeypatch, reply)
    assert list((made / "answers").glob("*.partial")) == []
    for path in (made / "answers").glob("*.json"):
        assert json.loads(path.read_text())["diagnosis"]
    assert answered(made, monkeypatch, oracle)


def truth(level, *effects, twins=(), near=(), size=5.0, kind="physics"):
    return {
        "level": level,
        "effects": [{"id": name, "kind": kind, "component": "actuator", "noise_widths": size} for name in effects],
        "twins": list(twins),
        "near": list(near),
        "where": [{"axis": "curvature", "value": None, "low": 10.0, "high": 20.0}],
    }


@pytest.mark.parametrize(
    ("true", "answer", "points"),
    [
        (truth("L1", "backlash"), said("physics", "backlash"), 1.0),
        (truth("L1", "backlash"), said("physics", "coulomb_friction", "backlash"), 0.5),
        (truth("L1", "backlash"), said("physics", "coulomb_friction"), -2.0),
        (truth("L1", "backlash"), said("insufficient"), 0.25),
        (truth("L1", "backlash"), said("ambiguous", "coulomb_friction", alternatives=[["backlash"]]), 0.25),
        (truth("L1", "backlash"), said("ambiguous", "coulomb_friction", alternatives=[["tip_load"]]), -2.0),
        (truth("L1", "backlash"), said("agrees"), 0.0),
        (truth("L3", "backlash", size=0.6), said("agrees"), 0.25),
        (truth("L2", "backlash", twins=["coulomb_friction"]), said("physics", "coulomb_friction"), 0.5),
        (truth("L5", "camera_scale", twins=["youngs_modulus"], kind="sensor"), said("parameters"), 1.0),
        (truth("L6", "notch_crack"), said("unexplained"), 1.0),
        (truth("L6", "notch_crack", near=["snap_through"]), said("physics", "snap_through"), 0.25),
        (truth("L6", "notch_crack"), said("physics", "tip_load"), -2.0),
        (truth("L0"), said("unexplained"), -2.0),
        (truth("L0"), said("parameters"), 1.0),
        (truth("L0"), said("insufficient"), 0.25),
        (truth("LP"), said("agrees"), 0.0),
    ],
)
def test_scores_are_those_of_the_aims(true, answer, points):
    assert judge("c", true, {"diagnosis": answer, "seconds": 1}).score == points


def test_a_place_is_right_by_overlap():
    answer = said("physics", "backlash")
    answer["where"] = [{"axis": "curvature", "value": None, "low": 12.0, "high": 20.0, "share": 0.9}]
    assert judge("c", truth("L1", "backlash"), {"diagnosis": answer, "seconds": 1}).overlap == pytest.approx(0.8)
    answer["where"] = [{"axis": "time", "value": None, "low": 12.0, "high": 20.0, "share": 0.9}]
    assert judge("c", truth("L1", "backlash"), {"diagnosis": answer, "seconds": 1}).overlap == 0


def test_a_proposal_is_read_for_what_it_asks():
    assert requests("release sweeps at two bending lengths with tension recorded") == ["release", "lengths", "tension"]
    assert requests("hold the stroke for ten time constants") == ["holds", "rates"]
    assert requests("") == []


def test_wilson_intervals():
    low, high = Rate(0, 100).interval
    assert (low, high) == (pytest.approx(0.0), pytest.approx(0.0370, abs=1e-4))
    low, high = Rate(98, 100).interval
    assert (low, high) == (pytest.approx(0.9300, abs=1e-4), pytest.approx(0.9945, abs=1e-4))
    assert math.isnan(Rate(0, 0).value)
    assert Rate(0, 0).text()[0] == "-"


def test_other_answers_run_on_a_case(made):
    from examples.concealed.baselines import others

    truths = unseal(made)
    held_out = json.loads((made / "held_out.json").read_text())
    name = next(name for name in truths if truths[name]["level"] in ("L1", "L4", "L5") and held_out[name])
    found = {other.name: other for other in others(made / "cases" / name, truths[name], held_out[name])}
    assert len(found) == 5
    sigma = truths[name]["noise"]["sigma"]
    assert found["true form refitted"].noiseless < 0.5 * sigma
    assert found["true form refitted"].noiseless < found["no correction"].noiseless
