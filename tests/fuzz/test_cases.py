"""What fuzzing found stays mended: every kept case is refused in one sentence or answered, by every command line."""

import random
from pathlib import Path

import pytest

from tests.fuzz.targets import TARGETS

CASES = Path(__file__).parent / "cases"
KEPT = sorted(path for path in CASES.iterdir() if path.name.partition("-")[0] in TARGETS)


@pytest.mark.parametrize("case", KEPT, ids=lambda path: path.stem)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # an overflow is refused by its result, whose place is known
def test_a_kept_case_is_refused_or_answered(case):
    TARGETS[case.name.partition("-")[0]].replay(case)


@pytest.mark.parametrize("name", TARGETS)
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_mutated_seed_is_refused_or_answered(tmp_path, name, seed):
    target, chance = TARGETS[name], random.Random(seed)
    data = chance.choice(target.seeds())
    for _ in range(3):
        data = target.mutate(data, chance)
    path = tmp_path / f"fuzzed{target.suffix}"
    path.write_bytes(data)
    target.try_one(path)
