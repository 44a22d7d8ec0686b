"""The order of two pairs never depends on a third: from 500 random benches each tube is taken away in turn."""

from itertools import product

import numpy as np
import pytest

from coast_cli.design.rank import RankOptions, rank, scores_of
from coast_cli.spec.load import load_config_text

BENCHES = 500
_STOCK = """version = 1
[materials.nitinol]
youngs_modulus_gpa = 45.0
density_kg_per_m3 = 6450.0
"""


def stock(role, size, samples):
    outer, inner = size
    lines = [
        f"[{role}]",
        'material = "nitinol"',
        f"outer_diameter_mm = {outer}",
        f"inner_diameter_mm = {inner}",
        "notch = { cut_mm = 0.3, uncut_mm = 0.3, count = 6 }",
    ]
    for name, depth, curvature in samples:
        lines += [
            f"[[{role}.samples]]",
            f'name = "{name}"',
            f"depth_mm = {depth}",
            f"natural_curvature_per_m = {curvature}",
        ]
    return "\n".join(lines) + "\n"


def bench(seed):
    random = np.random.default_rng(seed)
    counts = random.integers(1, 4, size=2)
    outer = [(f"O{k}", random.uniform(0.26, 0.42), random.uniform(0.0, 10.0)) for k in range(counts[0])]
    middle = [(f"M{k}", random.uniform(0.19, 0.3), random.uniform(0.0, 20.0)) for k in range(counts[1])]
    options = RankOptions(random.choice(["mean", "series"]), weights=tuple(random.uniform(0.1, 2.0, size=3)))
    return outer, middle, options


def order(outer, middle, options):
    text = _STOCK + stock("outer", (0.5, 0.4), outer) + stock("middle", (0.36, 0.28), middle)
    columns = rank(load_config_text(text), options).columns
    return list(zip(columns["outer"], columns["middle"], strict=True))


@pytest.mark.parametrize("part", range(10))
def test_taking_a_tube_away_never_reorders_the_rest(part):
    for seed in range(part, BENCHES, 10):
        outer, middle, options = bench(seed)
        whole = order(outer, middle, options)
        fewer = [([one for one in outer if one is not gone], middle) for gone in outer]
        fewer += [(outer, [one for one in middle if one is not gone]) for gone in middle]
        for ones, twos in fewer:
            if ones and twos:
                left = set(product([one[0] for one in ones], [two[0] for two in twos]))
                assert order(ones, twos, options) == [pair for pair in whole if pair in left]


def test_taking_one_pair_away_never_reorders_the_rest():
    for seed in range(BENCHES):
        random = np.random.default_rng(seed)
        costs, weights, references = (
            random.uniform(0.0, 5.0, (12, 3)),
            random.uniform(0, 2, 3),
            random.uniform(0.1, 9, 3),
        )
        gone = int(random.integers(12))
        whole = np.argsort(scores_of(costs, weights, references), kind="stable")
        rest = np.delete(np.arange(12), gone)
        np.testing.assert_array_equal(
            rest[np.argsort(scores_of(costs[rest], weights, references), kind="stable")], whole[whole != gone]
        )
