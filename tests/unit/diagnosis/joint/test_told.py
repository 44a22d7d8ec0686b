"""From a seed to a sentence: recordings of a bench that shares nothing with the package, of what no name explains."""

from dataclasses import replace

import pytest

from coast_cli.diagnosis.fit import fit
from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.diagnosis.joint.told import known_of
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.spec.load import REFERENCE, load_config
from tests.fibre_joint import World, recorded, work_of_a_loop
from tests.modelled_joint import problem_of

CONFIG = load_config(REFERENCE)
HEIGHTS = ((0.030, 3.6e-3), (0.028, 3.5e-3), (0.032, 3.7e-3))  # at which all lengths bend alike


def diagnosed(world, *without, **options):
    return diagnose_joint(CONFIG, recorded(world, **options), most_effects=1, without=without)


def test_a_bench_without_anything_left_out_agrees():
    answer = diagnosed(World(), witness=True)
    assert answer.verdict == "agrees"
    assert answer.unnamed is None


def test_an_eccentric_pulley_is_told_with_its_period_and_size():
    answer = diagnosed(World(pulley=(0.06e-3, 1.3e-3)))
    told = answer.unnamed
    assert answer.verdict == "unnamed"
    assert (told.stages, told.variables, told.memory, told.rate) == (("drive",), ("stroke",), False, False)
    assert "an added stroke that swings by 0.06 mm with the stroke, period 1.3" in told.words
    assert "it does not remember, speed does not matter" in told.words
    assert "Not held by this recording: drive or tendon, as there is no tension_n" in told.words
    assert told.equation.startswith("X1 -> X1 + g, g = 0.0")
    assert "*sin(2*pi*X1/1.3" in told.equation
    assert answer.comparison.with_effects.held_out < 1.2 * answer.noise < 0.4 * answer.comparison.refitted.held_out


def test_a_tendon_that_wears_is_told_by_its_path_and_rate():
    answer = diagnosed(World(wear=0.02))
    told = answer.unnamed
    assert answer.verdict == "unnamed"
    assert (told.stages, told.memory, told.rate) == (("drive",), True, False)
    assert told.laws[0].memory == "path"
    assert (
        "a lost stroke that rises with the path that the stroke has travelled from 0 mm at 0 mm to 0.19 mm"
        in told.words
    )
    assert "the drive remembers, speed does not matter" in told.words
    slope = float(told.equation.partition("g = -")[2].partition("*y")[0].split(" ")[-1])
    assert slope == pytest.approx(0.02, rel=0.1)
    assert "y = path of X1" in told.equation
    half = [high - low for high, low in zip(told.curves[0].high, told.curves[0].low, strict=True)]
    assert 0.0 < max(half) < 0.1


def test_a_viscous_sheath_is_told_as_a_moment_of_the_structure_that_fades_and_dissipates():
    concealed = ("viscous_friction", "sensor_lag", "tendon_creep", "thermal_drift", "backlash", "coulomb_friction")
    rest = ("capstan_hysteresis", "snap_through", "tube_hysteresis", "distributed_notch_friction")
    drag = 0.25
    answer = diagnosed(World(drag=drag), *concealed, *rest, witness=True)
    told = answer.unnamed
    assert answer.verdict == "unnamed"
    assert (told.stages, told.variables) == (("structure",), ("curvature",))
    assert (told.memory, told.rate, told.dissipative) == (True, True, True)
    assert "an added bending moment (as EI times curvature) that comes at once and fades" in told.words
    assert "the structure remembers, speed matters; dissipates" in told.words
    assert told.energy_uj == pytest.approx(6.3, rel=0.2)
    share, late = told.parameters["weight_0"], told.laws[0].setting
    reach = max(abs(told.laws[0].low), abs(told.laws[0].high))
    assert -share / reach * late == pytest.approx(drag, rel=0.15)  # of EI, in seconds, as the sheath has it
    assert answer.comparison.with_effects.held_out < 1.2 * answer.noise < 0.5 * answer.comparison.refitted.held_out


def test_a_superelastic_loop_is_told_as_a_moment_that_softens_and_rubs_between_the_plateaus():
    concealed = ("tube_hysteresis", "tube_superelasticity", "snap_through", "capstan_hysteresis", "coulomb_friction")
    plans = [
        (x2, top, pace) for (x2, top), pace in zip((*HEIGHTS, *HEIGHTS[:2]), (1.0, 4.0, 0.3, 2.0, 0.5), strict=True)
    ]
    world = World(plateaus=(0.0022, 0.0015))
    answer = diagnosed(world, *concealed, "backlash", "distributed_notch_friction", witness=True, plans=plans)
    told = answer.unnamed
    assert answer.verdict == "unnamed"
    assert "structure" in told.stages
    assert told.variables == ("curvature",)
    assert (told.memory, told.rate, told.dissipative) == (True, False, True)
    assert "an added bending moment (as EI times curvature) that rises with the curvature" in told.words
    assert "and then falls" in told.words
    assert "in a loop to 3.7 mm and back at X2 = 32 mm" in told.words
    assert told.energy_uj == pytest.approx(1e6 * work_of_a_loop(world, 3.7e-3, 0.032), rel=0.25)
    assert answer.comparison.with_effects.held_out < 0.4 * answer.comparison.refitted.held_out


def test_without_a_clock_nothing_is_claimed_of_speed_and_the_rest_is_said():
    runs = [replace(run, time=None) for run in recorded(World(wear=0.02))]
    told = diagnose_joint(CONFIG, runs, most_effects=1).unnamed
    assert (told.stages, told.memory, told.rate) == (("drive",), True, None)
    assert "whether speed or time matters, as there is no time_s" in told.words
    assert "the path that the stroke has travelled" in told.words
    assert "speed does not matter" not in told.words


def test_what_a_recording_cannot_hold_is_listed():
    law = UnnamedLaw("structure", "curvature", "friction", 1e-4, 0.0, 40.0, (0.5,))
    (run,) = recorded(World(), plans=((0.035, 3.8e-3, 1.0),))
    names = ("line", "time", "stroke", "response", "bending_length")
    up = replace(run, **{name: getattr(run, name)[:40] for name in names})
    for runs, clauses in (
        ([run], ("speed matters, as the drive has one rate", "one bending length", "there is one run")),
        ([replace(run, time=None)], ("there is no time_s", "one bending length", "there is one run")),
        ([up], ("there is no release", "one rate and no hold", "one bending length", "there is one run")),
    ):
        problem = problem_of(runs)
        known = known_of(problem, fit(problem, (law,), steps=0), None)
        assert len(known.open) == len(clauses)
        assert all(clause in said for clause, said in zip(clauses, known.open, strict=True))
        assert known.memory == ("release" not in " ".join(known.open))
        assert not known.rate
