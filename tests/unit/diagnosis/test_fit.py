"""Fits find what the forward model was given, and say when they stand on a bound."""

import numpy as np
import pytest

from coast_cli.diagnosis.fit import fit
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.camera_offset import CameraOffset
from coast_cli.effects.library.capstan_hysteresis import CapstanHysteresis
from coast_cli.effects.library.sensor_lag import SensorLag
from coast_cli.effects.library.tendon_creep import TendonCreep
from coast_cli.effects.library.tube_superelasticity import TubeSuperelasticity
from tests.modelled_joint import problem_of, recording

NOISE = 0.1


@pytest.mark.parametrize(
    "values",
    [
        {"youngs_modulus_gpa": 50.0, "deadband_mm": 1.0},
        {"youngs_modulus_gpa": 30.0, "deadband_mm": 1.5, "notch_friction": 1.01},
    ],
)
def test_base_parameters_come_back_within_their_uncertainty(values):
    problem = problem_of(recording(values=values, noise=NOISE, witness=True))
    found = fit(problem)
    expected = {"notch_friction": 1.0063, **values}
    fitted = problem.values(found.coordinates)
    for place, parameter in enumerate(problem.base[:3]):
        std = np.sqrt(found.covariance[place, place]) * (fitted[parameter.name] if parameter.logarithmic else 1.0)
        assert abs(fitted[parameter.name] - expected[parameter.name]) < 4.0 * std + 1e-4
    assert found.rmse == pytest.approx(NOISE, rel=0.1)
    assert found.evidence.level == pytest.approx(NOISE, rel=0.12)
    assert found.converged
    assert not any(found.at_bound)


@pytest.mark.parametrize(
    ("true", "start"),
    [
        (Backlash(width_mm=0.2), Backlash(width_mm=0.05)),
        (CapstanHysteresis(pulley_friction=0.08), CapstanHysteresis(pulley_friction=0.02)),
        (CameraOffset(offset=-2.0), CameraOffset(offset=0.5)),
        (SensorLag(time_constant_s=1.5), SensorLag(time_constant_s=0.4)),
        (TendonCreep(fraction=0.2, time_constant_s=12.0), TendonCreep(fraction=0.1, time_constant_s=6.0)),
        (
            TubeSuperelasticity(knee_strain=0.0022, stiffness_lost=0.5, knee_width=0.1),
            TubeSuperelasticity(knee_strain=0.0016, stiffness_lost=0.3, knee_width=0.15),
        ),
    ],
    ids=lambda effect: effect.id,
)
def test_effect_parameters_come_back_from_another_start(true, start):
    problem = problem_of(recording((true,), noise=NOISE, values={"youngs_modulus_gpa": 46.0}, witness=True))
    found = fit(problem, (start,))
    assert found.ids == (true.id,)
    assert found.rmse == pytest.approx(NOISE, rel=0.15)
    size = next(parameter for parameter in true.parameters if parameter.role == "size")
    assert getattr(found.effects[0], size.name) == pytest.approx(getattr(true, size.name), rel=0.1)
    assert problem.values(found.coordinates)["youngs_modulus_gpa"] == pytest.approx(46.0, rel=0.03)
    assert found.log_likelihood > fit(problem).log_likelihood + 20.0


def test_two_effects_are_fitted_together():
    true = (Backlash(width_mm=0.15), CameraOffset(offset=1.5))
    found = fit(problem_of(recording(true, noise=NOISE)), (Backlash(width_mm=0.05), CameraOffset(offset=0.2)))
    assert found.effects[0].width_mm == pytest.approx(0.15, rel=0.1)
    assert found.effects[1].offset == pytest.approx(1.5, rel=0.1)
    assert found.parameter_count == 2


def test_a_useless_effect_stays_small_and_gains_nothing():
    problem = problem_of(recording(noise=NOISE))
    base, found = fit(problem), fit(problem, (Backlash(width_mm=0.1),))
    assert found.effects[0].width_mm < 0.02
    assert found.log_likelihood - base.log_likelihood < 5.0


def test_a_parameter_on_its_bound_is_said():
    problem = problem_of(recording(values={"youngs_modulus_gpa": 42.6 * 20.0}, noise=NOISE))
    found = fit(problem, steps=40)
    assert found.at_bound[0]
    assert problem.values(found.coordinates)["youngs_modulus_gpa"] == pytest.approx(8.0 * 42.6)


def test_a_start_outside_the_bounds_is_moved_inside():
    problem = problem_of(recording(noise=NOISE))
    low, high = problem.bounds()
    found = fit(problem, start=high + 1.0)
    assert np.all((found.coordinates >= low) & (found.coordinates <= high))


def test_the_start_does_not_decide_the_answer():
    problem = problem_of(recording(noise=NOISE, values={"youngs_modulus_gpa": 48.0}))
    start = problem.configured() + np.array([0.3, 0.005, 0.3])
    one, other = fit(problem), fit(problem, start=start)
    assert other.coordinates == pytest.approx(one.coordinates, rel=2e-3, abs=2e-3)


def test_held_out_rows_do_not_move_the_fit():
    runs = recording(noise=NOISE)
    held = [np.zeros(len(run), bool) for run in runs]
    held[2][:] = True
    before = fit(problem_of(runs, held))
    runs[2].response[:] += 7.0
    after = fit(problem_of(runs, held))
    assert after.coordinates == pytest.approx(before.coordinates, rel=1e-5)


def test_the_same_problem_gives_the_same_bits():
    problem = problem_of(recording((Backlash(width_mm=0.2),), noise=NOISE))
    one, two = (fit(problem, (Backlash(width_mm=0.08),)) for _ in range(2))
    assert np.array_equal(one.coordinates, two.coordinates)
    assert one.effects == two.effects


def test_coloured_noise_widens_the_uncertainty():
    white, coloured = (fit(problem_of(recording(noise=NOISE, memory=memory))) for memory in (0.0, 0.9))
    assert coloured.evidence.memory > 0.7
    assert coloured.covariance[0, 0] > 3.0 * white.covariance[0, 0]


def test_a_tension_witness_counts_in_the_likelihood():
    found = fit(problem_of(recording(noise=NOISE, witness=True)))
    assert found.residuals[1].size > 0
    assert found.evidences[1].level == pytest.approx(0.01, rel=0.2)
    prior_free = found.evidence.log_likelihood + found.evidences[1].log_likelihood
    assert prior_free - 5.0 < found.log_likelihood <= prior_free
