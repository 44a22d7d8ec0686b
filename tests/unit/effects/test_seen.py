import numpy as np
import pytest

from coast_cli.effects.seen import outside_at, outside_note
from coast_cli.effects.unnamed import UnnamedLaw

LAW = UnnamedLaw("structure", "curvature", "friction", 0.0, 2.0, 30.0, (1.5, 0.2))


def test_nothing_is_said_inside_the_range_that_was_seen():
    assert outside_note(LAW, np.linspace(2.0, 30.0, 50)) == ""
    assert outside_note(LAW, np.array([np.nan, 20.0])) == ""


def test_outside_it_the_share_and_both_ranges_are_said():
    note = outside_note(LAW, np.array([10.0, 20.0, 30.0, 41.0]))
    assert note.startswith("unnamed_1 was seen for kappa from 2 to 30 1/m; 25 % of the rows lie outside (10 to 41 1/m)")


def test_a_period_and_a_step_have_no_range():
    for memory in ("period", "step"):
        law = UnnamedLaw("drive", "stroke", memory, 1e-3, 0.0, 4e-3, (0.1,))
        assert outside_note(law, np.array([1.0])) == ""


@pytest.mark.parametrize("memory", ["none", "friction", "maximum", "path"])
def test_states_of_a_slow_pull_are_looked_at_in_the_units_of_the_law(memory):
    law = UnnamedLaw("tendon", "stroke", memory, 0.0, 0.0, 4e-3, (0.1,))
    state = {"curvature": np.array([5.0]), "tension": np.array([1.0]), "bending_length": np.array([0.03])}
    assert list(outside_at([law], stroke=np.array([3e-3]), **state)) == []
    assert "from 0 to 4 mm" in next(outside_at([law], stroke=np.array([5e-3]), **state))
    assert list(outside_at([law], stroke=None, **state)) == []
