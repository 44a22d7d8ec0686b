import re

import pytest

from coast_cli.effects.catalogue import build_effects
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.errors import BadInput
from coast_cli.spec.load import load_config_text

LAW = UnnamedLaw("structure", "curvature", "friction", 0.0, 0.0, 40.0, (1.5, 0.2))


@pytest.mark.parametrize(("identifier", "values"), [("camera_scale", {"scale": 1.2}), ("tip_load", {"force_mn": 2.0})])
def test_what_a_bench_or_a_camera_has_stays_with_its_kind_of_recording(identifier, values):
    of_shapes = {identifier: {**values, "recording": "shapes"}}
    assert build_effects(of_shapes) == ()
    assert [effect.id for effect in build_effects(of_shapes, "shapes")] == [identifier]
    of_joint = {identifier: {**values, "recording": "joint"}}
    assert [effect.id for effect in build_effects(of_joint)] == [identifier]
    assert build_effects(of_joint, "shapes") == ()


def test_what_a_tube_has_goes_along():
    for kind in ("shapes", "joint"):
        table = {"notch_end_effect": {"table_share": 1.0, "recording": kind}}
        assert [effect.id for effect in build_effects(table)] == ["notch_end_effect"]
        assert [effect.id for effect in build_effects(table, "shapes")] == ["notch_end_effect"]


def test_a_law_without_a_name_is_loaded_from_its_table():
    assert build_effects({"unnamed_1": LAW.table()}) == (LAW,)


def law_text(changes=(), **values):
    table = {**LAW.table(), **values}
    lines = [f"{key} = {value!r}" for key, value in table.items() if value is not None]
    return "\n[corrections.unnamed_1]\n" + "\n".join([*lines, *changes]) + "\n"


DAMAGES = [
    *(({key: None}, f"{key} is missing") for key in LAW.table()),
    *(({key: "gearbox"}, "gearbox") for key in ("stage", "variable", "memory")),
    *(({key: 1.0}, f"{key} is 1.0; allowed") for key in ("stage", "variable", "memory")),
    *(({key: [1.0]}, f"{key} is") for key in ("stage", "variable", "memory", "setting", "low", "high")),
    *(({key: "wide"}, f"{key} is 'wide'; allowed: a finite number") for key in ("setting", "low", "high")),
    ({"weights": []}, "1 to 64"),
    ({"weights": [0.0] * 65}, "1 to 64"),
    ({"weights": 1.0}, "1 to 64"),
    ({"weights": "1.5"}, "1 to 64"),
    ({"weights": [1e9]}, "no number from"),
    ({"low": 40.0}, "above low"),
    ({"low": 41.0}, "above low"),
    ({"high": -1.0}, "above low"),
    ({"memory": "relaxation"}, "above 0"),
    ({"memory": "relaxation", "setting": -2.0}, "above 0"),
    ({"memory": "period", "variable": "stroke"}, "above 0"),
    ({"memory": "step", "variable": "time"}, "one number"),
    ({"variable": "position", "memory": "maximum"}, "without a lag"),
    ({"variable": "position", "stage": "sensor"}, "without a lag"),
    *(({"stage": stage}, "does not know") for stage in ("drive", "tendon", "load_cell")),
    ({"gain": 2.0}, "gain is no key"),
    ({"Weights": [1.0]}, "Weights is no key"),
]


@pytest.mark.parametrize(("values", "word"), DAMAGES, ids=lambda value: str(value)[:40])
def test_a_damaged_law_is_refused_with_its_line_and_the_reason(reference_text, values, word):
    text = reference_text + law_text(**values)
    with pytest.raises(BadInput, match="damaged law") as refused:
        load_config_text(text, "bench.toml")
    found = re.search(r"bench\.toml:(\d+)", str(refused.value))
    assert word in str(refused.value)
    blamed = text.splitlines()[int(found[1]) - 1]
    key = word.split(" is")[0] if " is" in word else next(iter(values))
    assert blamed.startswith((key, "[corrections.unnamed_1]", "weights", "high", "setting", "variable"))


@pytest.mark.parametrize(
    "line", ["low = nan", "high = inf", "weights = [nan]", "weights = [true]", "weights = [[1.0]]"]
)
def test_what_is_no_number_is_refused_with_its_line(reference_text, line):
    key = line.split(" ")[0]
    text = reference_text + law_text([line], **{key: None})
    with pytest.raises(BadInput) as refused:
        load_config_text(text, "bench.toml")
    assert f"bench.toml:{len(text.splitlines())}" in str(refused.value)


def test_a_number_that_is_none_is_refused():
    with pytest.raises(BadInput, match="not a number"):
        build_effects({"backlash": {"width_mm": "wide"}})
