"""Set deciding numbers of the diagnosis on tuning seeds, from outside: one number at a time, the best mean score wins.

A number is a line `NAME = VALUE` or `NAME = Threshold(VALUE, ...)` of a module of coast_cli. Each value is tried in a copy of
the package, so that the tree is touched only by `write`. Only levels inside the catalogue are drawn, and only seeds that
are never scored: what leaves the catalogue judges the diagnosis and does not shape it.
"""

from __future__ import annotations

import json
import re
import shutil
import sys
from dataclasses import dataclass, replace
from pathlib import Path

from examples.concealed.figures import mean_score
from examples.concealed.judge import judge
from examples.concealed.runner import ROOT, answer, answered, questions
from examples.concealed.seal import Job, build, key_of, write
from examples.concealed.work import spread

# Seeds below are for tuning, seeds from here on for scoring.
FIRST_SCORED = 30_000
TUNED_ON = ("L0", "L1", "L0", "L3", "L1", "L4", "LP", "L5")
THRESHOLDS = Path("coast_cli") / "diagnosis" / "thresholds.py"


@dataclass(frozen=True)
class Trial:
    """One value of one number and the mean score that it reached."""

    name: str
    value: float
    score: float


def line_of(name: str, text: str) -> re.Match[str]:
    """Return the match of a module's line that holds a number, the number itself as its second group."""
    before = rf"^({re.escape(name)}\b[^=\n]*=\s*(?:\w+\(\s*)?)"
    found = re.search(before + r"([-+]?[\d._]+(?:[eE][-+]?\d+)?)", text, re.MULTILINE)
    if found is None:
        raise ValueError(f"no line '{name} = NUMBER' or '{name} = Threshold(NUMBER, ...)' in the module")
    return found


def with_value(name: str, value: float, text: str) -> str:
    """Return a module's text with one number replaced."""
    found = line_of(name, text)
    return f"{text[: found.start(2)]}{value:g}{text[found.end(2) :]}"


def copy_of(root: Path, out: Path, module: Path, name: str, value: float) -> Path:
    """Return a copy of the package, below `out`, in which one number has another value."""
    tree = out / "trees" / f"{name}={value:g}"
    if not tree.exists():
        shutil.copytree(root / "coast_cli", tree / "coast_cli", ignore=shutil.ignore_patterns("__pycache__"))
        text = (root / module).read_text(encoding="utf-8")
        (tree / module).write_text(with_value(name, value, text), encoding="utf-8")
    return tree


def tune(
    out: Path, seeds: range, tried: dict[str, list[float]], jobs: int, module: Path = THRESHOLDS, root: Path = ROOT
) -> list[Trial]:
    """Return every trial, number by number, the value that stands first; what is answered is not asked again."""
    if not seeds or seeds[-1] >= FIRST_SCORED:
        raise ValueError(
            f"seeds {seeds.start}:{seeds.stop} are not all below {FIRST_SCORED}: those above are for scoring"
        )
    text = (root / module).read_text(encoding="utf-8")
    standing = {name: float(line_of(name, text)[2]) for name in tried}
    asked: list[Job] = [("joint", seed, TUNED_ON[i % len(TUNED_ON)], None) for i, seed in enumerate(seeds)]
    cases = dict(spread(build, asked, jobs))
    write(out, cases.items(), key_of(asked))
    trials = []
    for name, values in tried.items():
        for value in dict.fromkeys([standing[name], *values]):
            folder = f"answers-{name}={value:g}"
            (out / folder).mkdir(exist_ok=True)
            tree = copy_of(root, out, module, name, value)
            every = [replace(question, root=tree) for question in questions(out, folder=folder)]
            for _ in spread(answer, [question for question in every if not answered(question.target)], jobs):
                pass
            given = {question.case.name: json.loads(question.target.read_text(encoding="utf-8")) for question in every}
            score = mean_score([judge(case, cases[case].truth, found) for case, found in given.items()])
            trials.append(Trial(name, value, score))
            sys.stderr.write(f"{name} = {value:g}: {score:.4f}\n")
    return trials


def best(trials: list[Trial]) -> dict[str, Trial]:
    """Return the best value of each number; the value that stands (the first tried) wins ties."""
    found: dict[str, Trial] = {}
    for trial in trials:
        if trial.name not in found or trial.score > found[trial.name].score:
            found[trial.name] = trial
    return found


def put(trials: list[Trial], module: Path = THRESHOLDS, root: Path = ROOT) -> None:
    """Write the best value of each number into the module."""
    text = (root / module).read_text(encoding="utf-8")
    for trial in best(trials).values():
        text = with_value(trial.name, trial.value, text)
    (root / module).write_text(text, encoding="utf-8")
