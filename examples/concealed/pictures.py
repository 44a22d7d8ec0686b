"""Pictures of a scored run: what was taken for what, whether probabilities hold, error against noise, leave-one-out."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from examples.concealed.figures import Scores, calibration_error, reliability
from examples.concealed.judge import Judgement
from examples.concealed.points import CLEAN

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_all(scores: Scores, folder: Path) -> list[Path]:
    """Write all pictures as PNG and return their paths."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    folder.mkdir(parents=True, exist_ok=True)
    drawn = []
    for name, draw in (
        ("confusion", confusion),
        ("reliability", calibration),
        ("error_against_noise", error_against_noise),
        ("leave_one_out", leave_one_out),
    ):
        figure = draw(scores.judgements)
        drawn.append(folder / f"{name}.png")
        figure.savefig(drawn[-1], dpi=110, metadata={"Software": None})
        plt.close(figure)
    return drawn


def _said(j: Judgement) -> str:
    if j.said_class in ("physics", "sensor") and j.named:
        return j.named[0]
    return {"unknown": "something else", "failed": "(no answer)"}.get(j.said_class, f"({j.verdict})")


def _concealed(j: Judgement) -> str:
    return "(clean)" if j.level in CLEAN else "something else" if j.level in ("L6", "L8") else j.truth[0]


def confusion(judged: list[Judgement]) -> Figure:
    """Rows: what was concealed; columns: what was named first, or the verdict where nothing was."""
    from matplotlib import pyplot as plt

    pairs = Counter((_concealed(j), _said(j)) for j in judged if j.level not in ("L2", "L3"))
    rows, columns = sorted({a for a, _ in pairs}), sorted({b for _, b in pairs})
    counts = np.array([[pairs[a, b] for b in columns] for a in rows], float).reshape(len(rows), len(columns))
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    size = (3 + 0.34 * len(columns), 2.4 + 0.26 * len(rows))
    figure, axes = plt.subplots(figsize=size, layout="constrained")
    axes.imshow(share, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for (i, k), count in np.ndenumerate(counts):
        if count:
            colour = "white" if share[i, k] > 0.6 else "black"
            axes.text(k, i, f"{count:.0f}", ha="center", va="center", fontsize=7, color=colour)
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=8)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.set_xlabel("said")
    axes.set_ylabel("concealed")
    return figure


def calibration(judged: list[Judgement]) -> Figure:
    """Share that came true against the probability stated, in ten bins, with the number in each."""
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(4.6, 4.4), layout="constrained")
    axes.plot([0, 1], [0, 1], color="0.6", linewidth=1)
    bins = reliability(judged)
    axes.plot([said for said, _, _ in bins], [came for _, came, _ in bins], "o-", color="tab:blue")
    for said, came, count in bins:
        axes.annotate(str(count), (said, came), textcoords="offset points", xytext=(6, -11), fontsize=8)
    axes.set_title(f"expected calibration error {calibration_error(judged):.3f}", fontsize=10)
    axes.set_xlabel("probability stated, something else included")
    axes.set_ylabel("share that came true")
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1.02)
    return figure


def error_against_noise(judged: list[Judgement]) -> Figure:
    """Error on the held-out run against the noiseless truth, over the noise, by what was concealed."""
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(5.6, 4.2), layout="constrained")
    for label, levels, colour in (
        ("clean", CLEAN, "tab:green"),
        ("in the catalogue", ("L1", "L2", "L3", "L4", "L5"), "tab:blue"),
        ("outside it", ("L6", "L8"), "tab:red"),
        ("bench fault", ("L9",), "tab:orange"),
    ):
        mine = [j for j in judged if j.level in levels and j.figures.get("noiseless") and j.kind == "joint"]
        axes.plot(
            [j.sigma for j in mine], [j.figures["noiseless"] for j in mine], ".", color=colour, label=label, alpha=0.7
        )
    axes.axline((0.1, 0.1), slope=1, color="0.6", linewidth=1)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks([0.05, 0.1, 0.2, 0.5], ["0.05", "0.1", "0.2", "0.5"])
    axes.minorticks_off()
    axes.set_xlabel("noise (1/m or degrees)")
    axes.set_ylabel("error on unseen rows, noiseless (same unit)")
    axes.legend(fontsize=8)
    return figure


def leave_one_out(judged: list[Judgement]) -> Figure:
    """Of each effect concealed from the catalogue: described, no name, agreement, a wrong name."""
    from matplotlib import pyplot as plt

    mine = [j for j in judged if j.level == "L8"]
    laws = sorted({j.laws[0] for j in mine}, reverse=True)
    parts = (
        ("stage, variable, memory and rate right", "tab:green", lambda j: bool(j.described)),
        ("no name", "tab:blue", lambda j: not j.described and j.said_class in ("unknown", "undecided")),
        ("agrees, or no answer", "tab:orange", lambda j: j.said_class in ("none", "parameter", "failed")),
        ("a wrong name", "tab:red", lambda j: j.said_class in ("physics", "sensor")),
    )
    figure, axes = plt.subplots(figsize=(6.4, 1.6 + 0.24 * max(len(laws), 1)), layout="constrained")
    left = np.zeros(len(laws))
    for label, colour, holds in parts:
        width = np.array([sum(holds(j) for j in mine if j.laws[0] == law) for law in laws], float)
        axes.barh(laws, width, left=left, color=colour, label=label)
        left += width
    axes.set_xlabel("cases")
    axes.tick_params(labelsize=8)
    axes.xaxis.get_major_locator().set_params(integer=True)
    figure.legend(fontsize=8, loc="outside upper center", ncols=2)
    return figure
