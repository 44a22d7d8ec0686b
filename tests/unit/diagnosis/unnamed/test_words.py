import numpy as np
import pytest

from coast_cli.diagnosis.unnamed.forms import curve_of, typed
from coast_cli.diagnosis.unnamed.words import describe
from coast_cli.effects.unnamed import UnnamedLaw


def fitted_to(values_of, *, place="drive", variable="stroke", low=0.0, high=4e-3, count=8, memory="none"):
    """A law whose series is closest to a curve over its range (in display units)."""
    law = UnnamedLaw(place, variable, memory, 0.0, low, high, (0.0,) * count)
    along = np.linspace(low, high, 400)
    columns = law.basis(along)
    weights = np.linalg.lstsq(columns, values_of(along), rcond=None)[0]
    return law.with_values(weights)


@pytest.mark.parametrize(
    ("name", "curve"),
    [
        ("a line", lambda x: 30.0 * x),
        ("a square", lambda x: 1e4 * x**2),
        ("a knee", lambda x: 60.0 * np.maximum(x - 2e-3, 0.0)),
        ("a saturating curve", lambda x: 0.1 * np.tanh(x / 1.4e-3)),
        ("a hump", lambda x: 0.1 * (np.exp(-0.5 * ((x - 2e-3) / 8e-4) ** 2))),
    ],
)
def test_a_short_form_is_found_where_one_holds_to_a_tenth(name, curve):
    form = typed(fitted_to(curve))
    assert form is not None
    assert form.name == name
    assert form.missed < 0.1


def test_no_short_form_is_claimed_of_a_curve_that_has_none():
    assert typed(fitted_to(lambda x: 0.1 * np.sin(2.6e3 * np.pi * x / 4.0) + 0.08 * np.cos(7e3 * x), count=12)) is None


def test_what_is_said_is_what_all_laws_agree_on():
    rubs = UnnamedLaw("structure", "curvature", "friction", 0.0, 0.0, 40.0, (1.0,))
    late = UnnamedLaw("structure", "curvature", "relaxation", 2.0, -5.0, 5.0, (-1.0,))
    both = describe([rubs, late], "curvature")
    assert (both.memory, both.rate, both.dissipative) == (True, None, True)
    assert both.stages == ("structure",)
    assert "speed" not in both.words
    alone = describe([rubs], "curvature", [("coulomb_friction", 0.4)])
    assert "speed does not matter" in alone.words
    assert "coulomb friction (leaves 0.4 noise widths)" in alone.words
    assert alone.equation == "M -> M +- EI g, g = 1 (1/m of curvature times EI)"


def test_a_wave_says_its_period():
    wave = UnnamedLaw("drive", "stroke", "period", 0.635e-3, 0.0, 4e-3, (0.03, 0.04))
    said = describe([wave], "curvature")
    assert "period 0.635 mm" in said.words
    assert "0.05 sin" in said.equation
    assert len(curve_of(wave)[0]) == len(said.curve[0])
