import pytest

from coast_cli.effects.catalogue import build_effects
from coast_cli.effects.shapes.catalogue import build_shape_effects
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.errors import BadInput
from coast_cli.spec.load import load_config_text

LAW = UnnamedLaw("structure", "curvature", "friction", 0.0, 0.0, 40.0, (1.5, 0.2))


@pytest.mark.parametrize(("identifier", "values"), [("camera_scale", {"scale": 1.2}), ("tip_load", {"force_mn": 2.0})])
def test_what_a_bench_or_a_camera_has_stays_with_its_kind_of_recording(identifier, values):
    of_shapes = {identifier: {**values, "recording": "shapes"}}
    assert build_effects(of_shapes) == ()
    assert [effect.id for effect in build_shape_effects(of_shapes)] == [identifier]
    of_joint = {identifier: {**values, "recording": "joint"}}
    assert [effect.id for effect in build_effects(of_joint)] == [identifier]
    assert build_shape_effects(of_joint) == ()


def test_what_a_tube_has_goes_along():
    for kind in ("shapes", "joint"):
        table = {"notch_end_effect": {"table_share": 1.0, "recording": kind}}
        assert [effect.id for effect in build_effects(table)] == ["notch_end_effect"]
        assert [effect.id for effect in build_shape_effects(table)] == ["notch_end_effect"]


def test_a_law_without_a_name_is_loaded_from_its_table():
    assert build_effects({"unnamed_1": LAW.table()}) == (LAW,)


@pytest.mark.parametrize(
    ("change", "word"),
    [("weights = [1.5]", "missing"), ("stage = 'gearbox'", "gearbox"), ("weights = []", "1 to 64")],
)
def test_a_damaged_law_is_refused_with_its_line(reference_text, change, word):
    table = {**LAW.table(), "weights": [1.0]}
    lines = [f"{k} = {v!r}" for k, v in table.items() if k not in change or word == "missing"]
    if word == "missing":
        lines = [line for line in lines if not line.startswith("high")]
    else:
        lines.append(change)
    text = reference_text + "\n[corrections.unnamed_1]\n" + "\n".join(lines) + "\n"
    with pytest.raises(BadInput, match="damaged law") as refused:
        load_config_text(text, "bench.toml")
    assert word in str(refused.value)
    assert "bench.toml" in str(refused.value)


def test_a_number_that_is_none_is_refused():
    with pytest.raises(BadInput, match="not a number"):
        build_effects({"backlash": {"width_mm": "wide"}})
