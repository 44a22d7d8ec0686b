"""From document to mechanics: units, signs, overrides, and what a joint is made of."""

import numpy as np
import pytest

from coast_cli.errors import BadInput
from coast_cli.spec.build import build, build_joint
from coast_cli.spec.digest import config_digest
from coast_cli.spec.load import REFERENCE, load_config, load_config_text

ONE_TUBE = """
[materials.m]
youngs_modulus_gpa = 40.0
density_kg_per_m3 = 6450.0
[middle]
material = "m"
outer_diameter_mm = 1.62
inner_diameter_mm = 1.40
notch = { cut_mm = 0.8, uncut_mm = 1.2 }
[[middle.samples]]
name = "A"
depth_mm = [1.36, 1.39, 1.42, 1.45]
notch.count = 4
[joint]
youngs_modulus_gpa = 40.0
pulley_friction = 0.0
notch_friction = 1.0
"""


def test_the_reference_in_si_units(reference):
    design = build(load_config(reference))
    outer, middle = design.tube("OT4"), design.tube("MT1")
    assert (outer.outer_radius, outer.inner_radius, outer.count) == (0.25e-3, 0.20e-3, 188)
    np.testing.assert_allclose(outer.depth, 0.4e-3)
    assert outer.youngs_modulus == 45e9
    assert outer.length == pytest.approx(0.1128)
    assert (outer.natural_curvature, middle.natural_curvature) == (1.1, -2.0)
    assert design.joint_pair == "OT4/MT1"
    joint = design.joint()
    assert (joint.deadband, joint.tendon.length, joint.tendon.radius) == pytest.approx((1.2e-3, 0.38868, 38e-6))


def test_the_shipped_reference_is_the_one_in_configs(reference):
    assert REFERENCE.read_bytes() == reference.read_bytes()


def test_a_sample_overrides_any_field_and_single_keys_of_its_notch():
    design = build(load_config_text(ONE_TUBE))
    tube = design.tube("A")
    np.testing.assert_allclose(tube.depth, [1.36e-3, 1.39e-3, 1.42e-3, 1.45e-3])
    assert (tube.count, tube.cut[0]) == (4, 0.8e-3)
    override = 'outer_diameter_mm = 2.0\nsection = "chord"\nnatural_curvature_per_m = 3\nend_effect = 0.1\nname = "A"'
    tube = build(load_config_text(ONE_TUBE.replace('name = "A"', override))).tube("A")
    assert (tube.outer_radius, tube.section, tube.natural_curvature) == (1e-3, "chord", -3.0)
    np.testing.assert_allclose(tube.end_length, 0.1e-3)


def test_a_joint_of_one_tube_needs_no_outer_tube_and_no_tendon():
    design = build(load_config_text(ONE_TUBE))
    assert design.joint_pair == "A"
    joint = design.joint()
    assert joint.outer is None
    assert joint.tendon is None
    assert joint.wrap_angle == np.pi


def test_the_end_effect_comes_from_the_table_of_solids(reference_text):
    text = reference_text.replace("natural_curvature_per_m = 0.8", 'end_effect = "table"')
    design = build(load_config_text(text))
    tube = design.tube("OT1")
    assert 0.0 < np.min(tube.end_length) < 0.5e-3
    assert tube.rigidity_series < build(load_config_text(reference_text)).tube("OT1").rigidity_series


def test_a_note_says_when_the_table_does_not_reach(reference_text):
    thin = reference_text.replace("inner_diameter_mm = 0.40", "inner_diameter_mm = 0.495", 1)
    design = build(load_config_text(thin.replace("natural_curvature_per_m = 0.8", 'end_effect = "table"')))
    assert any(note.startswith("OT1: ") for note in design.notes)


@pytest.mark.parametrize("pair", ["OT9/MT1", "MT1/OT4", "OT4", ""])
def test_a_pair_that_is_not_there(reference, pair):
    with pytest.raises(BadInput, match="pair: "):
        build(load_config(reference)).joint(pair)


def test_a_pair_that_does_not_nest_is_no_joint(edited):
    config = load_config(edited(('name = "MT1"', 'name = "MT1"\nouter_diameter_mm = 0.45')))
    with pytest.raises(BadInput, match=r"tubes\.toml:80:1: joint\.pair: the pair cannot be assembled: MT1"):
        build_joint(config, "OT4", "MT1")


def test_a_design_that_does_not_say_its_pair(edited):
    design = build(load_config(edited(('pair = "OT4/MT1"', ""))))
    assert design.joint_pair is None
    with pytest.raises(BadInput, match="which pair is meant"):
        design.joint()
    assert design.joint("OT1/MT2").outer.name == "OT1"


def test_a_configuration_without_a_joint(reference_text):
    start, end = reference_text.index("[joint]"), reference_text.index("[checks]")
    design = build(load_config_text(reference_text[:start] + reference_text[end:]))
    with pytest.raises(BadInput, match=r"no \[joint\] table"):
        design.joint("OT4/MT1")


def test_an_unknown_tube(reference):
    with pytest.raises(BadInput, match=r"OT5.*Did you mean"):
        build(load_config(reference)).tube("OT5")


def test_corrections_are_effects_of_the_joint_and_left_out_of_the_tubes(reference_text):
    design = build(load_config_text(reference_text + "\n[corrections.backlash]\nwidth_mm = 0.1\n"))
    assert [effect.id for effect in design.effects] == ["backlash"]
    assert "corrections backlash" in design.uncorrected[0]
    assert build(load_config_text(reference_text)).uncorrected == ()


def test_the_digest_is_of_what_is_said_not_of_how(reference_text):
    digest = config_digest(load_config_text(reference_text))
    bare = "\n".join(line.partition("#")[0] for line in reference_text.splitlines())
    assert config_digest(load_config_text(bare)) == digest
    assert config_digest(load_config_text(reference_text.replace("0.314", "0.315"))) != digest
