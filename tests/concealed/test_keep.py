"""Answers are kept whole, figures are printed from them, and what is printed says of which code it is."""

import dataclasses
import hashlib
import json
import math
import subprocess
import sys

import pytest

from examples.concealed import keep
from examples.concealed.figures import Scores
from examples.concealed.judge import judge
from examples.concealed.pictures import draw_all
from examples.concealed.report import details, short, table
from examples.concealed.seal import build
from examples.concealed.work import spread

SIZE_LIMIT = 300_000
PAGES = [keep.ROOT / "README.md", *sorted((keep.ROOT / "examples" / "concealed").glob("*.md"))]
PAGES += sorted((keep.ROOT / "coast_cli" / "guide").glob("*.md"))


def truth(level, name="backlash", nature=None):
    effect = {"id": name, "law": name, "kind": "physics", "component": "actuator", "noise_widths": 5.0}
    effects = [] if level == "L0" else [effect | ({"nature": nature} if nature else {})]
    return {"level": level, "seed": 3, "kind": "joint", "effects": effects, "noise": {"kind": "ar", "sigma": 0.1}}


def some_scores():
    nature = {"stages": ["drive"], "variables": [["stroke"]], "memory": True, "rate": False}
    named = {"verdict": "physics", "effects": [{"id": "backlash", "kind": "physics", "confidence": 0.95}]}
    law = {
        "verdict": "unnamed",
        "unnamed": {"stages": ["drive"], "variables": ["stroke"], "memory": True, "rate": None},
    }
    clean = judge("a", truth("L0"), {"diagnosis": {"verdict": "agrees"}, "seconds": 1.25})
    right = judge("b", truth("L1"), {"diagnosis": named, "seconds": 2.0}, {"recorded": 0.1234567891, "noiseless": 0.02})
    outside = judge("c", truth("L8", nature=nature), {"diagnosis": law, "seconds": 2.0})
    return Scores([clean, right, outside], {"other": [dataclasses.replace(right, score=-2.0)]}, {"seal": "00"})


def test_what_is_kept_comes_back_and_prints_the_same(tmp_path):
    scores, path = some_scores(), tmp_path / "kept.xz"
    keep.keep(scores, path)
    first = path.read_bytes()
    keep.keep(scores, path)
    assert path.read_bytes() == first
    back = keep.kept(path)
    assert back.about == {"seal": "00", "code": keep.code_digest()[:16]}
    assert table(dataclasses.replace(back, about=scores.about)) == table(scores)
    assert details(back) == details(scores)
    assert back.judgements[2].facts == (True, True, True, False)
    assert back.judgements[0] == scores.judgements[0]
    assert back.others["other"][0].figures["recorded"] == pytest.approx(0.1234567891, rel=1e-5)


def test_the_kept_answers_are_small_and_the_command_prints_them():
    assert keep.KEPT.stat().st_size < SIZE_LIMIT
    call = [sys.executable, "-m", "examples.concealed", "table"]
    printed = subprocess.run(call, cwd=keep.ROOT, capture_output=True, text=True, check=True).stdout
    assert printed == f"{keep.relation()}\n\n{table(keep.kept())}"


def test_every_page_that_holds_the_table_holds_what_is_printed():
    pages = {path.name: found for path in PAGES if (found := keep.held(path)) is not None}
    assert set(pages) >= {"README.md", "trust.md"}
    stale = [name for name, found in pages.items() if not found]
    assert not stale, f"python -m examples.concealed table --into {' --into '.join(stale)}"


@pytest.mark.parametrize(("mark", "words"), [(keep.BEGIN, table), (keep.BEGIN_SHORT, short)])
def test_the_table_goes_between_the_marks_of_a_page(mark, words, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"before\n{mark}\nold\n{keep.END}\nafter\n")
    keep.put(page, keep.kept())
    assert page.read_text() == f"before\n{mark}\n{words(keep.kept())}{keep.END}\nafter\n"
    assert keep.held(page)
    page.write_text("nothing")
    assert keep.held(page) is None
    with pytest.raises(ValueError, match="lacks the lines"):
        keep.put(page, keep.kept())


def test_the_table_says_how_it_relates_to_the_code():
    then, now = keep.kept().about["code"], keep.code_digest()[:16]
    said = keep.relation()
    assert now in said
    assert ("as it stands" in said) == (then == now)
    assert ("has moved" in said) == (then != now)


def test_the_digest_sees_modules_and_data_and_not_pages(tmp_path, monkeypatch):
    monkeypatch.setattr(keep, "ROOT", tmp_path)
    (tmp_path / "coast_cli").mkdir()
    module, page = tmp_path / "coast_cli" / "a.py", tmp_path / "coast_cli" / "a.md"
    module.write_text("x = 1\n")
    before = keep.code_digest()
    assert before == hashlib.sha256(b"a.py\nx = 1\n").hexdigest()
    page.write_text("words")
    assert keep.code_digest() == before
    module.write_text("x = 2\n")
    assert keep.code_digest() != before


def test_where_the_code_has_moved_the_drift_is_told(tmp_path, monkeypatch):
    path, drift = tmp_path / "kept.xz", tmp_path / "drift.json"
    keep.keep(some_scores(), path)
    monkeypatch.setattr(keep, "code_digest", lambda: "f" * 64)
    assert "has not been measured" in keep.relation(path, drift)
    then = keep.kept(path).about["code"]
    found = {
        "from": then,
        "to": "f" * 16,
        "cases": 150,
        "verdicts": 3,
        "names": 2,
        "score_before": 0.9,
        "score_after": 0.8,
    }
    drift.write_text(json.dumps(found))
    assert "asked again now, 3 of 150 verdicts and 2 first names are others" in keep.relation(path, drift)
    drift.write_text(json.dumps(found | {"to": "e" * 16}))
    assert f"asked again at {'e' * 16}, on the way" in keep.relation(path, drift)
    drift.write_text(json.dumps(found | {"from": "another"}))
    assert "has not been measured" in keep.relation(path, drift)


def test_drift_asks_the_same_cases_again(tmp_path, monkeypatch):
    case = build(("joint", 3, "L0", None))
    first = judge(case[0], case[1].truth, {"diagnosis": {"verdict": "agrees"}})
    path, drift = tmp_path / "kept.xz", tmp_path / "drift.json"
    keep.keep(Scores([first]), path)

    def answer(question):
        words = {"diagnosis": {"verdict": "parameters"}, "seconds": 1.0}
        question.target.write_text(json.dumps(words))

    monkeypatch.setattr(keep, "answer", answer)
    found = keep.measure_drift(5, 1, path, drift)
    assert (found["cases"], found["verdicts"], found["names"]) == (1, 1, 0)
    assert json.loads(drift.read_text()) == found
    assert found["moved"] == {case[0]: ["agrees", "parameters"]}


def test_pictures_are_drawn_and_are_the_same_twice(tmp_path):
    first = [path.read_bytes() for path in draw_all(some_scores(), tmp_path / "a")]
    assert len(first) == 4
    assert first == [path.read_bytes() for path in draw_all(some_scores(), tmp_path / "b")]


def test_figures_without_cases_are_dashes():
    assert "| L9: blind | - | 0 | - | 0 |" in table(some_scores())
    assert math.isnan(Scores([]).mean_score)


def test_a_cluster_gives_the_same_bytes():
    from distributed import LocalCluster

    jobs = [("joint", seed, None, None) for seed in range(2)]
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp://", dashboard_address=None
    ) as cluster:
        far = list(spread(build, jobs, 1, cluster.scheduler_address))
    near = list(spread(build, jobs, 1))
    assert [name for name, _ in far] == [name for name, _ in near]
    assert [case.files for _, case in far] == [case.files for _, case in near]
