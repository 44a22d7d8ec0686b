"""A few mutations of mappings, of foreign tables and of MATLAB files: each ends in an answer or in one sentence."""

import random

import pytest

from tests.fuzz.mappings import TARGETS, mutate_bytes


@pytest.mark.parametrize("name", TARGETS)
def test_seeds_and_mutations_are_answered_or_refused(name, tmp_path):
    target, chance, path = TARGETS[name], random.Random(1), tmp_path / f"fuzzed{TARGETS[name].suffix}"
    seeds = target.seeds()
    for seed in seeds:
        path.write_bytes(seed)
        target.replay(path)
    for _ in range(60):
        data = target.mutate(chance.choice(seeds), chance)
        path.write_bytes(mutate_bytes(data, chance) if chance.random() < 0.3 else data)
        target.try_one(path)
