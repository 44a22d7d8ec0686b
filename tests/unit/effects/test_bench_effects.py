"""Faults of a bench as effects: where they sit, and what physics expects of numbers that a fit finds."""

import numpy as np
import pytest

from coast_cli.diagnosis.joint.candidates import joint_space
from coast_cli.diagnosis.joint.moments import lost_steps
from coast_cli.effects.effect import History
from coast_cli.effects.library.camera_saturation import CameraSaturation
from coast_cli.effects.library.lost_steps import LostSteps
from coast_cli.effects.library.notch_closure import NotchClosure
from coast_cli.effects.library.tube_superelasticity import TubeSuperelasticity
from tests.modelled_joint import problem_of, recording


def history(run, start=100.0):
    count = 50
    return History(start + np.arange(count), np.full(count, 1e-3), None, np.full(count, 0.03), run=run)


def test_steps_are_lost_in_one_run_whatever_its_clock_shows():
    effect = LostSteps.of(1, [(0.2, 10.5), (0.1, 30.5)])
    assert effect.drive(history(0)).stroke == pytest.approx(1e-3)
    for start in (0.0, 100.0):
        stroke = effect.drive(history(1, start)).stroke
        assert stroke[:11] == pytest.approx(1e-3)
        assert stroke[11:31] == pytest.approx(0.8e-3)
        assert stroke[31:] == pytest.approx(0.7e-3)


def test_moments_that_were_not_chosen_are_not_fitted():
    problem = problem_of(recording())
    space = joint_space(problem, (LostSteps.of(1, [(0.2, 10.5)]),))
    assert [c.name for c, moves in zip(space.coordinates, space.moving, strict=True) if moves][-1] == "lost_mm"


@pytest.mark.parametrize("seed", range(3))
def test_the_run_the_moments_and_the_amounts_are_found(seed):
    rng = np.random.default_rng(seed)
    run = int(rng.integers(3))
    moments = [
        (float(rng.uniform(0.1, 0.3)), at) for at in (float(rng.uniform(8.0, 12.0)), float(rng.uniform(20.0, 24.0)))
    ]
    problem = problem_of(recording([LostSteps.of(run, moments)], noise=float(rng.uniform(0.05, 0.2)), seed=seed))
    (found,) = lost_steps(problem)
    assert found.run == run
    lost = [one for one in found.moments if one[0] != 0.0]
    assert sum(amount for amount, _ in lost) == pytest.approx(sum(amount for amount, _ in moments), rel=0.15)
    assert lost[0][1] == pytest.approx(moments[0][1], abs=1.5)
    assert lost_steps(problem_of(recording(noise=0.1, seed=seed))) == ()


def test_a_soft_end_is_below_the_response_and_the_level():
    response = np.linspace(0.0, 40.0, 200)[:, np.newaxis]
    seen = CameraSaturation(level=30.0, softness=0.02).sense(response, history(0))
    assert np.all(np.diff(seen[:, 0]) > 0.0)
    assert np.all(seen <= np.minimum(response, 30.0) + 1e-9)
    assert seen[:100] == pytest.approx(response[:100], rel=2e-3, abs=0.02)
    assert CameraSaturation.null().sense(response, history(0)) is response


@pytest.mark.parametrize(
    ("effect", "name", "inside", "outside"),
    [
        (TubeSuperelasticity(stiffness_lost=0.5), "knee_strain", (0.006, 0.014), 0.0014),
        (NotchClosure(added_stiffness=5.0), "closure_ratio", (0.85, 1.05), 0.024),
    ],
    ids=["knee", "closure"],
)
def test_what_physics_does_not_allow_costs_odds(effect, name, inside, outside):
    problem = problem_of(recording())

    def cost(value):
        moved = effect.with_values(
            np.array([value if p.name == name else v for p, v in zip(effect.parameters, effect.values(), strict=True)])
        )
        space = joint_space(problem, (moved,))
        return -space.log_prior(space.joined(problem.configured()))

    assert max(map(cost, inside)) < 2.0
    assert cost(outside) > 10.0
