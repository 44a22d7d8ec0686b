"""The pilot: a few concealed recordings of every level, answered by the command itself and held to floors.

The floors lie well below what the full run measures (`coast guide trust`), as so few cases scatter: they catch a
diagnosis that has broken, not one that has become a little worse. These seeds were looked at while it was built.
"""

from __future__ import annotations

import pytest

from examples.concealed.figures import Scores
from examples.concealed.scorer import pilot

SEEDS = range(7000, 7015)


@pytest.fixture(scope="module")
def scores(tmp_path_factory) -> Scores:
    return pilot(SEEDS, tmp_path_factory.mktemp("pilot"))


def test_every_case_is_answered(scores):
    assert scores.unanswered == 0
    assert len(scores.judgements) == len(SEEDS)


def test_clean_recordings_come_back_clean(scores):
    assert scores.false_alarms.cases >= 5
    assert scores.false_alarms.hits == 0


def test_single_effects_are_named_first(scores):
    assert scores.named_first.cases >= 5
    assert scores.named_first.value >= 0.75


def test_sensors_are_not_called_physics(scores):
    assert scores.called("sensor", "physics").hits <= 1
