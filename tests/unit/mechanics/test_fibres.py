import numpy as np
import pytest

from coast_cli.errors import NotConverged
from coast_cli.mechanics.fibres import bar_fibres, moment_curvature, moment_history, ring_fibres, strip_fibres
from coast_cli.mechanics.section import full_section, notched_section
from coast_cli.mechanics.superelastic import Superelastic

RADII = 0.25e-3, 0.2e-3
DEPTHS = np.array([0.25e-3, 0.314e-3, 0.35e-3, 0.4e-3])
LAW = Superelastic(45e9, 25e9, 450e6, 180e6, 0.046, 0.5e9, 1.2)


@pytest.mark.parametrize("kind", ["sector", "chord"])
def test_layers_have_the_section_properties(kind):
    fibres, section = strip_fibres(*RADII, DEPTHS, kind), notched_section(*RADII, DEPTHS, kind)
    assert fibres.area.sum(axis=-1) == pytest.approx(section.area, rel=1e-13)
    assert fibres.centroid == pytest.approx(section.neutral_axis, rel=1e-13)
    assert fibres.inertia == pytest.approx(section.second_moment, rel=1e-12)
    assert fibres.high + fibres.centroid == pytest.approx(RADII[0])


def test_layers_of_ring_and_bar():
    assert ring_fibres(*RADII).inertia == pytest.approx(full_section(*RADII).second_moment, rel=1e-13)
    assert ring_fibres(*RADII).centroid == pytest.approx(0.0, abs=1e-18)
    assert bar_fibres(2e-3, 3e-3).inertia == pytest.approx(2e-3 * 3e-3**3 / 12.0, rel=1e-13)


@pytest.mark.parametrize("kind", ["sector", "chord"])
@pytest.mark.parametrize("unloading", [False, True])
def test_below_the_plateau_the_section_is_linear(kind, unloading):
    fibres = strip_fibres(*RADII, DEPTHS, kind)
    most = (0.4 if unloading else 1.0) * LAW.yield_strain / fibres.reach
    kappa = np.linspace(-1.0, 1.0, 9) * most[:, None]
    moment, centre = moment_curvature(fibres, LAW, kappa, unloading=unloading)
    assert moment == pytest.approx(45e9 * fibres.inertia[:, None] * kappa, rel=1e-12)
    assert np.abs(centre).max() < 1e-17


def test_the_force_is_balanced_with_and_without_a_pull():
    fibres, kappa = strip_fibres(*RADII, DEPTHS), np.linspace(-900.0, 900.0, 19)
    for force in (0.0, 1.5, -1.5):
        _, centre = moment_curvature(fibres, LAW, kappa, axial_force=force)
        strain = kappa[:, None] * fibres.position[:, None, :] + centre[..., None]
        carried = (LAW.loading_stress(strain) * fibres.area[:, None, :]).sum(axis=-1)
        assert carried == pytest.approx(force, abs=1e-9)


def test_the_neutral_axis_moves_to_the_side_that_is_stiffer():
    fibres = bar_fibres(0.2e-3, 0.2e-3)
    _, centre = moment_curvature(fibres, LAW, [300.0])
    assert centre[0] > 1e-4  # compression is the stiffer one: the centroid is stretched


def test_a_history_upwards_is_the_envelope_and_cycles_close():
    fibres = strip_fibres(*RADII, DEPTHS)
    up = np.linspace(0.0, 800.0, 41)
    moment, _ = moment_history(fibres, LAW, np.concatenate((up, up[::-1], up)))
    envelope, _ = moment_curvature(fibres, LAW, up)
    assert moment[:, :41] == pytest.approx(envelope, rel=3e-4)  # layers that the neutral axis passes turn back
    assert moment[:, 81] == pytest.approx(0.0, abs=1e-9)
    assert moment[:, 82:] == pytest.approx(moment[:, :41], rel=1e-9, abs=1e-12)
    assert np.all(np.trapezoid(moment[:, :82], np.concatenate((up, up[::-1]))) > 0.0)


def test_a_section_comes_back_on_the_unloading_envelope():
    fibres, up = bar_fibres(0.1e-3, 0.1e-3), np.linspace(0.0, 1800.0, 200)
    moment, _ = moment_history(fibres, LAW, np.concatenate((up, up[::-1])))
    lower, _ = moment_curvature(fibres, LAW, up, unloading=True)
    near_zero = up < 0.5 * LAW.lower_plateau / LAW.austenite_modulus / 0.05e-3
    assert moment[200:][::-1][near_zero] == pytest.approx(lower[near_zero], rel=1e-9, abs=1e-15)


def test_layers_converge_with_the_square_of_their_height():
    def moment(layers):
        return moment_curvature(strip_fibres(*RADII, 0.314e-3, layers=layers), LAW, np.linspace(250.0, 800.0, 40))[0]

    exact = moment(1024)
    errors = [np.sqrt(np.mean((moment(layers) / exact - 1.0) ** 2)) for layers in (8, 16, 32, 64)]
    assert np.polyfit(np.log([8, 16, 32, 64]), np.log(errors), 1)[0] < -1.7
    assert errors[2] < 2e-3


def test_an_impossible_force_is_refused():
    with pytest.raises(NotConverged, match="no neutral axis"):
        moment_curvature(bar_fibres(1e-4, 1e-4), LAW, [np.nan])
