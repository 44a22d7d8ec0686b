import numpy as np
import pytest

from coast_cli.mechanics.superelastic import Superelastic

LAW = Superelastic(50e9, 30e9, 450e6, 180e6, 0.046, 0.8e9, 1.3)


def path(law, strain):
    """Return the stress along a history of strain, from austenite, one clip a step."""
    fraction, stresses = np.zeros(1), []
    for value in strain:
        fraction = law.fraction(np.array([value]), fraction)
        stresses.append(law.stress(np.array([value]), fraction)[0])
    return np.array(stresses)


def test_elastic_below_the_plateau_is_exact():
    strain = np.linspace(-LAW.yield_strain, LAW.yield_strain, 21)
    assert LAW.loading_stress(strain) == pytest.approx(50e9 * strain, rel=1e-14)


def test_envelopes_pass_through_the_corners():
    start, end = 450e6 / 50e9, 450e6 / 50e9 + 0.046
    top = 450e6 + 0.8e9 * 0.046
    assert LAW.loading_stress(np.array([start, end, end + 0.01])) == pytest.approx([450e6, top, top + 30e9 * 0.01])
    assert LAW.unloading_stress(np.array([180e6 / 50e9])) == pytest.approx([180e6])
    back = end - 270e6 / 30e9  # down the martensite line by the width of the loop
    assert LAW.unloading_stress(np.array([back])) == pytest.approx([top - 270e6])


def test_compression_has_higher_and_shorter_plateaus_of_equal_work():
    start = 1.3 * 450e6 / 50e9
    assert LAW.loading_stress(np.array([-start])) == pytest.approx([-1.3 * 450e6])
    end = start + 0.046 / 1.3
    assert LAW.fraction_loading(np.array([-end])) == pytest.approx([-1.0])
    equal = Superelastic(50e9, 30e9, 450e6, 180e6, 0.046, 0.8e9, 1.0)
    strain = np.linspace(0.0, 0.08, 50)
    assert equal.loading_stress(-strain) == pytest.approx(-equal.loading_stress(strain))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_loop_closes_and_dissipates_and_an_inner_loop_lies_inside(sign):
    up, down = np.linspace(0.0, 0.04, 401), np.linspace(0.04, 0.0, 401)
    strain = sign * np.concatenate((up, down))
    stress = path(LAW, strain)
    assert stress[-1] == pytest.approx(0.0, abs=1e-3)
    assert np.trapezoid(stress, strain) > 0.5 * 270e6 * 0.02
    inner = sign * np.concatenate((up, np.linspace(0.04, 0.03, 101), np.linspace(0.03, 0.04, 101)))
    found = sign * path(LAW, inner)
    assert found[-1] == pytest.approx(found[400])  # return-point memory
    assert np.all(found[401:] <= np.abs(LAW.loading_stress(inner[401:])) + 1.0)
    assert np.trapezoid(found[400:], sign * inner[400:]) > 0.0


def test_a_history_on_one_side_is_the_envelope():
    strain = np.linspace(0.0, 0.09, 300)
    assert path(LAW, strain) == pytest.approx(LAW.loading_stress(strain))
    assert path(LAW, -strain) == pytest.approx(LAW.loading_stress(-strain))
    assert path(LAW, np.concatenate((strain, strain[::-1])))[300:] == pytest.approx(LAW.unloading_stress(strain[::-1]))


def test_temperature_moves_both_plateaus_and_a_modulus_scales_both_phases():
    warm = LAW.warmer(15.0)
    assert (warm.upper_plateau, warm.lower_plateau) == pytest.approx((547.5e6, 277.5e6))
    soft = LAW.with_modulus(42.6e9)
    assert soft.martensite_modulus / soft.austenite_modulus == pytest.approx(0.6)
    assert soft.upper_plateau == LAW.upper_plateau


def test_rest_strain_is_where_the_mixture_carries_nothing():
    fraction = np.linspace(-1.0, 1.0, 11)
    assert LAW.stress(LAW.rest_strain(fraction), fraction) == pytest.approx(0.0, abs=1e-6)
