import numpy as np
import pytest

from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.unnamed.screen import screen_laws
from coast_cli.diagnosis.unnamed.search import misfit, refit_laws
from coast_cli.effects.catalogue import CATALOGUE
from tests.modelled_joint import problem_of, recording

LENGTHS = (0.035, 0.02, 0.035, 0.028, 0.02)
PLANTED = {
    ("transmission", "curvature", "friction"): ("capstan_hysteresis", {"pulley_friction": 0.05}),
    ("structure", "curvature", "friction"): ("coulomb_friction", {"holds_per_m": 1.0}),
    ("drive", "stroke", "friction"): ("backlash", {"width_mm": 0.1}),
    ("drive", "stroke", "period"): ("leadscrew_pitch_error", {"sine_mm": 0.05}),
    ("tendon", "tension", "relaxation"): ("tendon_creep", {"fraction": 0.1, "time_constant_s": 15.0}),
    ("tendon", "tension", "maximum"): ("tendon_permanent_set", {"slack_mm_per_n": 0.1}),
    ("sensor", "curvature", "relaxation"): ("sensor_lag", {"time_constant_s": 0.5}),
    ("transmission", "time", "none"): ("thermal_drift", {"stiffness_change": 0.2, "time_constant_s": 60.0}),
}


def posed(effects, **changes):
    runs = recording(effects, noise=0.1, memory=0.3, lengths=LENGTHS, **changes)
    held = [np.full(len(run), number > 2) for number, run in enumerate(runs)]
    problem = problem_of(runs, held)
    return problem, problem.only(held)


@pytest.mark.parametrize("kind", PLANTED, ids="-".join)
def test_what_is_concealed_is_found_without_its_name(kind):
    identifier, values = PLANTED[kind]
    effect = CATALOGUE[identifier](**{**{p.name: p.null for p in CATALOGUE[identifier].parameters}, **values})
    problem, choosing = posed([effect], seed=3)
    base = fit(problem)
    screened = screen_laws(problem, base)
    assert screened.p_value < 0.01
    laws = refit_laws(problem, choosing, base, screened)
    assert laws[0].kind == kind
    assert misfit(choosing, base)[0] > 1.05 * laws[0].unseen
    assert laws[0].unseen < 1.3
    assert screen_laws(problem, laws[0].fit).p_value > 0.01


def test_noise_alone_asks_for_no_law_more_often_than_it_says():
    p_values = []
    for seed in range(24):
        problem, _ = posed([], seed=100 + seed)
        p_values.append(screen_laws(problem, fit(problem), seed=seed).p_value)
    assert min(p_values) > 0.005
    assert np.mean(np.array(p_values) < 0.1) < 0.35
