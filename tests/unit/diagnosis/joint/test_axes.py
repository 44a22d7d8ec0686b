"""The region that holds the mismatch: a branch, a range, a run; and none where there is none."""

import numpy as np
import pytest

from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.joint.axes import locate_joint
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.capstan_hysteresis import CapstanHysteresis
from coast_cli.effects.library.coulomb_friction import CoulombFriction
from coast_cli.effects.library.notch_closure import NotchClosure
from coast_cli.effects.library.tendon_superelasticity import TendonSuperelasticity
from tests.modelled_joint import TOP, problem_of, recording


def regions(runs):
    problem = problem_of(runs)
    return locate_joint(problem, fit(problem))


def region_of(found, axis):
    return next((region for region in found if region.axis == axis), None)


@pytest.mark.parametrize(
    "effect",
    [
        Backlash(width_mm=0.2),
        Backlash(width_mm=0.05),
        CapstanHysteresis(pulley_friction=0.08),
        CoulombFriction(holds_per_m=1.0),
    ],
    ids=lambda effect: effect.id,
)
def test_hysteresis_is_on_release(effect):
    found = region_of(regions(recording((effect,))), "direction")
    assert found.value == "release"
    assert found.share > 0.9
    assert found.p_value < 1e-6


@pytest.mark.parametrize(
    "effect",
    [
        NotchClosure(closure_ratio=0.02, added_stiffness=10.0, knee_width=0.05),
        TendonSuperelasticity(knee_n=0.9, extra_compliance=3.0, knee_width=0.05),
    ],
    ids=lambda effect: effect.id,
)
def test_a_knee_is_in_the_upper_range_of_stroke_and_curvature(effect):
    runs = recording((effect,))
    found = regions(runs)
    largest = max(run.response.max() for run in runs)
    curvature, stroke = region_of(found, "curvature"), region_of(found, "stroke")
    assert curvature.high > 0.9 * largest
    assert 0.4 * largest < curvature.low < 0.85 * largest
    assert stroke.high == pytest.approx(1e3 * TOP, rel=0.02)
    assert stroke.low > 2.0
    assert max(curvature.share, stroke.share) > 0.9
    assert found[0].axis in ("curvature", "stroke")


def test_one_run_that_is_off_is_named():
    runs = recording()
    runs[1].response[:] += 3.0
    found = regions(runs)
    assert (found[0].axis, found[0].value) == ("run", "run_1")
    assert found[0].share > 0.9


def test_a_window_of_stroke_is_found_where_it_is():
    runs = recording()
    for run in runs:
        run.response[:] += 3.0 * np.exp(-0.5 * ((run.stroke[:, np.newaxis] - 2.2e-3) / 0.2e-3) ** 2)
    found = region_of(regions(runs), "stroke")
    assert 1.5 < found.low < 2.1
    assert 2.3 < found.high < 2.9
    assert found.share > 0.9


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_clean_recordings_show_no_region(memory):
    false = sum(bool(regions(recording(memory=memory, seed=seed))) for seed in range(50))
    assert false <= 1


def test_regions_come_by_share_with_shares_between_nought_and_one():
    found = regions(recording((Backlash(width_mm=0.2),)))
    assert all(0.0 <= region.share <= 1.0 for region in found)
    rounded = [round(region.share, 1) for region in found]
    assert rounded == sorted(rounded, reverse=True)
    assert len({region.axis for region in found}) == len(found)


def test_a_discrete_region_has_a_value_and_an_interval_has_ends():
    for region in regions(recording((Backlash(width_mm=0.2),))):
        assert (region.value is None) == (region.low is not None) == (region.high is not None)


def test_without_a_clock_nothing_is_said_about_time():
    found = regions(recording((Backlash(width_mm=0.2),), clock=False))
    assert found
    assert not {"time", "rate"} & {region.axis for region in found}


def test_the_same_recording_gives_the_same_regions():
    runs = recording((Backlash(width_mm=0.2),))
    assert regions(runs) == regions(runs)
