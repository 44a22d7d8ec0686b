"""How far names are to be believed falls with everything that speaks against them, and with nothing else."""

from dataclasses import fields, replace

import pytest

from coast_cli.diagnosis.joint.odds import Against
from coast_cli.diagnosis.thresholds import NAMED_FROM

NOTHING = Against(*(0.0 for _ in fields(Against)))


def test_names_against_which_nothing_speaks_are_given():
    assert NOTHING.certainty > NAMED_FROM


@pytest.mark.parametrize("figure", [field.name for field in fields(Against)])
def test_what_speaks_against_names_never_speaks_for_them(figure):
    assert replace(NOTHING, **{figure: 1.0}).certainty <= NOTHING.certainty


def test_names_that_leave_many_noise_widths_are_not_given():
    assert replace(NOTHING, left=3.0, unseen=2.0, beside=1.0).certainty < 0.5


def test_the_table_holds_every_figure():
    assert list(NOTHING.table()) == [field.name for field in fields(Against)]
