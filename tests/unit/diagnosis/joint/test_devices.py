"""Devices without tubes, simulated by this file's own formulas with random numbers, and diagnosed as strangers."""

import numpy as np
import pytest

from coast_cli.diagnosis.compare import compare
from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.calibration import calibrate
from coast_cli.diagnosis.model_file import model_text
from coast_cli.errors import BadInput
from coast_cli.recordings.model import JointRun, Recording, Recordings
from coast_cli.spec.load import load_config_text

DEGREE = np.pi / 180.0


def device(ratio=1.0, extra=""):
    return load_config_text(f'[joint]\nkind = "transmission"\nratio = {ratio}\n{extra}')


def played(drive, width, start):
    """Play of a width (mm) that lies evenly about the drive, by its definition, row by row."""
    state, out = start, []
    for value in drive:
        state = min(max(state, value - width / 2), value + width / 2)
        out.append(state)
    return np.array(out)


def run(name, drive_mm, response, *, kind="bend", time=None, moment=None):
    count = drive_mm.size
    return JointRun(
        name=name,
        source="made",
        line=np.arange(2, count + 2),
        time=np.arange(count) * 0.05 if time is None else time,
        outer=None,
        middle="",
        bending_length=np.full(count, np.nan),
        stroke=drive_mm * 1e-3,
        tension=None,
        response=(response * (DEGREE if kind == "bend" else 1.0))[:, np.newaxis],
        kind=kind,
        load_moment=moment,
    )


def swept(rng, count=240, cycles=2.2):
    """A drive that crosses zero and starts anywhere, mm."""
    phase = np.linspace(0.0, 2.0 * np.pi * cycles, count) + rng.uniform(0.0, 2.0 * np.pi)
    return rng.uniform(1.5, 4.0) * np.sin(phase) + rng.uniform(-0.5, 0.5)


def cable_runs(rng, *, width, compliance, ratio, zero, noise=0.02):
    """Runs at three loads: the cable stretches, then play; each starts somewhere inside its play."""
    made = []
    for number, moment in enumerate((0.1, 0.5, 0.9, 0.1, 0.9)):
        drive = swept(rng)
        load = moment * (1.0 + 0.05 * rng.standard_normal(drive.size).cumsum() / np.sqrt(drive.size))
        pulled = drive - compliance * load
        inside = played(pulled, width, pulled[0] + rng.uniform(-0.5, 0.5) * width)
        seen = ratio * (inside - zero) + noise * rng.standard_normal(drive.size)
        made.append(run(f"r{number}", drive, seen, moment=load))
    return made


@pytest.mark.parametrize("seed", [1, 2])
def test_play_and_cable_stretch_at_several_loads_are_named_with_their_numbers(seed):
    rng = np.random.default_rng(seed)
    width, compliance = rng.uniform(0.15, 0.5), rng.uniform(0.5, 2.0)
    ratio, zero = rng.choice([-1, 1]) * rng.uniform(3.0, 15.0), rng.uniform(-1.0, 1.0)
    runs = cable_runs(rng, width=width, compliance=compliance, ratio=ratio, zero=zero)
    found = diagnose_joint(device(), runs)
    named = {effect.id: effect.parameters for effect in found.effects}
    assert set(named) == {"backlash", "transmission_compliance"}
    assert named["backlash"]["width_mm"].value == pytest.approx(width, rel=0.05)
    assert named["transmission_compliance"]["compliance_mm"].value == pytest.approx(compliance, rel=0.05)
    assert found.parameters["ratio"].value == pytest.approx(ratio, rel=0.02)
    assert found.parameters["zero_mm"].value == pytest.approx(zero, abs=0.05)
    assert found.comparison.with_effects.held_out < 0.03
    assert np.isnan(found.comparison.tip_mm_refitted)
    assert any("no tubes, tendon or notches" in note for note in found.notes)


def test_a_plain_transmission_is_refitted_and_nothing_is_named():
    rng = np.random.default_rng(3)
    runs = [
        run(f"r{k}", drive := swept(rng), -7.0 * (drive - 0.4) + 0.05 * rng.standard_normal(drive.size))
        for k in range(4)
    ]
    found = diagnose_joint(device(), runs)
    assert found.verdict == "parameters"
    assert found.parameters["ratio"].value == pytest.approx(-7.0, rel=0.01)


def test_friction_has_a_constant_part_and_one_in_proportion_to_load():
    rng = np.random.default_rng(4)
    runs = []
    for number, moment in enumerate((0.2, 1.0, 2.0, 0.2, 2.0)):
        drive = swept(rng, 300)
        lag = played(drive, 0.1, drive[0])
        force = 0.4 * (drive - 0.3) + 1.5 * moment + (0.3 + 0.25 * moment) * (drive - lag) / 0.05
        moments = np.full(drive.size, moment)
        runs.append(
            run(f"r{number}", drive, force + 0.01 * rng.standard_normal(drive.size), kind="force", moment=moments)
        )
    found = diagnose_joint(device(0.1), runs)
    (friction,) = found.effects
    assert friction.id == "load_friction"
    for name, value in (("constant_n", 0.3), ("per_load", 0.25)):
        estimate = friction.parameters[name]
        assert estimate.value == pytest.approx(value, rel=0.1)
        assert estimate.value > 3.0 * estimate.std
    assert found.parameters["load_ratio"].value == pytest.approx(1.5, rel=0.05)


def test_a_late_servo_with_a_dead_band_is_play_and_delay():
    rng = np.random.default_rng(5)
    runs = []
    for number, rate in enumerate((1.0, 3.0, 1.0, 3.0)):
        time = np.arange(300) * 0.04
        drive = rng.uniform(4.0, 6.0) * np.arcsin(np.sin(2.0 * np.pi * 0.12 * rate * time + rng.uniform(0.0, 6.0)))
        late = np.interp(time - 0.12, time, played(drive, 0.8, drive[0]))
        seen = 10.0 * late + 0.02 * rng.standard_normal(time.size)
        runs.append(run(f"r{number}", drive, seen, time=time))
    found = diagnose_joint(device(8.0), runs)
    named = {effect.id: effect.parameters for effect in found.effects}
    assert set(named) == {"backlash", "sensor_lag"}
    late = named["sensor_lag"]["delay_s"].value + named["sensor_lag"]["time_constant_s"].value
    assert late == pytest.approx(0.12, abs=0.02)
    assert named["backlash"]["width_mm"].value == pytest.approx(0.8, rel=0.05)


@pytest.fixture(scope="module")
def cable():
    return cable_runs(np.random.default_rng(6), width=0.3, compliance=1.2, ratio=-9.0, zero=0.5)


def test_a_saved_model_foretells_what_it_was_not_fitted_to(cable):
    config = device(-8.0)
    found = diagnose_joint(config, cable[:4])
    text = model_text(config, found, Recordings(Recording("joint", tuple(cable[:4]))))
    rows = {
        row["run"]: row for row in compare(load_config_text(text), Recordings(Recording("joint", (cable[4],)))).rows()
    }
    assert rows["all"]["rmse_bend_deg"] < 0.03
    assert rows["all"]["rmse_curvature_per_m"] is None
    assert rows["all"]["rmse_tip_mm"] is None


def test_it_is_calibrated_inside_the_bounds_that_are_given(cable):
    found = calibrate(
        device("{ value = -8, min = -12, max = -4 }"), Recordings(Recording("joint", tuple(cable))), ["ratio"]
    )
    (row,) = [row for row in found.rows() if row["subset"] == "all"]
    assert -12.0 < row["value"] < -4.0


def test_a_response_of_tubes_is_refused(cable):
    from dataclasses import replace

    with pytest.raises(BadInput, match="no response of a transmission"):
        build_joint_problem(device(), [replace(cable[0], kind="curvature")])
