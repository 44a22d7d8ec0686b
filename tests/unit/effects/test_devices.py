"""Devices without tubes: the ratio, where a run starts, and what each effect that has a stage there owes."""

import numpy as np
import pytest

from coast_cli.effects.devices import build_device_effects, device_effects, predict_device
from coast_cli.effects.effect import History
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.load_friction import LoadFriction
from coast_cli.effects.library.specimen_hysteresis import SpecimenHysteresis
from coast_cli.effects.library.transmission_compliance import TransmissionCompliance
from coast_cli.mechanics.transmission import Transmission

DEVICE = Transmission(ratio=-2.0, zero=1e-3, load_ratio=0.5, ratio_unit=1e3, drive_unit=1e-3)
TIME = np.linspace(0.0, 4.0, 201)
STROKE = 3e-3 * np.sin(np.pi * TIME)
LOAD = 1.0 + 0.5 * np.cos(np.pi * TIME)


def history(**changes):
    known = {
        "time": TIME,
        "stroke": STROKE,
        "tension": None,
        "bending_length": np.full(TIME.size, np.nan),
        "load": LOAD,
    }
    return History(**(known | changes))


def response(*effects, **changes):
    return predict_device(DEVICE, effects, [history(**changes)])[0][:, 0]


def test_the_base_is_a_line_to_both_sides():
    assert response() == pytest.approx(-2.0 * (STROKE - 1e-3) + 0.5 * LOAD)
    assert DEVICE.drive_of(float(response()[7]), float(LOAD[7])) == pytest.approx(STROKE[7])
    assert DEVICE.with_values({"ratio": 0.003, "zero_mm": 2.0}).ratio == pytest.approx(3.0)


@pytest.mark.parametrize("effect", device_effects().values(), ids=device_effects().keys())
def test_every_effect_is_the_identity_at_its_null_and_finite_elsewhere(effect):
    assert response(effect.null()) == pytest.approx(response(), abs=1e-12)
    scales = {"stroke": 6.0, "response": 0.006, "compliance": 6.0, "duration": 4.0, "period": 2.0, "runs": 1.0}
    for p in effect.parameters:
        for start in p.starts:
            value = float(np.clip(start * scales.get(p.relative_to, 1.0), p.low, p.high))
            assert np.all(
                np.isfinite(
                    response(
                        effect.null().with_values(np.array([value if q is p else q.null for q in effect.parameters]))
                    )
                )
            )


def test_what_acts_on_tubes_or_does_what_ratio_and_zero_do_is_no_candidate():
    for identifier in ("capstan_hysteresis", "tendon_creep", "tip_load", "camera_scale", "bending_length_offset"):
        assert identifier not in device_effects()
    assert {"backlash", "transmission_compliance", "sensor_lag", "load_friction"} <= set(device_effects())


@pytest.mark.parametrize("inside", [-1.0, -0.3, 0.0, 0.8, 1.0])
def test_a_run_starts_where_in_its_play_its_first_response_says(inside):
    width = 0.4
    begins = 0.5 * inside * width * 1e-3
    first = float(-2.0 * (STROKE[0] + begins - 1e-3))
    found = response(Backlash(width), load=None, first_response=first)
    assert found[0] == pytest.approx(first)
    # Driven up at first, it waits until the drive has taken up what play is left above it.
    waited = int(np.argmax(found < first - 1e-12))
    assert STROKE[waited] == pytest.approx(begins + 0.5 * width * 1e-3, abs=2e-4)
    assert (found[TIME > 1.0] / -2.0 + 1e-3).max() == pytest.approx(3e-3 - 0.2e-3, abs=1e-6)


def test_a_cable_stretches_before_the_play_of_the_far_end():
    both = (Backlash(0.4), TransmissionCompliance(1.5))
    assert response(*both) == pytest.approx(response(*reversed(both)))


def test_friction_grows_with_load_and_takes_energy():
    rubbed = response(LoadFriction(0.2, 0.1, 0.01), first_response=0.0) - response()
    moving = np.abs(np.cos(np.pi * TIME)) > 0.2
    assert np.abs(rubbed[moving]) == pytest.approx(0.2 + 0.1 * LOAD[moving], rel=1e-6)
    assert np.trapezoid(rubbed, STROKE) > 0.0


def test_friction_starts_as_its_first_response_says():
    level = response(load=None)[0]
    found = response(LoadFriction(0.2, 0.0, 0.01), load=None, first_response=float(level - 0.15))
    assert found[0] == pytest.approx(level - 0.15)


def test_a_specimen_has_both_plateaus_and_takes_energy():
    up = np.linspace(0.0, 1.0, 101)
    stretch = np.concatenate([up, up[::-1], 0.5 * up, 0.5 * up[::-1]]) * 1e-3
    specimen = Transmission(ratio=1e5, zero=0.0)
    blank = np.full(stretch.size, np.nan)
    run = History(np.arange(stretch.size) * 1.0, stretch, None, blank, first_response=0.0)
    force = predict_device(specimen, [SpecimenHysteresis(30.0, 12.0, 0.85)], [run])[0][:, 0]
    plain = predict_device(specimen, [], [run])[0][:, 0]
    assert force[30] == pytest.approx(plain[30])
    assert force[100] == pytest.approx(30.0 + 0.15 * 70.0)
    at = int(np.argmin(np.abs(stretch[101:202] - 0.3e-3))) + 101
    assert force[at] == pytest.approx(12.0 + 0.15 * 18.0)
    assert force[201] == pytest.approx(0.0)
    assert np.trapezoid(force, stretch) > 0.0


def test_corrections_come_back_as_effects():
    table = {"tube_hysteresis": {"upper_plateau_n": 20.0, "stiffness_lost": 0.8}, "load_friction": {"per_load": 0.3}}
    friction, loop = build_device_effects(table)
    assert isinstance(friction, LoadFriction)
    assert isinstance(loop, SpecimenHysteresis)
    assert build_device_effects({"capstan_hysteresis": {"pulley_friction": 0.1}}) == ()
