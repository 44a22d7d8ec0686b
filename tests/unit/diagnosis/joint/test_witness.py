"""A load cell that reads wrongly, and moduli that are off: what stroke, curvature and tension tell apart."""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.diagnosis.joint import diagnose_joint
from tests.modelled_joint import CONFIG, recording

LENGTHS = (0.035, 0.02, 0.035)


def read_by(runs, scale):
    return [replace(run, tension=scale * run.tension) for run in runs]


@pytest.mark.parametrize("seed", range(2))
def test_one_factor_of_both_moduli_is_the_load_cell(seed):
    rng = np.random.default_rng(seed)
    scale = 1.0 + rng.choice((-1.0, 1.0)) * rng.uniform(0.08, 0.25)
    runs = read_by(recording(lengths=LENGTHS, noise=rng.uniform(0.05, 0.2), seed=seed, witness=True), scale)
    answer = diagnose_joint(CONFIG, runs)
    assert answer.verdict == "sensor"
    assert [effect.id for effect in answer.effects] == ["load_cell_scale"]
    assert answer.effects[0].parameters["scale"].value == pytest.approx(scale, rel=0.05)
    assert "the modulus of the tubes would be" in answer.reason


def test_one_modulus_that_is_off_is_a_parameter_and_a_strained_one_is_said():
    tubes = recording(lengths=LENGTHS, noise=0.1, witness=True, values={"youngs_modulus_gpa": 50.0})
    assert diagnose_joint(CONFIG, tubes).verdict == "parameters"
    tendon = recording(lengths=LENGTHS, noise=0.1, witness=True, values={"tendon_youngs_modulus_gpa": 46.0})
    answer = diagnose_joint(CONFIG, tendon)
    assert answer.verdict == "parameters"
    assert any("tension fits only with a tendon of" in note for note in answer.notes)
