import numpy as np
import pytest

from coast_cli.diagnosis.unnamed.forms import Display, curve_of, drawn, equation, typed
from coast_cli.diagnosis.unnamed.trend import added_by
from coast_cli.diagnosis.unnamed.words import Known, describe
from coast_cli.effects.unnamed import UnnamedLaw

BENT = Display("curvature")
TYPED = {"exp": np.exp, "tanh": np.tanh, "sin": np.sin, "cos": np.cos, "max": np.maximum, "pi": np.pi}


def fitted_to(values_of, *, place="drive", variable="stroke", low=0.0, high=4e-3, count=8, memory="none"):
    """A law whose series is closest to a curve over its range (in display units)."""
    law = UnnamedLaw(place, variable, memory, 0.0, low, high, (0.0,) * count)
    along = np.linspace(low, high, 400)
    columns = law.basis(along)
    weights = np.linalg.lstsq(columns, values_of(along), rcond=None)[0]
    return law.with_values(weights)


CURVES = [
    ("constant", lambda x: 0.1 + 0.0 * x),
    ("a line", lambda x: 30.0 * x),
    ("a square", lambda x: 1e4 * x**2),
    ("a knee", lambda x: 60.0 * np.maximum(x - 2e-3, 0.0)),
    ("a square beyond a knee", lambda x: 3e7 * np.maximum(x - 1e-3, 0.0) ** 3),
    ("a saturating curve", lambda x: 0.1 * np.tanh(x / 1.4e-3)),
    ("a hump", lambda x: 0.1 * (np.exp(-0.5 * ((x - 2e-3) / 8e-4) ** 2))),
]


@pytest.mark.parametrize(("name", "curve"), CURVES, ids=[name for name, _ in CURVES])
def test_a_short_form_is_found_where_one_holds_to_a_tenth_and_can_be_typed(name, curve):
    law = fitted_to(curve, memory="friction" if name == "constant" else "none")
    form = typed(law, "X1", 1e-3)
    assert form is not None
    assert form.name == name
    assert form.missed < 0.1
    along, values = curve_of(law)
    again = eval(form.text.replace("^", "**"), {"__builtins__": {}}, {**TYPED, "X1": along / 1e-3})
    assert np.sqrt(np.mean((again - values) ** 2)) < 0.1 * np.sqrt(np.mean(values**2))


def test_no_short_form_is_claimed_of_a_curve_that_has_none():
    law = fitted_to(lambda x: 0.1 * np.sin(2.6e3 * np.pi * x / 4.0) + 0.08 * np.cos(7e3 * x), count=12)
    assert typed(law) is None
    curve = drawn(law, BENT)
    assert "as in the table" in equation(curve)
    assert len(curve.rows()) == 7
    assert curve.names() == ("X1 (mm)", "added stroke (mm)")


def test_what_is_said_is_what_all_explanations_agree_on():
    rubs = UnnamedLaw("structure", "curvature", "friction", 0.0, 0.0, 40.0, (1.0,))
    late = UnnamedLaw("structure", "curvature", "relaxation", 2.0, -5.0, 5.0, (-1.0,))
    both = describe([[rubs], [late]], BENT)
    assert (both.memory, both.rate, both.dissipative) == (True, None, True)
    assert both.stages == ("structure",)
    assert "speed" not in both.words
    assert "cannot tell it from an added bending moment (as EI times curvature) that comes at once" in both.words
    alone = describe([[rubs]], BENT, [("coulomb_friction", 0.4)])
    assert "the structure remembers, speed does not matter" in alone.words
    assert "coulomb friction (leaves 0.4 noise widths)" in alone.words
    assert alone.equation == "M -> M + EI*g on load, M - EI*g on release, g = 1, g in 1/m, kappa from 0 to 40 1/m"


def test_a_second_law_is_a_part_of_the_explanation_and_no_rival_of_it():
    bent = UnnamedLaw("structure", "curvature", "none", 0.0, 0.0, 40.0, (0.0, -4.0))
    play = UnnamedLaw("drive", "stroke", "friction", 0.0, 0.0, 4e-3, (0.1,), number=2)
    both = describe([[bent, play]], BENT)
    assert "together with play of the drive to either side, 0.1 mm throughout" in both.words
    assert "cannot tell" not in both.words
    assert both.memory is True
    assert len(both.curves) == 2
    assert "; X1 with a play of g to either side, g = 0.1" in both.equation


def test_what_the_recording_cannot_hold_is_open_and_the_rest_is_said():
    play = UnnamedLaw("drive", "stroke", "friction", 0.0, 0.0, 4e-3, (0.1,))
    known = Known(rate=False, open=("whether speed or time matters, as there is no time_s",), held_out=(5.13, 1.08))
    told = describe([[play]], BENT, known=known)
    assert (told.memory, told.rate) == (True, None)
    assert "Not held by this recording: whether speed or time matters" in told.words
    assert "the drive remembers" in told.words
    assert "Held out: 5.1 to 1.1 times the noise." in told.words
    assert describe([[play]], BENT, known=Known(memory=False)).memory is None


def test_energy_is_said_where_the_laws_take_it():
    rubs = UnnamedLaw("structure", "curvature", "friction", 0.0, 0.0, 40.0, (1.0,))
    told = describe([[rubs]], BENT, known=Known(energy=12.3e-6, loop="a loop to 4 mm and back"))
    assert "dissipates 12 uJ in a loop to 4 mm and back" in told.words
    assert told.energy_uj == pytest.approx(12.3)
    assert "dissipates" not in describe([[rubs]], BENT, known=Known(energy=-1e-6)).words


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (
            fitted_to(lambda x: 60.0 * np.maximum(x - 2e-3, 0.0), count=12),
            "an added stroke that rises with the stroke beyond 2.2 mm, from 0 mm to 0.12 mm at 4 mm",
        ),
        (
            fitted_to(lambda x: -30.0 * x),
            "a lost stroke that rises with the stroke from 0 mm at 0 mm to 0.12 mm at 4 mm",
        ),
        (
            fitted_to(lambda x: 8.0 * np.sin(np.pi * x / 40.0), place="structure", variable="curvature", high=40.0),
            "rises with the curvature from 0 1/m at 0 1/m to 8 1/m at 20 1/m and then falls to 0 1/m at 40 1/m",
        ),
        (
            UnnamedLaw("tendon", "tension", "relaxation", 2.16, -1.0, 1.0, (0.2,)),
            "that comes late, 0.2 mm per N of the tension, with a time constant of 2.2 s",
        ),
        (
            UnnamedLaw("sensor", "curvature", "relaxation", 1.5, -5.0, 5.0, (5.0,)),
            "a part of what the camera shows that comes late, 100 % of the curvature",
        ),
        (
            UnnamedLaw("drive", "stroke", "period", 0.635e-3, 0.0, 4e-3, (0.03, 0.04)),
            "an added stroke that swings by 0.05 mm with the stroke, period 0.635 mm",
        ),
        (UnnamedLaw("sensor", "time", "step", 12.0, 0.0, 1.0, (-2.0,)), "too small of 2 1/m that sets in at 12 s"),
        (
            fitted_to(lambda x: 2.0 * x, place="tendon", variable="tension", memory="maximum", high=3.0, count=3),
            "rises with the largest tension so far from 0 mm at 0 N to 6 mm at 3 N",
        ),
        (
            fitted_to(lambda x: 5.0 * x, variable="stroke", memory="path", high=0.02, count=3),
            "rises with the path that the stroke has travelled from 0 mm at 0 mm to 0.1 mm at 20 mm",
        ),
    ],
)
def test_a_law_is_said_with_its_numbers_and_units(law, words):
    assert words in added_by(law, BENT)


def test_units_follow_the_recording():
    seen = UnnamedLaw("sensor", "curvature", "none", 0.0, 0.0, np.radians(60.0), (np.radians(3.0),))
    assert "is 3 degrees throughout" in added_by(seen, Display("bend"))
    assert drawn(seen, Display("bend")).axis == "theta (degrees)"
    pulled = UnnamedLaw("drive", "path", "none", 0.0, 0.0, 4.0, (0.2, 0.1))
    assert "N at" in added_by(pulled, Display("curvature", driven_by_tension=True))
    assert drawn(pulled, Display("curvature", driven_by_tension=True)).unit == "added tension (N)"


def test_the_band_is_that_of_the_amplitudes():
    law = UnnamedLaw("structure", "curvature", "none", 0.0, 0.0, 40.0, (1.0, 0.5))
    curve = drawn(law, BENT, np.diag([0.04, 0.01]))
    assert curve.high[60] - curve.y[60] == pytest.approx(1.645 * 0.2, rel=1e-3)
    assert curve.high[-1] - curve.y[-1] == pytest.approx(1.645 * np.hypot(0.2, 0.1), rel=1e-3)
    assert curve.names()[2:] == ("90 % from", "to")
    assert drawn(law, BENT, np.full((2, 2), np.nan)).low == ()


@pytest.mark.parametrize("place", ["drive", "tendon", "transmission", "structure", "sensor", "load_cell"])
@pytest.mark.parametrize("memory", ["none", "friction", "relaxation"])
def test_labels_fit_beside_a_small_picture(place, memory):
    law = UnnamedLaw(place, "tension", memory, 1.0, 0.0, 3.0, (0.1, 0.2))
    for display in (BENT, Display("bend"), Display("notch", driven_by_tension=True)):
        assert len(drawn(law, display).unit) < 36
