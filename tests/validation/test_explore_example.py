"""``examples/explore.toml``: the pair it finds beats S4, the pair the paper chose, in all three figures when ranked."""

import json
from math import log
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "explore.toml"
FIGURES = ("total_precurvature_rad", "rigidity_ratio_mean", "total_rigidity_mean_n_m2")


def sample(role, row, curvature):
    return (
        f'[[{role}.samples]]\nname = "best-{role}"\ndepth_mm = {row[f"{role}_depth_mm"]!r}\n'
        f"natural_curvature_per_m = {curvature!r}\nnotch = {{ cut_mm = {row[f'{role}_cut_mm']!r}, "
        f"uncut_mm = {row[f'{role}_uncut_mm']!r}, count = {row[f'{role}_count']} }}\n\n"
    )


def between(row, role, samples):
    """Natural curvature on the line between the two measured samples that the depth lies between."""
    depth = row[f"{role}_depth_mm"]
    low = max(one for one in samples if one[0] <= depth)
    high = min(one for one in samples if one[0] >= depth)
    share = 0.0 if high[0] == low[0] else (depth - low[0]) / (high[0] - low[0])
    return low[1] + share * (high[1] - low[1])


def test_a_pair_of_the_front_beats_s4_when_it_is_ranked(coast, tmp_path):
    ran = coast("explore", EXAMPLE, "--top", "1", "-f", "json")
    assert ran.code == 0, ran.err
    best = json.loads(ran.out)["rows"][0]
    assert best["dominates_joint_pair"] is True
    outer = between(best, "outer", [(0.314, 0.8), (0.350, 3.2), (0.376, 5.5), (0.400, 1.1)])
    middle = between(best, "middle", [(0.243, 2.0), (0.265, 5.0), (0.287, 10.0)])
    text = EXAMPLE.read_text(encoding="utf-8")
    text = text.replace("[middle]\n", sample("outer", best, outer) + "[middle]\n", 1)
    text = text.replace("[inner] ", sample("middle", best, middle) + "[inner] ", 1)
    path = tmp_path / "with_best.toml"
    path.write_text(text, encoding="utf-8")
    ranked = {
        (row["outer"], row["middle"]): row for row in json.loads(coast("rank-pairs", path, "-f", "json").out)["rows"]
    }
    found, chosen = ranked["best-outer", "best-middle"], ranked["OT4", "MT1"]
    for name in FIGURES:
        assert abs(found[name] / best[name] - 1.0) < 1e-9
        costs = [abs(log(row[name])) if name == "rigidity_ratio_mean" else row[name] for row in (found, chosen)]
        assert costs[0] < costs[1]
