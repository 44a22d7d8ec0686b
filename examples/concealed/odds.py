"""Set how far names are to be believed: a logistic regression on what answers say against themselves, on tuning seeds.

Every answer of `coast diagnose` lists figures that speak against its names (`evidence`). Weights of these figures are set so
that the probability given is right as often as it says: maximum likelihood with a weak ridge, and no weight negative, because
what speaks against a name cannot speak for it. Cases are those of the catalogue, and those in which an effect of it is
concealed; what lies outside the catalogue judges the diagnosis and does not shape it.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from examples.concealed.points import OPEN
from examples.concealed.runner import ROOT, answer, answered, questions
from examples.concealed.seal import Job, build, key_of, write
from examples.concealed.tune import FIRST_SCORED, THRESHOLDS, copy_of, with_value
from examples.concealed.work import spread

ASKED_OF = ("L1", "L8", "L4", "L8", "L1", "L5", "L8", "L3")
NAMED_FROM = "NAMED_FROM"  # is set to 0, so that every name is given with what speaks against it
RIDGE = 0.1
# What an answer is worth (points.py): a right name, a right name withheld, a wrong name, and a wrong name withheld, where none is
# right or where one is.
GIVEN, WITHHELD, WRONG, REFUSED_OUTSIDE, REFUSED_INSIDE = 1.0, 0.25, -2.0, 1.0, 0.25
FROM = np.arange(0.4, 0.91, 0.05)
BINS = 5


def collect(
    out: Path, seeds: range, jobs: int, root: Path = ROOT
) -> tuple[list[str], NDArray[np.float64], NDArray[np.bool_]]:
    """Return of every answer with names: the figures' names, the figures (n, k), and whether right and outside, (n, 2)."""
    if not seeds or seeds[-1] >= FIRST_SCORED:
        raise ValueError(
            f"seeds {seeds.start}:{seeds.stop} are not all below {FIRST_SCORED}: those above are for scoring"
        )
    wanted: list[Job] = [("joint", seed, ASKED_OF[i % len(ASKED_OF)], None) for i, seed in enumerate(seeds)]
    cases = dict(spread(build, wanted, jobs))
    write(out, cases.items(), key_of(wanted))
    tree = copy_of(root, out, THRESHOLDS, NAMED_FROM, 0.0)
    (out / "answers-odds").mkdir(exist_ok=True)
    every = [replace(question, root=tree) for question in questions(out, folder="answers-odds")]
    for _ in spread(answer, [question for question in every if not answered(question.target)], jobs):
        pass
    names: list[str] = []
    rows, right = [], []
    for question in every:
        found = json.loads(question.target.read_text(encoding="utf-8")).get("diagnosis") or {}
        if found.get("evidence"):
            names = list(found["evidence"])
            rows.append([float(found["evidence"][name]) for name in names])
            truth = cases[question.case.name].truth
            right.append((is_right(found, truth), truth["level"] in OPEN))
    return names, np.array(rows, dtype=np.float64), np.array(right, dtype=bool)


def is_right(found: dict[str, Any], truth: dict[str, Any]) -> bool:
    """Return whether the first name, or in a group any of the names, is in the data and not concealed."""
    if truth["level"] in OPEN:
        return False
    present = {str(effect["id"]) for effect in truth["effects"]} | {str(twin) for twin in truth.get("twins") or ()}
    said = [str(effect["id"]) for effect in found["effects"]] or [str(one) for one in found["attempts"]]
    if found["verdict"] == "ambiguous":
        said += [str(one) for group in found["alternatives"] for one in group]
        return bool(present & set(said))
    return said[:1] != [] and said[0] in present


def fitted(figures: NDArray[np.float64], right: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the constant and the weights (1 + k,) of log odds = constant - weights figures."""

    def cost(weights: NDArray[np.float64]) -> float:
        odds = weights[0] - figures @ weights[1:]
        return float(np.sum(np.logaddexp(0.0, np.where(right, -odds, odds))) + 0.5 * RIDGE * np.sum(weights[1:] ** 2))

    bounds = [(None, None)] + [(0.0, None)] * figures.shape[1]
    return np.asarray(minimize(cost, np.full(1 + figures.shape[1], 0.5), bounds=bounds).x)


def believed(weights: NDArray[np.float64], figures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the probability that names are right (n,)."""
    return np.asarray(1.0 / (1.0 + np.exp(figures @ weights[1:] - weights[0])))


def worth(given: NDArray[np.float64], right: NDArray[np.bool_], outside: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the mean worth of the answers where names are given from each of the probabilities `FROM` on."""
    withheld = np.where(right, WITHHELD, np.where(outside, REFUSED_OUTSIDE, REFUSED_INSIDE))
    return np.array([np.where(given > level, np.where(right, GIVEN, WRONG), withheld).mean() for level in FROM])


def report(
    weights: NDArray[np.float64], names: list[str], figures: NDArray[np.float64], right: NDArray[np.bool_]
) -> str:
    """Return the weights, and probability against share that was right in a few bins of equal number."""
    lines = [f"{len(right)} answers with names, {right.mean():.3f} right", f"constant {weights[0]:.3g}"]
    lines += [f"{name} {weight:.3g}" for name, weight in zip(names, weights[1:], strict=True)]
    given = believed(weights, figures)
    for part in np.array_split(np.argsort(given, kind="stable"), BINS):
        lines.append(f"given {given[part].mean():.2f}, right {right[part].mean():.2f} of {part.size}")
    return "\n".join(lines) + "\n"


def put(weights: NDArray[np.float64], names: list[str], named_from: float, root: Path = ROOT) -> None:
    """Write the weights, and from which probability on names are given, into the module of thresholds."""
    text = with_value(NAMED_FROM, named_from, (root / THRESHOLDS).read_text(encoding="utf-8"))
    for name, weight in zip(["constant", *names], weights, strict=True):
        text = with_value(f"ODDS_{name.upper()}", round(float(weight), 2), text)
    (root / THRESHOLDS).write_text(text, encoding="utf-8")
