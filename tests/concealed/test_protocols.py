"""Protocols are those of benches, and time goes on in every one of them."""

import numpy as np
import pytest

from examples.concealed.protocol import HABITS, _as_people_do, draw_protocol


@pytest.mark.parametrize("seed", range(40))
def test_time_goes_on_and_the_drive_stays_in_its_range(seed):
    protocol = draw_protocol(np.random.default_rng(seed), 2, 2)
    for plan in protocol.runs:
        for habit in ("", *HABITS):
            run = _as_people_do(np.random.default_rng(seed), plan, habit) if habit else plan
            assert np.diff(run.time).min() > 1e-7 * protocol.dt
            assert run.time.size == run.fraction.size
            assert run.recorded.size >= 15
            assert run.recorded[-1] < run.time.size
            assert np.all(np.diff(run.recorded) > 0)
            assert run.fraction.min() >= 0
            assert run.fraction.max() <= 1


def test_each_habit_is_what_it_says():
    protocol = draw_protocol(np.random.default_rng(3), 1, 1)
    plan = protocol.runs[0]
    uneven, stopped, paused, late = (_as_people_do(np.random.default_rng(1), plan, habit) for habit in HABITS)
    assert np.array_equal(uneven.time, plan.time)
    assert not np.allclose(uneven.fraction, plan.fraction)
    assert stopped.time[-1] < 0.96 * plan.time[-1]
    assert paused.time[-1] > 1.05 * plan.time[-1]
    assert np.diff(paused.time).max() > 5 * np.diff(plan.time).max()
    assert late.recorded[0] > 0
    assert np.array_equal(late.time, plan.time)


def test_some_runs_are_repeated():
    drawn = [draw_protocol(np.random.default_rng(seed), 1, 1).runs for seed in range(60)]
    again = sum(any(a is b for i, a in enumerate(runs) for b in runs[:i]) for runs in drawn)
    assert 3 <= again <= 30
