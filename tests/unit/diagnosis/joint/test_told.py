"""From a seed to a sentence: recordings of a bench that shares nothing with the package, of what no name explains."""

import pytest

from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.spec.load import REFERENCE, load_config
from tests.fibre_joint import World, recorded

CONFIG = load_config(REFERENCE)


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
