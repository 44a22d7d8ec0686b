"""Two pictures of a scored run: which effect was taken for which, and whether a confidence means what it says."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from examples.concealed.judge import Judgement


def confusion_picture(judgements: list[Judgement], path: Path) -> None:
    """Rows: what was concealed (L1, L5, L6, clean); columns: what was named first, or the verdict where nothing was."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    pairs = [
        (
            j.truth[0] if j.truth else "(clean)",
            j.named[0] if j.named and j.said_class in ("physics", "sensor") else f"[{j.verdict}]",
        )
        for j in judgements
        if j.level in ("L0", "LP", "L1", "L5", "L6")
    ]
    rows, columns = sorted({a for a, _ in pairs}), sorted({b for _, b in pairs})
    counts = np.zeros((len(rows), len(columns)))
    for a, b in pairs:
        counts[rows.index(a), columns.index(b)] += 1
    share = counts / counts.sum(axis=1, keepdims=True)
    figure, axes = plt.subplots(figsize=(2 + 0.42 * len(columns), 2 + 0.32 * len(rows)), layout="constrained")
    axes.imshow(share, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for (i, k), count in np.ndenumerate(counts):
        if count:
            axes.text(
                k,
                i,
                f"{count:.0f}",
                ha="center",
                va="center",
                fontsize=7,
                color="white" if share[i, k] > 0.6 else "black",
            )
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=8)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.set_xlabel("said")
    axes.set_ylabel("concealed")
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def reliability_picture(judgements: list[Judgement], path: Path) -> None:
    """Share of right first names against the confidence that was stated, with the number of cases in each bin."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    said = [
        (j.confidence, bool(j.truth) and bool(j.named) and j.named[0] in j.truth)
        for j in judgements
        if j.confidence is not None and j.named
    ]
    figure, axes = plt.subplots(figsize=(4.5, 4.2), layout="constrained")
    axes.plot([0, 1], [0, 1], color="0.6", linewidth=1)
    edges = np.array([0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0001])
    for low, high in pairwise(edges):
        inside = [(c, right) for c, right in said if low <= c < high]
        if inside:
            at, share = float(np.mean([c for c, _ in inside])), float(np.mean([right for _, right in inside]))
            axes.plot(at, share, "o", color="tab:blue")
            axes.annotate(str(len(inside)), (at, share), textcoords="offset points", xytext=(5, -10), fontsize=8)
    axes.set_xlabel("confidence stated")
    axes.set_ylabel("share right")
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)
