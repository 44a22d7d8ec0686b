"""Open the seal, judge every answer, recompute held-out errors from the saved models, and print one table.

Held-out errors come from `coast compare --model` on the held-out run twice over: as recorded, and with the response
replaced by the noiseless truth. A figure without cases is printed as a dash, never as a pass.
"""

from __future__ import annotations

import csv
import io
import json
import math
import subprocess
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from examples.concealed.judge import CLASSES, Judgement, judge
from examples.concealed.runner import coast
from examples.concealed.seal import SEALED, unseal

ERROR_KEYS = {
    "curvature_per_m": "rmse_curvature_per_m",
    "bend_deg": "rmse_bend_deg",
    "notch_deg": "rmse_notch_deg",
    "shape_mm": "rmse_shape_mm",
}


@dataclass(frozen=True)
class Rate:
    """A share of cases with its Wilson 95 % interval."""

    hits: int
    cases: int

    @property
    def value(self) -> float:
        """The share, NaN without cases."""
        return self.hits / self.cases if self.cases else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval."""
        if not self.cases:
            return math.nan, math.nan
        z, n, p = 1.959964, self.cases, self.value
        centre = (p + z * z / 2 / n) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / 4 / n / n)
        return max(centre - half, 0.0), min(centre + half, 1.0)

    def text(self) -> tuple[str, str, str]:
        """Return share, number of cases and interval as words."""
        if not self.cases:
            return "-", "0", "-"
        low, high = self.interval
        return f"{100 * self.value:.1f} %", str(self.cases), f"{100 * low:.1f} to {100 * high:.1f} %"


@dataclass
class Scores:
    """All judgements of a run, and the figures made of them."""

    digest: str
    judgements: list[Judgement]
    truths: dict[str, dict[str, Any]]
    unanswered: int
    others: dict[str, dict[str, Any]] = field(default_factory=dict)
    base: dict[str, Rate] = field(default_factory=dict)
    biases: list[float] = field(default_factory=list)

    def rate(self, pick: Callable[[Judgement], bool | None], levels: Iterable[str] = ()) -> Rate:
        """Share of the cases (of these levels) for which `pick` holds; None leaves a case out."""
        wanted = set(levels)
        found = [
            bool(value) for j in self.judgements if (not wanted or j.level in wanted) and (value := pick(j)) is not None
        ]
        return Rate(sum(found), len(found))

    @property
    def false_alarms(self) -> Rate:
        """Share of clean records on which something was named."""
        return self.rate(lambda j: j.alarm, ("L0",))

    @property
    def named_first(self) -> Rate:
        """Share of single effects named first."""
        return self.rate(lambda j: j.first, ("L1",))

    @property
    def named_in_two(self) -> Rate:
        """Share of single effects among the first two names."""
        return self.rate(lambda j: j.first_two, ("L1",))

    @property
    def told_apart(self) -> Rate:
        """None, parameter, physics, sensor and unknown told apart; refitted parameters on a clean record are right."""
        return self.rate(self._told, ("L0", "LP", "L1", "L5", "L6"))

    def _told(self, j: Judgement) -> bool | None:
        if self.truths[j.case].get("twins"):
            return None
        return j.said_class == j.truth_class or (j.truth_class == "none" and j.said_class == "parameter")

    @property
    def sensor_called_physics(self) -> Rate:
        """Share of sensor artefacts called physics."""
        return self.rate(lambda j: j.said_class == "physics" if j.truth_class == "sensor" else None, ("L1", "L5"))

    @property
    def mean_score(self) -> float:
        """Mean score over all cases."""
        return float(np.mean([j.score for j in self.judgements])) if self.judgements else math.nan

    def worst(self, count: int = 10) -> list[Judgement]:
        """Lowest scores first; among equals the most confident."""
        return sorted(
            (j for j in self.judgements if j.score < 0.25), key=lambda j: (j.score, -(j.confidence or 0), j.case)
        )[:count]

    def table(self) -> str:
        """Markdown: figures, other answers, confusion, worst failures."""
        return _table(self)


def score(
    out: Path, *, digest: str | None = None, baselines: int = 0, plots: bool = False, jobs: int = 2, errors: bool = True
) -> Scores:
    """Judge all answers in `out`; `baselines` is on how many cases the other answers run.

    Writes table.md beside the answers.
    """
    truths = unseal(out, digest)
    held_out = json.loads((out / "held_out.json").read_text(encoding="utf-8"))
    answers = {
        path.stem: json.loads(path.read_text(encoding="utf-8"))
        for path in sorted((out / "answers").glob("*.json"))
        if path.stem.count(".") == 0
    }
    judged = {name: judge(name, truths[name], answer) for name, answer in answers.items()}
    if errors:
        with ThreadPoolExecutor(max(jobs, 1)) as pool:
            ready = [name for name in sorted(judged) if held_out.get(name)]
            for name, figures in zip(
                ready, pool.map(lambda n: held_out_errors(out, n, truths[n], held_out[n]), ready), strict=True
            ):
                judged[name].figures.update(figures)
    scores = Scores(
        (out / f"{SEALED}.sha256").read_text(encoding="utf-8").strip(),
        [judged[name] for name in sorted(judged)],
        truths,
        len(truths) - len(judged),
    )
    _base_parameters(scores, answers)
    if baselines:
        chosen = [name for name in sorted(judged) if held_out.get(name) and truths[name]["kind"] == "joint"][:baselines]
        with ProcessPoolExecutor(max(jobs, 1)) as pool:
            for name, found in zip(
                chosen, pool.map(_others, [(out, name, truths[name], held_out[name]) for name in chosen]), strict=True
            ):
                scores.others[name] = found
    (out / "table.md").write_text(scores.table(), encoding="utf-8")
    (out / "judgements.json").write_text(
        json.dumps([vars(j) for j in scores.judgements], indent=1, sort_keys=True), encoding="utf-8"
    )
    if plots:
        from examples.concealed.pictures import confusion_picture, reliability_picture

        confusion_picture(scores.judgements, out / "confusion.png")
        reliability_picture(scores.judgements, out / "reliability.png")
    return scores


def _others(job: tuple[Path, str, dict[str, Any], list[str]]) -> dict[str, Any]:
    from examples.concealed.baselines import others

    out, name, truth, held_out = job
    cache = out / "answers" / f"{name}.others.json"
    if not cache.exists():
        found = {
            other.name: {"recorded": other.recorded, "noiseless": other.noiseless, "named": other.named}
            for other in others(out / "cases" / name, truth, held_out)
        }
        cache.write_text(json.dumps(found), encoding="utf-8")
    return dict(json.loads(cache.read_text(encoding="utf-8")))


def held_out_errors(out: Path, name: str, truth: dict[str, Any], held_out: list[str]) -> dict[str, float]:
    """RMSE of the saved model on the held-out run, as recorded and noiseless; empty without a model."""
    model, cache = out / "answers" / f"{name}.model.toml", out / "answers" / f"{name}.errors.json"
    if cache.exists():
        return dict(json.loads(cache.read_text(encoding="utf-8")))
    if not model.exists():
        return {}
    found: dict[str, float] = {}
    for label in ("recorded", "noiseless"):
        work = out / "answers" / f"{name}.{label}.csv"
        work.write_text(
            _held_out_csv(out / "cases" / name, held_out, truth if label == "noiseless" else None), encoding="utf-8"
        )
        try:
            code, stdout, _ = coast(
                "compare",
                str(out / "cases" / name / "tubes.toml"),
                str(work),
                "--model",
                str(model),
                "--format",
                "json",
            )
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


def _base_parameters(scores: Scores, answers: dict[str, dict[str, Any]]) -> None:
    """Bias and 90 % coverage of the base parameters, where the answer was right: a wrong one biases them by its nature.

    A recording fixes the modulus only together with the pulley friction, so it is compared as E exp(mu alpha).
    """
    found: dict[str, list[bool]] = {"youngs_modulus_gpa": [], "notch_friction": [], "deadband_mm": []}
    for judgement in scores.judgements:
        truth = scores.truths[judgement.case]
        reported = (answers[judgement.case].get("diagnosis") or {}).get("parameters") or {}
        if truth["kind"] != "joint" or judgement.score < 1 or judgement.level not in ("L0", "LP", "L1"):
            continue
        true, configured = dict(truth["parameters"]), truth["configured"]
        friction = _value(reported.get("pulley_friction")) or configured["pulley_friction"]
        true["youngs_modulus_gpa"] *= math.exp((true["pulley_friction"] - friction) * configured["wrap_angle_rad"])
        # With one bending length the friction per notch is not fitted, and stiffness holds what it is off by.
        merged = not (reported.get("notch_friction") or {}).get("std")
        merged = merged and true["notch_friction"] != configured["notch_friction"]
        for name, hits in found.items():
            entry = None if merged and name == "youngs_modulus_gpa" else reported.get(name)
            if isinstance(entry, dict) and entry.get("std") and not entry.get("at_bound"):
                hits.append(abs(float(entry["value"]) - true[name]) < 1.645 * float(entry["std"]))
                if name == "youngs_modulus_gpa":
                    scores.biases.append(100 * (float(entry["value"]) / true[name] - 1))
    for name, hits in found.items():
        scores.base[f"`{name}` within its 90 % interval"] = Rate(sum(hits), len(hits))


def _value(entry: object) -> float | None:
    return float(entry["value"]) if isinstance(entry, dict) else None


def _median(values: list[float]) -> str:
    return f"{np.median(values):.3f} / {np.quantile(values, 0.9):.3f}" if values else "-"


def _table(scores: Scores) -> str:
    rate = scores.rate
    lines = [
        f"Seal SHA-256 `{scores.digest}`; {len(scores.judgements)} cases answered, {scores.unanswered} not.",
        "",
        "| figure | measured | cases | Wilson 95 % | aim |",
        "|---|---|---|---|---|",
    ]

    def row(name: str, found: Rate, aim: str) -> None:
        lines.append(f"| {name} | {' | '.join(found.text())} | {aim} |")

    row("false alarms on L0", scores.false_alarms, "at most 1 %")
    for kind in ("white", "ar", "drift", "quantised"):
        row(
            f"... noise {kind}",
            rate(lambda j, kind=kind: j.alarm if scores.truths[j.case]["noise"]["kind"] == kind else None, ("L0",)),
            "at most 1 %",
        )
    row("false alarms on LP (a configured parameter is wrong)", rate(lambda j: j.alarm, ("LP",)), "at most 1 %")
    row("named first, L1", scores.named_first, "98 %")
    row("named in the first two, L1", scores.named_in_two, "99.5 %")
    row("wrong name, L1", rate(lambda j: j.wrong, ("L1",)), "")
    row("none, parameter, physics, sensor, unknown told apart", scores.told_apart, "97 %")
    row("sensor called physics", scores.sensor_called_physics, "1 %")
    row(
        "L2: right when it names",
        rate(lambda j: (not j.wrong) if j.named and j.said_class in ("physics", "sensor") else None, ("L2",)),
        "98 %",
    )
    row("L2: named after its one proposed recording", rate(lambda j: j.after_request == "right", ("L2",)), "95 %")
    row("L3: wrong name", rate(lambda j: j.wrong, ("L3",)), "")
    row("L4: both named", rate(lambda j: j.second_found, ("L4",)), "80 %")
    row("L4: a wrong second", rate(lambda j: j.second_wrong, ("L4",)), "3 %")
    row("L5: named first", rate(lambda j: j.first, ("L5",)), "")
    row("L6: wrong name", rate(lambda j: j.wrong, ("L6",)), "3 %")
    row("L6: called unexplained", rate(lambda j: j.unexplained, ("L6",)), "90 %")
    row("right component", rate(lambda j: j.component), "95 %")
    row("place overlaps the true window by 0.8", rate(lambda j: None if j.overlap is None else j.overlap >= 0.8), "")
    for name, found in scores.base.items():
        row(name, found, "88 to 92 %")
    overlaps = [j.overlap for j in scores.judgements if j.overlap is not None]
    ratios = [
        j.figures["recorded"] / scores.others[j.case]["true form refitted"]["recorded"]
        for j in scores.judgements
        if j.case in scores.others and "recorded" in j.figures
    ]
    sigmas = [
        j.figures["noiseless"] / scores.truths[j.case]["noise"]["sigma"]
        for j in scores.judgements
        if "noiseless" in j.figures
    ]
    biases = [abs(bias) for bias in scores.biases]
    times = [j.seconds for j in scores.judgements if math.isfinite(j.seconds)]
    lines += [
        f"| overlap with the true window, mean | {np.mean(overlaps):.2f} | {len(overlaps)} | | 0.8 |"
        if overlaps
        else "| overlap | - | 0 | | 0.8 |",
        f"| held-out error / true form refitted, median / 90th | {_median(ratios)} | {len(ratios)} | | 1.03 / 1.10 |",
        f"| held-out error to the truth, noise widths, median / 90th | {_median(sigmas)} | {len(sigmas)} | | |",
        f"| stiffness off its true value, %, median / 90th | {_median(biases)} | {len(biases)} | | 0.5 |",
        f"| score, mean | {scores.mean_score:.3f} | {len(scores.judgements)} | | 0.9 |",
        f"| seconds a case, median / 90th | {_median(times)} | {len(times)} | | |",
        "",
    ]
    lines += _level_scores(scores) + _others_table(scores) + _confusion(scores) + _worst(scores)
    return "\n".join(lines) + "\n"


def _level_scores(scores: Scores) -> list[str]:
    levels = sorted({j.level for j in scores.judgements})
    head = ["| level | " + " | ".join(levels) + " |", "|---|" + "---|" * len(levels)]
    means = [f"{np.mean([j.score for j in scores.judgements if j.level == level]):.2f}" for level in levels]
    counts = [str(sum(j.level == level for j in scores.judgements)) for level in levels]
    return [*head, "| mean score | " + " | ".join(means) + " |", "| cases | " + " | ".join(counts) + " |", ""]


def _others_table(scores: Scores) -> list[str]:
    """Return the same held-out errors, in noise widths, for the other answers; and what i.i.d. BIC would have named."""
    if not scores.others:
        return []
    level = {j.case: j for j in scores.judgements}
    names = list(next(iter(scores.others.values())))
    lines = [
        f"Other answers on {len(scores.others)} of the same cases; held-out error in noise widths, median / 90th:",
        "",
        "| answer | as recorded | against the noiseless truth |",
        "|---|---|---|",
    ]
    width = {case: scores.truths[case]["noise"]["sigma"] for case in scores.others}
    mine = [case for case in scores.others if {"recorded", "noiseless"} <= level[case].figures.keys()]
    lines.append(
        f"| coast diagnose ({len(mine)}) | {_median([level[c].figures['recorded'] / width[c] for c in mine])} "
        f"| {_median([level[c].figures['noiseless'] / width[c] for c in mine])} |"
    )
    lines += [
        f"| {name} | {_median([found[name]['recorded'] / width[c] for c, found in scores.others.items()])} "
        f"| {_median([found[name]['noiseless'] / width[c] for c, found in scores.others.items()])} |"
        for name in names
    ]
    bic = {case: found["i.i.d. BIC"]["named"] for case, found in scores.others.items()}
    clean = [bic[c] != "none" for c in bic if level[c].level in ("L0", "LP")]
    right = [bic[c] == level[c].truth[0] for c in bic if level[c].level == "L1"]
    outside = [bic[c] != "none" for c in bic if level[c].level == "L6"]
    for text, found in (("false alarms, clean", clean), ("named first, L1", right), ("wrong name, L6", outside)):
        lines.append(f"| i.i.d. BIC: {text} | {Rate(sum(found), len(found)).text()[0]} | of {len(found)} |")
    return [*lines, ""]


def _confusion(scores: Scores) -> list[str]:
    lines = ["| truth (L1, L5) | cases | first | what was said instead |", "|---|---|---|---|"]
    wanted = [j for j in scores.judgements if j.level in ("L1", "L5")]
    for effect in sorted({j.truth[0] for j in wanted}):
        mine = [j for j in wanted if j.truth[0] == effect]
        other = Counter((j.named[0] if j.named else j.verdict) for j in mine if not j.first)
        said = ", ".join(f"{name} {count}" for name, count in other.most_common(5))
        lines.append(f"| `{effect}` | {len(mine)} | {sum(bool(j.first) for j in mine)} | {said} |")
    classes = Counter((j.truth_class, j.said_class) for j in scores.judgements if j.level not in ("L2", "L3"))
    columns = [*CLASSES, "undecided", "failed"]
    lines += ["", "| class | " + " | ".join(columns) + " |", "|---|" + "---|" * len(columns)]
    lines += [f"| {true} | " + " | ".join(str(classes[true, other]) for other in columns) + " |" for true in CLASSES]
    return [*lines, ""]


def _worst(scores: Scores) -> list[str]:
    lines = ["| worst cases | seed | level | truth (noise widths) | said | score |", "|---|---|---|---|---|---|"]
    for j in scores.worst():
        truth = scores.truths[j.case]
        true = ", ".join(f"{effect['id']} ({effect['noise_widths']:.1f})" for effect in truth["effects"]) or "nothing"
        said = f"{j.verdict}: {', '.join(j.named)}"
        lines.append(f"| `{j.case}` | {truth['seed']} | {j.level} | {true} | {said} | {j.score:+.2f} |")
    return lines


def pilot(seeds: range, out: Path, *, jobs: int = 2, shapes: bool = False, errors: bool = False) -> Scores:
    """Make, run and score a few cases over all levels in turn: what continuous integration holds to floors."""
    from examples.concealed.draw import LEVELS
    from examples.concealed.runner import run
    from examples.concealed.seal import build_all, write
    from examples.concealed.shape_case import SHAPE_LEVELS

    # A third of the cases are L1, a third L0; the other levels take turns for the rest.
    pattern = [
        level
        for other in (SHAPE_LEVELS if shapes else LEVELS)
        if other not in ("L0", "L1", "L8")
        for level in ("L1", "L0", other)
    ]
    kind = "shape" if shapes else "joint"
    digest = write(
        out, build_all([(kind, seed, pattern[i % len(pattern)], None) for i, seed in enumerate(seeds)], jobs)
    )
    run(out, jobs)
    return score(out, digest=digest, jobs=jobs, errors=errors)
