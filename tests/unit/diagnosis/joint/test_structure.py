"""Structure left in a residual: what repeats from run to run is found, coloured noise is not."""

import numpy as np
import pytest

from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.joint.structure import find_structure
from coast_cli.effects.library.backlash import Backlash
from tests.modelled_joint import problem_of, recording

NOISE = 0.1


def structure(runs, effects=()):
    problem = problem_of(runs)
    return find_structure(problem, fit(problem, effects))


def bumped(height, **changes):
    """Return runs with a bump of the response at one stroke."""
    runs = recording(noise=NOISE, **changes)
    for run in runs:
        run.response[:] += height * np.exp(-0.5 * ((run.stroke[:, np.newaxis] - 2.2e-3) / 0.3e-3) ** 2)
    return runs


def test_a_bump_that_repeats_is_predicted_from_other_runs():
    found = structure(bumped(3.0))
    assert found.repeats > 0.3
    assert found.size > 4.0 * NOISE
    assert found.noise < 4.0 * NOISE


def test_its_size_is_that_of_what_was_left_over():
    runs = bumped(3.0)
    problem = problem_of(runs)
    base = fit(problem)
    found = find_structure(problem, base)
    left = np.sqrt(base.rmse**2 - NOISE**2)
    assert found.size == pytest.approx(left, rel=0.15)
    assert np.hypot(found.size, found.noise) == pytest.approx(base.rmse, rel=1e-6)


def test_a_loop_needs_memory():
    found = structure(recording((Backlash(width_mm=0.2),), noise=NOISE))
    assert found.memory
    assert found.repeats > 0.7


def test_nothing_repeats_once_the_loop_is_explained():
    runs = recording((Backlash(width_mm=0.2),), noise=NOISE)
    found = structure(runs, (Backlash(width_mm=0.15),))
    assert found.repeats < 0.1
    assert found.size < 0.5 * NOISE


@pytest.mark.parametrize(("memory", "largest"), [(0.0, 0.1), (0.8, 0.2)])
def test_noise_does_not_repeat(memory, largest):
    found = [structure(recording(noise=NOISE, memory=memory, seed=seed)) for seed in range(15)]
    assert max(one.repeats for one in found) < largest
    assert max(one.smooth for one in found) < 0.0


def test_noise_with_a_long_memory_seldom_repeats_and_is_never_called_smooth():
    found = [structure(recording(noise=NOISE, memory=0.95, seed=seed)) for seed in range(25)]
    assert sum(one.repeats > 0.3 for one in found) <= 2
    assert np.median([one.repeats for one in found]) < 0.05
    assert max(one.smooth for one in found) < 0.0


def test_one_run_is_judged_by_its_blocks():
    found = structure(bumped(3.0, lengths=(0.03,)))
    assert found.repeats > 0.3
    quiet = structure(recording(noise=NOISE, lengths=(0.03,)))
    assert quiet.repeats < 0.15


def test_few_samples_are_not_judged():
    run = recording(lengths=(0.03,), noise=NOISE)[0]
    held = np.ones(len(run), bool)
    held[:20] = False
    problem = problem_of([run], [held])
    assert find_structure(problem, fit(problem)).repeats == 0.0
