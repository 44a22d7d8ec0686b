"""Open the seal, recompute held-out errors from the saved models, and judge every answer.

Held-out errors come from `coast compare --model` on the held-out run twice over: as recorded, and with the response
replaced by the noiseless truth.
"""

from __future__ import annotations

import csv
import io
import json
import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from examples.concealed.figures import Scores
from examples.concealed.judge import Judgement, judge
from examples.concealed.laws import RECIPES
from examples.concealed.report import details, table
from examples.concealed.runner import coast
from examples.concealed.seal import SEALED, Job, build, key_of, open_seal, unseal, write
from examples.concealed.work import spread

NAMES_ALONE = "the nearest name for every law without one"
ERROR_KEYS = {
    "curvature_per_m": "rmse_curvature_per_m",
    "bend_deg": "rmse_bend_deg",
    "notch_deg": "rmse_notch_deg",
    "shape_mm": "rmse_shape_mm",
}


def score(out: Path, *, digest: str | None = None, baselines: int = 0, jobs: int = 2, errors: bool = True) -> Scores:
    """Judge all answers in `out`, whose seal is open; `baselines` is on how many cases the other answers run.

    Writes table.md, details.md and judgements.json beside the answers.
    """
    from examples.concealed.laws import digest as laws_digest

    truths = unseal(out, digest)
    held_out = json.loads((out / "held_out.json").read_text(encoding="utf-8"))
    judged = judge_folder(out, out / "answers", truths, held_out, jobs if errors else 0)
    about = {
        "seal": (out / f"{SEALED}.sha256").read_text(encoding="utf-8").strip()[:16],
        "laws": laws_digest()[:16],
    }
    scores = Scores(judged, about=about)
    if any(j.verdict == "unnamed" for j in judged):
        scores.others[NAMES_ALONE] = judge_folder(out, out / "answers", truths, held_out, 0, nearest_name)
    if baselines:
        scores.others |= _others(out, judged, truths, held_out, baselines, jobs)
    for folder in sorted(out.glob("answers-*")):
        # Answers of the same command with further words: `run --label NAME`.
        name = folder.name.removeprefix("answers-")
        scores.others[name] = judge_folder(out, folder, truths, held_out, jobs if errors else 0)
    (out / "table.md").write_text(table(scores), encoding="utf-8")
    (out / "details.md").write_text(details(scores), encoding="utf-8")
    (out / "judgements.json").write_text(
        json.dumps([vars(j) for j in scores.judgements], indent=1, sort_keys=True), encoding="utf-8"
    )
    return scores


def nearest_name(answer: dict[str, Any]) -> dict[str, Any]:
    """Return an answer as it would be with names alone: the nearest name in the place of a law without one."""
    diagnosis = answer.get("diagnosis") or {}
    nearest = (diagnosis.get("unnamed") or {}).get("nearest") or []
    if diagnosis.get("verdict") != "unnamed" or not nearest:
        return answer
    name = str(nearest[0]["id"])
    kind = RECIPES[name].kind if name in RECIPES else "physics"
    effect = {"id": name, "kind": kind, "component": RECIPES[name].component if name in RECIPES else ""}
    return answer | {
        "diagnosis": diagnosis | {"verdict": kind, "effects": [effect], "unnamed": None, "probabilities": {}}
    }


def judge_folder(
    out: Path,
    folder: Path,
    truths: dict[str, dict[str, Any]],
    held_out: dict[str, list[str]],
    jobs: int,
    change: Callable[[dict[str, Any]], dict[str, Any]] = lambda answer: answer,
) -> list[Judgement]:
    """Judge the answers of one folder, each after a `change`, in the order of the cases.

    `jobs` of nought recomputes no errors.
    """
    answers = {
        path.stem: json.loads(path.read_text(encoding="utf-8"))
        for path in sorted(folder.glob("*.json"))
        if path.stem.count(".") == 0
    }
    figures: dict[str, dict[str, float]] = {}
    ready = [name for name in answers if held_out.get(name)] if jobs else []
    with ThreadPoolExecutor(max(jobs, 1)) as pool:
        found = pool.map(lambda name: held_out_errors(out, folder, name, truths[name], held_out[name]), ready)
        figures.update(zip(ready, found, strict=True))
    missing = {"diagnosis": None}
    given = {name: change(answers.get(name, missing)) for name in truths}
    return [judge(name, truths[name], given[name], figures.get(name)) for name in sorted(truths)]


def _others(
    out: Path,
    judged: list[Judgement],
    truths: dict[str, dict[str, Any]],
    held_out: dict[str, list[str]],
    count: int,
    jobs: int,
) -> dict[str, list[Judgement]]:
    """Return the judgements of the other answers on `count` joint cases that hold out a run, from all levels in turn."""
    levels: dict[str, list[str]] = {}
    for j in judged:
        if held_out.get(j.case) and j.kind == "joint" and "doubled_rows" not in j.laws:
            levels.setdefault(j.level, []).append(j.case)
    turns = [name for turn in range(len(judged)) for names in levels.values() for name in names[turn : turn + 1]]
    chosen = sorted(turns[:count])
    found: dict[str, list[Judgement]] = {}
    answers = spread(_other_answers, [(out, name, truths[name], held_out[name]) for name in chosen], jobs)
    for case, given in zip(chosen, answers, strict=True):
        for name, other in given.items():
            found.setdefault(name, []).append(judge(case, truths[case], other, other["figures"]))
    return found


def _other_answers(job: tuple[Path, str, dict[str, Any], list[str]]) -> dict[str, Any]:
    from examples.concealed.baselines import others

    out, name, truth, held_out = job
    cache = out / "answers" / f"{name}.others.json"
    if not cache.exists():
        cache.write_text(json.dumps(others(out / "cases" / name, truth, held_out)), encoding="utf-8")
    return dict(json.loads(cache.read_text(encoding="utf-8")))


def held_out_errors(out: Path, folder: Path, name: str, truth: dict[str, Any], held_out: list[str]) -> dict[str, float]:
    """RMSE of the saved model on the held-out run, as recorded and noiseless; empty without a model."""
    model, cache = folder / f"{name}.model.toml", folder / f"{name}.errors.json"
    if cache.exists():
        return dict(json.loads(cache.read_text(encoding="utf-8")))
    if not model.exists():
        return {}
    found: dict[str, float] = {}
    configuration = str(out / "cases" / name / "tubes.toml")
    for label in ("recorded", "noiseless"):
        work = folder / f"{name}.{label}.csv"
        text = _held_out_csv(out / "cases" / name, held_out, truth if label == "noiseless" else None)
        work.write_text(text, encoding="utf-8")
        try:
            code, stdout, _ = coast("compare", configuration, str(work), "--model", str(model), "--format", "json")
        except subprocess.TimeoutExpired:
            code, stdout = -1, ""
        work.unlink()
        if code in (0, 1) and stdout:
            for row in json.loads(stdout)["rows"]:
                key = ERROR_KEYS[truth["unit"]]
                if row.get("run") in held_out and row.get(key) is not None:
                    found[label] = float(row[key])
    cache.write_text(json.dumps(found), encoding="utf-8")
    return found


def _held_out_csv(case: Path, held_out: list[str], truth: dict[str, Any] | None) -> str:
    """Return the held-out rows as one file; with `truth` the response is the noiseless one."""
    for path in sorted(case.glob("*.csv")):
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file)
            rows, header = [row for row in reader if row["run"] in held_out], list(reader.fieldnames or ())
        if not rows:
            continue
        seen = [
            key for key in header if key in ("curvature_per_m", "bend_deg", "x_mm", "y_mm") or key.startswith("notch_")
        ]
        if truth is not None:
            exact = [values for run in held_out for values in truth["response"][run]]
            for row, values in zip(rows, exact, strict=True):
                row.update({key: f"{value:.6f}" for key, value in zip(seen, values, strict=True)})
        text = io.StringIO()
        writer = csv.DictWriter(text, header, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue()
    return ""


def pilot(seeds: range, out: Path, *, jobs: int = 2, shapes: bool = False, errors: bool = False) -> Scores:
    """Make, run and score a few cases over all levels in turn: what continuous integration holds to floors."""
    from examples.concealed.draw import LEVELS
    from examples.concealed.runner import run
    from examples.concealed.shape_case import SHAPE_LEVELS

    # A third of the cases are L1, a third L0; the other levels take turns for the rest.
    pattern = [
        level
        for other in (SHAPE_LEVELS if shapes else LEVELS)
        if other not in ("L0", "L1", "L8")
        for level in ("L1", "L0", other)
    ]
    kind = "shape" if shapes else "joint"
    asked: list[Job] = [(kind, seed, pattern[i % len(pattern)], None) for i, seed in enumerate(seeds)]
    digest = write(out, spread(build, asked, jobs), key_of(asked))
    run(out, jobs)
    open_seal(out, key_of(asked))
    return score(out, digest=digest, jobs=jobs, errors=errors)
