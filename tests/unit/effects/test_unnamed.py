import numpy as np
import pytest

from coast_cli.effects.catalogue import in_order
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.camera_scale import CameraScale
from coast_cli.effects.library.coulomb_friction import CoulombFriction
from coast_cli.effects.library.precurvature import Precurvature
from coast_cli.effects.library.sensor_lag import SensorLag
from coast_cli.effects.library.tendon_creep import TendonCreep
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config

JOINT = build_joint(load_config(REFERENCE), "OT4", "MT1")
STROKE = np.concatenate([np.linspace(0, 4e-3, 60), np.full(20, 4e-3), np.linspace(4e-3, 0.5e-3, 60)])
RUN = History(np.arange(STROKE.size) * 0.5, STROKE, None, np.full(STROKE.size, 0.03))
LAYOUT = Layout("curvature", 1, 120.0)


def response(*effects):
    return predict(JOINT, effects, [RUN], LAYOUT)[0].response[:, 0]


def law(place, variable, memory, weights, setting=0.0, low=0.0, high=1.0):
    return UnnamedLaw(place, variable, memory, setting, low, high, tuple(weights))


@pytest.mark.parametrize("place", ["drive", "tendon", "transmission", "structure", "sensor", "load_cell"])
@pytest.mark.parametrize("memory", ["none", "friction", "relaxation", "maximum", "path", "step", "period"])
def test_without_amplitude_a_law_changes_nothing(place, memory):
    nothing = law(place, "tension", memory, [0.0] if memory == "step" else [0.0, 0.0], setting=1.0)
    assert response(nothing) == pytest.approx(response(), abs=1e-9)


def test_the_catalogue_can_be_written_in_the_grammar():
    slope = response(CameraScale(scale=1.1))
    line = law("sensor", "curvature", "none", [0.0, 0.1 * 60.0], low=-60.0, high=60.0)
    assert response(line) == pytest.approx(slope, abs=1e-9)
    bent = law("structure", "curvature", "none", [-4.0])
    assert response(bent) == pytest.approx(response(Precurvature(curvature_per_m=4.0)), abs=1e-9)
    rub = law("structure", "curvature", "friction", [3.0])
    assert response(rub) == pytest.approx(response(CoulombFriction(holds_per_m=3.0)), abs=1e-9)
    play = law("drive", "stroke", "friction", [0.1])
    by_name = predict(JOINT, [Backlash(width_mm=0.2)], [RUN], LAYOUT)[0].response[:, 0]
    moved = History(RUN.time, STROKE + 0.1e-3, None, RUN.bending_length)
    anchored = predict(JOINT, [play], [moved], LAYOUT)[0].response[:, 0]
    assert anchored[5:] == pytest.approx(by_name[5:], abs=0.05)
    lag = law("sensor", "curvature", "relaxation", [50.0], setting=1.5, low=-50.0, high=50.0)
    assert response(lag) == pytest.approx(response(SensorLag(time_constant_s=1.5)), abs=1e-9)
    stiffness = JOINT.tendon.stiffness
    creep = law("tendon", "tension", "relaxation", [0.1 * 5.0 / stiffness * 1e3], setting=9.0, low=-5.0, high=5.0)
    soft = law("tendon", "tension", "none", [0.1 * 2.5 / stiffness * 1e3], low=0.0, high=5.0)
    assert response(creep, soft) == pytest.approx(response(TendonCreep(fraction=0.1, time_constant_s=9.0)), abs=1e-3)


def test_friction_never_adds_energy():
    back = law("structure", "curvature", "friction", [-3.0, 1.0], high=60.0)
    curvature = response(back)
    tension = predict(JOINT, [back], [RUN], LAYOUT)[0].tension
    area = float(np.sum(0.5 * (tension[1:] + tension[:-1]) * np.diff(curvature)))
    assert area > -1e-9


def test_a_law_survives_its_table_and_a_damaged_table_is_refused():
    before = law("tendon", "tension", "relaxation", [0.2, -0.1], setting=4.0, low=-1.0, high=3.0)
    assert UnnamedLaw.from_table(before.table(), 1) == before
    for change, word in (
        ({"stage": "gearbox"}, "gearbox"),
        ({"weights": []}, "weights"),
        ({"high": -2.0}, "above low"),
        ({"low": float("nan")}, "finite"),
        ({"gain": 1.0}, "gain"),
    ):
        with pytest.raises(ValueError, match=word):
            UnnamedLaw.from_table({**before.table(), **change}, 1)


def test_values_go_through_a_fit_and_back():
    before = law("sensor", "curvature", "relaxation", [2.0], setting=1.5)
    assert before.with_values(np.array(before.values())) == before
    assert [parameter.name for parameter in before.parameters] == ["weight_0", "setting"]
    assert before.outside(np.array([0.5, 2.0])) == 0.5


def test_laws_act_at_their_stage_after_what_has_a_name():
    laws = (law("sensor", "time", "none", [1.0]), law("drive", "time", "none", [1.0]))
    found = in_order((*laws, CameraScale(scale=1.1), Backlash(width_mm=0.1)))
    assert [effect.id for effect in found] == ["backlash", "unnamed_1", "camera_scale", "unnamed_1"]
