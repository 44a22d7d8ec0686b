"""The robust ranking: pairs by their chance to pass every check as made, not by their score as drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from coast_cli.design.rank import Ranking, RankOptions, rank, with_section
from coast_cli.design.tolerance import chances
from coast_cli.errors import UsageError
from coast_cli.spec.build import build
from coast_cli.spec.config import Config

SAMPLES = 1000


def robust_rank(config: Config, options: RankOptions, *, samples: int = SAMPLES, seed: int = 0) -> Ranking:
    """Rank the pairs by the chance that all checks hold over the tolerances; equal chances by score.

    Raises:
        UsageError: there are no limits to pass, or the assembly is coupled.
        BadInput: as ``rank``.
    """
    if config.checks is None:
        raise UsageError("a robust ranking needs limits to pass, and the configuration has no [checks].")
    if options.assembly != "separate":
        raise UsageError("a robust ranking takes the assembly 'separate' only.")
    drawn = rank(config, options)
    design = with_section(build(config), options.section)
    passing, first = (table.mean(axis=1) for table in chances(design, options, samples=samples, seed=seed))
    pairs = [(one.name, two.name) for two in design.middle for one in design.outer]
    names = zip(drawn.columns["outer"], drawn.columns["middle"], strict=True)
    place = np.array([pairs.index(name) for name in names])
    impossible = np.array([reason is not None for reason in drawn.columns["reason"]])
    columns: dict[str, Any] = dict(drawn.columns)
    columns["probability_passing"], columns["probability_first"] = passing[place], first[place]
    order = np.lexsort((columns["rank"], -columns["probability_passing"], impossible))
    ordered = {
        name: np.asarray(values, dtype=None if isinstance(values, np.ndarray) else object)[order]
        for name, values in columns.items()
    }
    ordered["rank"] = columns["rank"]
    best = f"{ordered['outer'][0]}/{ordered['middle'][0]}"
    score_first = f"{drawn.columns['outer'][0]}/{drawn.columns['middle'][0]}"
    survives = float(columns["probability_first"][0])
    note = f"{best} passes most often; by score as drawn {score_first} ranks first, and in {survives:.1%} of benches as made."
    source = "[tolerances]" if config.tolerances is not None else "the default tolerances"
    return Ranking(ordered, (*drawn.notes, note, f"chances are of {samples} samples over {source}."))
