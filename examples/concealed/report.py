"""The figures of a scored run as Markdown: one table of figures, the other answers, what was said of what, the worst cases."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

import numpy as np

from examples.concealed.camera import NOISE_KINDS
from examples.concealed.figures import Rate, Scores, calibration_error, mean_score, rate
from examples.concealed.judge import CLASSES, FACTS, Judgement
from examples.concealed.points import CLEAN, OPEN

SURE = 0.9
Pick = Callable[[Judgement], bool | None]


def table(scores: Scores) -> str:
    """Return the figures that the README holds: the same answers give the same text."""
    lines = [
        f"{len(scores.judgements)} cases, {scores.unanswered} without an answer. "
        + "; ".join(f"{name} `{value}`" for name, value in scores.about.items())
        + ".",
        "",
        "| figure | measured | cases | Wilson 95 % | aim |",
        "|---|---|---|---|---|",
    ]
    lines += [f"| {name} | {' | '.join(found.text())} | {aim} |" for name, found, aim in _rates(scores)]
    lines += [f"| {name} | {measured} | {cases} | | {aim} |" for name, measured, cases, aim in _numbers(scores)]
    return "\n".join([*lines, "", *_levels(scores), *_others(scores)]).rstrip() + "\n"


# What a first reader sees: one or two rows of each level.
KEY = (
    "false alarms, L0",
    "named first, L1",
    "none, parameter, physics",
    "sensor called physics",
    "physics called sensor",
    "L2: named after",
    "L4: both named",
    "L6: any wrong name",
    "L8: any wrong name",
    "L8 and L6: stage",
    "L9:",
    "right component",
    "`youngs_modulus_gpa`",
    "expected calibration error",
    "held-out error / true form",
    "score, mean",
)


def short(scores: Scores) -> str:
    """Return the rows of the table that a first reader sees."""
    rows = [line for line in table(scores).splitlines() if line.startswith("|")]
    return "\n".join([*rows[:2], *(row for row in rows if row[2:].startswith(KEY))]) + "\n"


def details(scores: Scores) -> str:
    """Return what was said of what, and the ten worst cases of each level."""
    lines = [*_confusion(scores), *_classes(scores)]
    for level in sorted({j.level for j in scores.judgements}):
        lines += _worst(scores, level)
    return "\n".join(lines) + "\n"


def _rates(scores: Scores) -> list[tuple[str, Rate, str]]:
    def of(pick: Pick, *levels: str) -> Rate:
        return scores.rate(pick, levels)

    noises = [
        (f"... noise {kind}", of(lambda j, kind=kind: j.alarm if j.noise == kind else None, "L0"), "1 %")
        for kind in NOISE_KINDS
    ]
    return [
        ("false alarms, L0", scores.false_alarms, "1 %"),
        *noises,
        ("false alarms, LP (a configured parameter is wrong)", of(lambda j: j.alarm, "LP"), "1 %"),
        ("named first, L1", scores.named_first, "98 %"),
        ("named in the first two, L1", of(lambda j: j.first_two, "L1"), "99.5 %"),
        ("wrong name, L1", of(lambda j: j.wrong, "L1"), ""),
        ("none, parameter, physics, sensor, unknown told apart", scores.told_apart, "97 %"),
        ("sensor called physics", scores.called("sensor", "physics"), "1 %"),
        ("physics called sensor", scores.called("physics", "sensor"), "1 %"),
        ("L2: right when it names", of(_right_when_named, "L2"), "98 %"),
        ("L2: named after its one proposed recording", of(lambda j: j.after_request == "right", "L2"), "95 %"),
        ("L3: wrong name", of(lambda j: j.wrong, "L3"), ""),
        ("L4: both named", of(lambda j: j.second_found, "L4"), "80 %"),
        ("L4: a wrong second", of(lambda j: j.second_wrong, "L4"), "3 %"),
        ("L5: named first", of(lambda j: j.first, "L5"), ""),
        ("L6: wrong name at 90 % and more", of(_surely_wrong, "L6"), ""),
        ("L6: any wrong name", of(lambda j: j.wrong, "L6"), "3 %"),
        ("L6: unexplained, or a law without a name", of(lambda j: j.unexplained, "L6"), "90 %"),
        ("L8: wrong name at 90 % and more", of(_surely_wrong, "L8"), "1 %"),
        ("L8: any wrong name", of(lambda j: j.wrong, "L8"), "5 %"),
        ("L8 and L6: stage, variable, memory and rate all right", of(lambda j: j.described, *OPEN), "80 %"),
        *((f"... {name} right", scores.fact(name), "90 %") for name in FACTS),
        ("L9: right verdict and place", of(lambda j: j.bench_right, "L9"), "90 %"),
        ("L9: blind", of(lambda j: j.blind, "L9"), "0"),
        ("right component", of(lambda j: j.component), "95 %"),
        ("place overlaps the true window by 0.8", of(lambda j: None if j.overlap is None else j.overlap >= 0.8), ""),
        *(
            (f"`{name}` within its 90 % interval", scores.intervals(name), "88 to 92 %")
            for name in ("youngs_modulus_gpa", "notch_friction", "deadband_mm")
        ),
    ]


def _right_when_named(j: Judgement) -> bool | None:
    return (not j.wrong) if j.named and j.said_class in ("physics", "sensor") else None


def _surely_wrong(j: Judgement) -> bool:
    return bool(j.wrong) and (j.confidence or 0.0) >= SURE


def _numbers(scores: Scores) -> list[tuple[str, str, int, str]]:
    judged = scores.judgements
    overlaps = [j.overlap for j in judged if j.overlap is not None]
    widths = [j.figures["noiseless"] / j.sigma for j in judged if "noiseless" in j.figures]
    seconds = [j.seconds for j in judged if math.isfinite(j.seconds)]
    biases = scores.biases("youngs_modulus_gpa")
    stated = sum(len(j.beliefs) for j in judged)
    error = calibration_error(judged)
    inside, outside = scores.ratios(("L1", "L4", "L5")), scores.ratios(OPEN)
    return [
        ("overlap with the true window, mean", f"{np.mean(overlaps):.2f}" if overlaps else "-", len(overlaps), "0.8"),
        ("expected calibration error, ten bins", "-" if math.isnan(error) else f"{error:.3f}", stated, "0.03"),
        ("held-out error / true form refitted, L1, L4, L5: median / 90th", _two(inside), len(inside), "1.03 / 1.10"),
        ("held-out error / true form refitted, L8 and L6: median / 90th", _two(outside), len(outside), "1.15 / 1.5"),
        ("held-out error to the truth, noise widths: median / 90th", _two(widths), len(widths), ""),
        ("stiffness off its true value, %: median / 90th", _two(biases), len(biases), "0.5"),
        ("score, mean", f"{scores.mean_score:.3f}", len(judged), "0.9"),
        ("seconds a case: median / 90th", _two(seconds), len(seconds), ""),
    ]


def _two(values: list[float]) -> str:
    return f"{np.median(values):.3f} / {np.quantile(values, 0.9):.3f}" if values else "-"


def _levels(scores: Scores) -> list[str]:
    levels = sorted({j.level for j in scores.judgements})
    of = {level: [j for j in scores.judgements if j.level == level] for level in levels}
    return [
        "| level | " + " | ".join(levels) + " |",
        "|---|" + "---|" * len(levels),
        "| mean score | " + " | ".join(f"{mean_score(of[level]):.2f}" for level in levels) + " |",
        "| cases | " + " | ".join(str(len(of[level])) for level in levels) + " |",
        "",
    ]


def _others(scores: Scores) -> list[str]:
    """Return the other answers beside ours, by the same rules on the same cases."""
    if not scores.others:
        return []
    cases = {j.case for judged in scores.others.values() for j in judged}
    mine = [j for j in scores.judgements if j.case in cases]
    lines = [
        f"Other answers by the same rules on {len(cases)} of the same cases; held-out errors in noise widths, median / 90th:",
        "",
        "| answer | cases | mean score | false alarms L0, LP | named first L1 | wrong name L6, L8 | as recorded | to the truth |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, judged in (("coast diagnose", mine), *scores.others.items()):
        alarms = rate(judged, lambda j: j.alarm, CLEAN).text()[0]
        first, wrong = (rate(judged, pick, levels).text()[0] for pick, levels in ((_first, ("L1",)), (_wrong, OPEN)))
        errors = [
            _two([j.figures[key] / j.sigma for j in judged if key in j.figures]) for key in ("recorded", "noiseless")
        ]
        shown = [str(len(judged)), f"{mean_score(judged):.2f}", alarms, first, wrong, *errors]
        lines.append(f"| {name} | {' | '.join(shown)} |")
    return [*lines, ""]


def _first(j: Judgement) -> bool | None:
    return j.first


def _wrong(j: Judgement) -> bool | None:
    return j.wrong


def _confusion(scores: Scores) -> list[str]:
    lines = ["| level | truth | cases | first | what was said instead |", "|---|---|---|---|---|"]
    wanted = [j for j in scores.judgements if j.level in ("L1", "L5", "L6", "L8", "L9")]
    for level, laws in sorted({(j.level, j.laws) for j in wanted}):
        mine = [j for j in wanted if (j.level, j.laws) == (level, laws)]
        right = [j for j in mine if j.first or j.described or j.bench_right]
        other = Counter((j.named[0] if j.named else j.verdict) for j in mine if j not in right)
        said = ", ".join(f"{name} {count}" for name, count in other.most_common(5))
        lines.append(f"| {level} | `{' + '.join(laws)}` | {len(mine)} | {len(right)} | {said} |")
    return [*lines, ""]


def _classes(scores: Scores) -> list[str]:
    classes = Counter((j.truth_class, j.said_class) for j in scores.judgements if j.level not in ("L2", "L3", "L9"))
    columns = [*CLASSES, "undecided", "failed"]
    lines = ["| class | " + " | ".join(columns) + " |", "|---|" + "---|" * len(columns)]
    lines += [f"| {true} | " + " | ".join(str(classes[true, other]) for other in columns) + " |" for true in CLASSES]
    return [*lines, ""]


def _worst(scores: Scores, level: str) -> list[str]:
    worst = scores.worst(10, level)
    lines = [
        f"| worst of {level} | seed | truth (noise widths) | said | confidence | score |",
        "|---|---|---|---|---|---|",
    ]
    for j in worst:
        true = ", ".join(f"{law} ({size:.1f})" for law, size in zip(j.laws, j.sizes, strict=True)) or "nothing"
        sure = "-" if j.confidence is None else f"{j.confidence:.2f}"
        said = f"{j.verdict}: {', '.join(j.named)}"
        lines.append(f"| `{j.case}` | {j.seed} | {true} | {said} | {sure} | {j.score:+.2f} |")
    return [*lines, ""] if worst else []
