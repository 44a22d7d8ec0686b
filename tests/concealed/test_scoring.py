"""Answers are asked once, kept whole, and judged as the aims say."""

import json
import math

import numpy as np
import pytest

from examples.concealed import runner, scorer
from examples.concealed.baselines import others
from examples.concealed.draw import LEVELS as LEVEL_SHARES
from examples.concealed.figures import TRUE_FORM, Rate, calibration_error
from examples.concealed.judge import judge
from examples.concealed.laws import BENCH, JOINT_EFFECTS, NEAR_SPAN, RECIPES
from examples.concealed.report import table
from examples.concealed.runner import requests
from examples.concealed.seal import BrokenSealError, build, key_of, open_seal, write

LEVELS = ("L0", "LP", "L1", "L2", "L4", "L5", "L6", "L8", "L9")
JOBS = [("joint", 40 + i, level, None) for i, level in enumerate(LEVELS)]


@pytest.fixture(scope="module")
def cases():
    return dict(map(build, JOBS))


@pytest.fixture
def made(cases, tmp_path):
    write(tmp_path, cases.items(), key_of(JOBS))
    return tmp_path


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
    if level in ("L6", "L8"):
        nature = truth["effects"][0]["nature"]
        law = {"stages": nature["stages"][:1], "variables": [words[0] for words in nature["variables"]]}
        return said("unnamed") | {"unnamed": law | {"memory": nature["memory"], "rate": nature["rate"]}}
    if level in ("L0", "LP"):
        return said("agrees" if level == "L0" else "parameters")
    answer = said(truth["effects"][0]["kind"], *(effect["id"] for effect in truth["effects"]))
    answer["where"] = truth["where"]
    for effect, true in zip(answer["effects"], truth["effects"], strict=True):
        effect.update(kind=true["kind"], component=true["component"])
    return answer


def answered(out, monkeypatch, cases, reply):
    asked = []

    def ask(question, recordings, _model):
        asked.append(question.case.name)
        assert all(path.exists() for path in recordings)
        assert bool(question.without) == (cases[question.case.name].truth["level"] == "L8")
        diagnosis = reply(cases[question.case.name].truth)
        return {"exit": 0, "seconds": 1.0, "held_out": [], "stderr": "", "diagnosis": diagnosis}

    monkeypatch.setattr(runner, "ask", ask)
    runner.run(out, 1)
    return asked


def scored(out):
    open_seal(out, key_of(JOBS))
    return scorer.score(out, errors=False)


def test_an_oracle_scores_full_marks_and_is_asked_once(made, cases, monkeypatch):
    asked = answered(made, monkeypatch, cases, oracle)
    assert set(asked) == set(cases)
    assert answered(made, monkeypatch, cases, oracle) == []
    scores = scored(made)
    assert scores.mean_score == 1.0
    assert scores.false_alarms.value == 0
    assert scores.named_first.value == 1
    assert scores.told_apart.value == 1
    assert [scores.fact(name).value for name in ("stage", "variable", "memory", "rate")] == [1, 1, 1, 1]
    assert "| named first, L1 | 100.0 % |" in table(scores)
    assert (made / "table.md").read_text() == table(scores)


def test_an_answer_that_always_finds_a_snap_is_punished(made, cases, monkeypatch):
    answered(made, monkeypatch, cases, lambda _truth: said("physics", "snap_through"))
    scores = scored(made)
    assert scores.false_alarms.value == 1
    assert scores.mean_score < -1
    assert scores.worst(3, "L0")[0].score == -2


def test_a_failed_answer_is_asked_again_until_the_seal_is_open(made, cases, monkeypatch):
    def failing(truth):
        return None if truth["level"] == "L1" else oracle(truth)

    first = answered(made, monkeypatch, cases, failing)
    again = answered(made, monkeypatch, cases, failing)
    assert len(first) > len(again) == 1
    assert scored(made).unanswered == 1
    with pytest.raises(BrokenSealError, match="has seen the truths"):
        answered(made, monkeypatch, cases, oracle)


def test_an_interrupted_run_leaves_only_whole_answers(made, cases, monkeypatch):
    count = []

    def reply(truth):
        count.append(1)
        if len(count) == 3:
            raise KeyboardInterrupt
        return oracle(truth)

    with pytest.raises(KeyboardInterrupt):
        answered(made, monkeypatch, cases, reply)
    assert list((made / "answers").glob("*.partial")) == []
    for path in (made / "answers").glob("*.json"):
        assert json.loads(path.read_text())["diagnosis"]
    assert answered(made, monkeypatch, cases, oracle)


def test_what_the_catalogue_does_not_hold_is_not_concealed_from_it(tmp_path, monkeypatch):
    asked = []

    def coast(*words, **_root):
        asked.append(words[words.index("--without") + 1] if "--without" in words else "")
        known = "newer" not in asked[-1]
        return (0, json.dumps(said("agrees")), "") if known else (3, "", "no such effect to leave out; found 'newer'.")

    monkeypatch.setattr(runner, "coast", coast)
    question = runner.Question(tmp_path, tmp_path / "case", without=("backlash", "newer"))
    found = runner.ask(question, [], None)
    assert asked == ["backlash,newer", "backlash"]
    assert found["without"] == ["backlash"]
    assert found["diagnosis"]["verdict"] == "agrees"


def test_answers_of_another_kind_stand_beside_ours_by_the_same_rules(made, cases, monkeypatch):
    answered(made, monkeypatch, cases, oracle)
    monkeypatch.setattr(
        runner, "ask", lambda question, _r, _m: {"diagnosis": said("agrees"), "seconds": 1.0, "why": question.further}
    )
    runner.run(made, 1, further=("--max-effects", "1"), label="named-only")
    scores = scored(made)
    assert [j.verdict for j in scores.others["named-only"]] == ["agrees"] * len(cases)
    assert "| named-only | 9 |" in table(scores)


def test_names_alone_are_an_answer_of_their_own(made, cases, monkeypatch):
    def reply(truth):
        answer = oracle(truth)
        if answer.get("unnamed"):
            answer["unnamed"]["nearest"] = [{"id": "tendon_creep", "left_over": 0.4}]
        return answer

    answered(made, monkeypatch, cases, reply)
    scores = scored(made)
    alone = scores.others[scorer.NAMES_ALONE]
    assert scores.mean_score == 1.0
    assert [j.score for j in alone if j.level in ("L6", "L8")] == [-2.0, -2.0]
    assert all(j.score == 1.0 for j in alone if j.level not in ("L6", "L8"))


def truth(level, *effects, twins=(), size=5.0, kind="physics", base=None):
    return {
        "level": level,
        "effects": [
            {"id": name, "law": name, "kind": kind, "component": "actuator", "noise_widths": size}
            | ({"nature": vars(RECIPES[name].nature)} if name in RECIPES else {})
            for name in effects
        ],
        "twins": list(twins),
        "where": [{"axis": "curvature", "value": None, "low": 10.0, "high": 20.0}],
        "noise": {"kind": "white", "sigma": 0.1},
        "base_held_out": base,
    }


def law(stage="structure", variable="curvature", memory=True, rate=True):
    stages, variables = ([words] if isinstance(words, str) else list(words) for words in (stage, variable))
    given = {"stages": stages, "variables": variables, "memory": memory, "rate": rate}
    return said("unnamed") | {"unnamed": given}


@pytest.mark.parametrize(
    ("true", "answer", "points"),
    [
        (truth("L1", "backlash"), said("physics", "backlash"), 1.0),
        (truth("L1", "backlash"), said("physics", "coulomb_friction", "backlash"), 0.5),
        (truth("L1", "backlash"), said("physics", "coulomb_friction"), -2.0),
        (truth("L1", "backlash"), said("insufficient"), 0.25),
        (truth("L1", "backlash"), said("ambiguous", "coulomb_friction", alternatives=[["backlash"]]), 0.25),
        (truth("L1", "backlash"), said("ambiguous", "coulomb_friction", alternatives=[["tip_load"]]), -2.0),
        (truth("L1", "backlash"), said("agrees"), -1.0),
        (truth("L1", "backlash", size=1.6), said("agrees"), 0.0),
        (truth("L3", "backlash", size=0.6), said("agrees"), 0.25),
        (truth("L2", "backlash", twins=["coulomb_friction"]), said("physics", "coulomb_friction"), 0.5),
        (truth("L5", "camera_scale", twins=["youngs_modulus"], kind="sensor"), said("parameters"), 1.0),
        (truth("L6", "notch_crack"), said("unexplained"), 1.0),
        (truth("L6", "notch_crack"), said("physics", "tip_load"), -2.0),
        (truth("L6", "jacket_relaxation"), law(), 1.0),
        (truth("L6", "jacket_relaxation"), law(rate=False), 0.5),
        (truth("L6", "jacket_relaxation"), law(stage=("structure", "drive")), 1.0),
        (truth("L6", "jacket_relaxation"), law(stage=("structure", "drive", "tendon")), 0.0),
        (truth("L6", "jacket_relaxation"), law(variable=("time", "bend", "curvature", "path")), 1.0),
        (truth("L6", "cable_speed_stiffening"), law("tendon", "rate", False, True), 0.5),
        (truth("L6", "cable_speed_stiffening"), law("tendon", ("rate", "tension"), False, True), 1.0),
        (truth("L6", "jacket_relaxation"), law(stage="sensor"), 0.0),
        (truth("L6", "jacket_relaxation"), said("ambiguous", "tendon_creep"), -2.0),
        (truth("L6", "jacket_relaxation"), said("insufficient"), 0.25),
        (truth("L8", "backlash"), said("physics", "coulomb_friction"), -2.0),
        (truth("L8", "backlash"), law("drive", "stroke", True, False), 1.0),
        (truth("L9", "camera_saturation", kind="sensor"), said("sensor", "camera_saturation"), 1.0),
        (truth("L9", "doubled_rows", size=0.0), said("agrees"), 1.0),
        (truth("L9", "doubled_rows", size=0.0), said("sensor", "frozen_frames"), -2.0),
        (truth("L1", "backlash"), law(), 0.25),
        (
            truth("L1", "notch_depth_error", kind="parameter"),
            said("parameters", "notch_depth_error", kind="parameter"),
            1.0,
        ),
        (truth("L0"), law(), -2.0),
        (truth("L0"), said("unexplained"), -2.0),
        (truth("L0"), said("parameters"), 1.0),
        (truth("L0"), said("insufficient"), 0.25),
        (truth("LP"), said("agrees"), 0.0),
    ],
)
def test_scores_are_those_of_the_aims(true, answer, points):
    assert judge("c", true, {"diagnosis": answer, "seconds": 1}).score == points


def placed(*places):
    return said("physics", "backlash") | {
        "where": [{"axis": axis, "value": None, "low": low, "high": 20.0, "share": 0.9} for axis, low in places]
    }


def overlap(true, answer):
    return judge("c", true, {"diagnosis": answer, "seconds": 1}).overlap


def test_the_first_place_counts_by_its_overlap():
    true = truth("L1", "backlash")
    assert overlap(true, placed(("curvature", 12.0))) == pytest.approx(0.8)
    assert overlap(true, placed(("time", 12.0))) == 0
    assert overlap(true, placed(("time", 12.0), ("curvature", 12.0))) == 0
    # The wrong name may stand at the right place.
    assert overlap(truth("L1", "coulomb_friction"), placed(("curvature", 10.0))) == 1
    true["where"] = [{"axis": "stroke", "value": None, "low": None, "high": None}]
    assert overlap(true, placed(("stroke", 12.0))) is None


def test_the_component_counts_where_the_name_is_wrong_too():
    answer = said("physics", "leadscrew_pitch_error")
    answer["effects"][0]["component"] = "actuator"
    found = judge("c", truth("L1", "backlash"), {"diagnosis": answer})
    assert found.wrong
    assert found.component


def test_agreement_above_two_noise_widths_on_unseen_rows_is_blind():
    true = truth("L9", "camera_saturation", kind="sensor")
    answer = {"diagnosis": said("agrees")}
    assert judge("c", true, answer, {"recorded": 0.3, "noiseless": 0.28}).blind
    assert not judge("c", true, answer, {"recorded": 0.15, "noiseless": 0.1}).blind
    assert judge("c", true, answer).blind is None


def test_of_a_bench_fault_the_run_is_part_of_the_answer():
    true = truth("L9", "run_differs_gain", kind="sensor")
    true["effects"][0] |= {"id": "run_differs", "run": "r2"}
    answer = said("sensor", "run_differs")
    for run in ("r2", "r1"):
        answer["where"] = [{"axis": "run", "value": run, "low": None, "high": None, "share": 0.9}]
        assert judge("c", true, {"diagnosis": answer}).bench_right == (run == "r2")


def test_stated_probabilities_are_held_against_what_came_true():
    answer = said("physics", "backlash") | {
        "probabilities": {"backlash": 0.9, "snap_through": 0.04, "something_else": 0.06}
    }
    assert judge("c", truth("L1", "backlash"), {"diagnosis": answer}).beliefs == (
        (0.9, True),
        (0.04, False),
        (0.06, False),
    )
    found = judge("c", truth("L8", "backlash"), {"diagnosis": answer})
    assert found.beliefs == ((0.9, False), (0.04, False), (0.06, True))
    assert calibration_error([found]) == pytest.approx((0.9 + 2 * abs(0.05 - 0.5)) / 3)
    # An answer without probabilities stands by the confidence of its first name.
    assert judge("c", truth("L1", "backlash"), {"diagnosis": said("physics", "backlash")}).beliefs == ((0.9, True),)


def many(count=400):
    """Truths in the shares of the levels, without their recordings."""
    rng = np.random.default_rng(3)
    for level in rng.choice(list(LEVEL_SHARES), count, p=list(LEVEL_SHARES.values())):
        names = {"L6": list(NEAR_SPAN), "L9": [name for name in BENCH if name != "doubled_rows"]}.get(
            level, list(JOINT_EFFECTS)
        )
        chosen = (
            []
            if level in ("L0", "LP")
            else [str(name) for name in rng.choice(names, 2 if level == "L4" else 1, replace=False)]
        )
        size = {"L2": 0.3, "L3": 1.5}.get(level, 8.0)
        kind = RECIPES[chosen[0]].kind if chosen else ""
        yield truth(str(level), *chosen, size=size, kind=kind, base=0.1 * size)


def nearest(true):
    """The right name where there is one, and some name everywhere."""
    named = true["effects"] and true["level"] not in ("L6", "L8")
    return said("physics", true["effects"][0]["id"] if named else "thermal_drift")


EVERYTHING = list(JOINT_EFFECTS)
# Each cheat: what it says, and the error of its model on unseen rows over the base model's.
CHEATS = {
    "names everything": (lambda _true: said("physics", *EVERYTHING), 1.0),
    "groups everything": (lambda _true: said("ambiguous", *EVERYTHING[:1], alternatives=[EVERYTHING]), 1.0),
    "names nothing": (lambda _true: said("agrees"), 1.0),
    "nearest name always": (nearest, 1.0),
    "copies the base": (lambda true: oracle(true) if true["level"] in ("L6", "L8") else law(), 1.0),
    "overfits the training rows": (lambda true: oracle(true) if true["level"] in ("L6", "L8") else law(), 4.0),
}


def mean(reply, ratio):
    judged = []
    for true in many():
        figures = {"noiseless": ratio * (true["base_held_out"] or 0), "recorded": 0.1}
        judged.append(judge("c", true, {"diagnosis": reply(true)}, figures).score)
    return float(np.mean(judged))


@pytest.mark.parametrize("name", CHEATS)
def test_a_cheat_ranks_below_honest_abstention(name):
    abstains = mean(lambda _true: said("insufficient"), 1.0)
    assert abstains == pytest.approx(0.25)
    assert mean(*CHEATS[name]) < abstains - 0.05
    assert mean(oracle, 0.1) > 0.9


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


def test_other_answers_run_on_a_case(made, cases):
    name = next(name for name, case in cases.items() if case.truth["level"] in ("L1", "L4", "L5") and case.held_out)
    true = json.loads(
        json.dumps(cases[name].truth, default=lambda value: getattr(value, "item", lambda: list(value))())
    )
    found = others(made / "cases" / name, true, list(cases[name].held_out))
    assert len(found) == 5
    best, none = (found[key]["figures"]["noiseless"] for key in (TRUE_FORM, "no correction"))
    assert best < 0.5 * true["noise"]["sigma"]
    assert best < none
    judged = {key: judge(name, true, answer, answer["figures"]) for key, answer in found.items()}
    assert judged[TRUE_FORM].score == 1
    assert judged["no correction"].score < 0
